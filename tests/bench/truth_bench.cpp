// How near a reconstructed take of the simulated studio comes to what the simulator knows: the key's mattes, the closed
// surfaces, the geometry images, and pictures of them from where no camera stands.
//   truth_bench TAKE [--person alex] [--act walk] [--frames FIRST:END] [--every-frame] [--views DIR]
// One line a figure: the median over the frames, the worst frame, what is asked.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <string>

#include "capture/picture.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "playback/display/headless.h"
#include "playback/render/geometry_image_renderer.h"
#include "recon/frame_reconstruction.h"
#include "recon/hull/signed_silhouette.h"
#include "recon/sphere/resample.h"
#include "recon/take_studio.h"
#include "recon/video/geometry_video.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/frame_cache.h"
#include "simulator/studio/scene_renderer.h"
#include "simulator/studio/truth.h"
#include "tests/support/surface_distance.h"

namespace rotunda {
namespace {

constexpr std::size_t kPoints = 20000;  // on each surface
constexpr std::size_t kNovelViews = 2;

struct Figure {
  std::string name, unit, asked;
  bool more_is_better = false;
};
using Measured = std::map<std::string, std::vector<double>>;

const std::vector<Figure>& figures() {
  static const std::vector<Figure> all{
      {"matte IoU", "", ">= 0.96", true},
      {"matte edge bias", "px", "", false},
      {"matte edge error", "px", "", false},
      {"surface distance mean", "mm", "<= 10", false},
      {"surface distance p95", "mm", "<= 35", false},
      {"truth within 20 mm", "", ">= 0.88", true},
      {"true mattes distance mean", "mm", "", false},  // the same hull without the key's mistakes
      {"true mattes distance p95", "mm", "", false},
      {"geometry image distance mean", "mm", "<= 10", false},
      {"geometry image distance p95", "mm", "<= 35", false},
      {"novel view PSNR", "dB", "", true},
  };
  return all;
}

// Truth for each camera, then for the views where no camera stands.
std::vector<capture::CameraModel> with_novel_views(std::vector<capture::CameraModel> cameras) {
  const auto like = cameras.front();
  const Eigen::Vector3d target(0.0, 0.0, 0.95);
  for (std::size_t i = 0; i < kNovelViews; ++i) {
    const double azimuth = std::numbers::pi * (1.0 / 8.0 + static_cast<double>(i));  // between two of the ring's eight
    const Eigen::Vector3d eye(3.6 * std::cos(azimuth), 3.6 * std::sin(azimuth), 1.7);
    cameras.push_back(simulator::look_at(eye, target, like.width, like.height, like.K(0, 0), like.K(1, 1)));
  }
  return cameras;
}

void measure_matte(const cv::Mat& alpha, const cv::Mat& truth, Measured& measured) {
  const cv::Mat a = alpha > 127, b = truth > 127;
  measured["matte IoU"].push_back(static_cast<double>(cv::countNonZero(a & b)) / cv::countNonZero(a | b));
  // Along the true outline: how much farther out (positive) the key's lies. Beyond 3 px it is not a matter of edges.
  const cv::Mat ours = recon::signed_silhouette({alpha}), wanted = recon::signed_silhouette({truth});
  double sum = 0.0, sum_off = 0.0;
  int count = 0;
  for (int y = 0; y < ours.rows; ++y)
    for (int x = 0; x < ours.cols; ++x) {
      if (std::abs(wanted.at<float>(y, x)) > 0.7F) continue;
      const double off = std::clamp(static_cast<double>(ours.at<float>(y, x) - wanted.at<float>(y, x)), -3.0, 3.0);
      sum += off;
      sum_off += std::abs(off);
      ++count;
    }
  measured["matte edge bias"].push_back(sum / count);
  measured["matte edge error"].push_back(sum_off / count);
}

std::vector<double> distances(const recon::TriangleMesh& from, const recon::TriangleMesh& to) {
  const tests::DistanceTree tree(to);
  auto points = tests::points_on(from, kPoints);
  points.erase(points.begin(), points.begin() + static_cast<long>(from.positions.size()));  // area alone, no vertices
  std::vector<double> all;
  for (const auto& point : points) all.push_back(1e3 * tree.distance(point));
  return all;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Millimetres; of what both ways make together, as many points each.
void measure_surface(const std::string& name, const recon::TriangleMesh& ours, const recon::TriangleMesh& truth,
                     Measured& measured) {
  auto both = distances(truth, ours);
  const auto within = std::count_if(both.begin(), both.end(), [](double d) { return d <= 20.0; });
  if (name == "surface")
    measured["truth within 20 mm"].push_back(static_cast<double>(within) / static_cast<double>(both.size()));
  const auto back = distances(ours, truth);
  both.insert(both.end(), back.begin(), back.end());
  measured[name + " distance mean"].push_back(mean(both));
  measured[name + " distance p95"].push_back(quantile(both, 0.95));
}

// RGB before grey, straight alpha.
cv::Mat before_grey(const cv::Mat& rgb, const cv::Mat& alpha) {
  cv::Mat result(rgb.size(), CV_8UC3);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const double share = alpha.at<std::uint8_t>(y, x) / 255.0;
      for (int c = 0; c < 3; ++c)
        result.at<cv::Vec3b>(y, x)[c] =
            cv::saturate_cast<std::uint8_t>(share * rgb.at<cv::Vec3b>(y, x)[c] + (1.0 - share) * 128.0);
    }
  return result;
}

// Over the pixels that show the person in either. Returns both side by side.
cv::Mat measure_view(const cv::Mat& drawn, const simulator::ScenePicture& truth, Measured& measured) {
  cv::Mat rgb, alpha, side_by_side;
  cv::cvtColor(drawn, rgb, cv::COLOR_RGBA2RGB);
  cv::extractChannel(drawn, alpha, 3);
  const cv::Mat ours = before_grey(rgb, alpha), theirs = before_grey(truth.rgb, truth.matte);
  const cv::Mat either = (alpha > 127) | (truth.matte > 127);
  const double rms = cv::norm(ours, theirs, cv::NORM_L2, either) / std::sqrt(3.0 * cv::countNonZero(either));
  measured["novel view PSNR"].push_back(20.0 * std::log10(255.0 / rms));
  cv::hconcat(ours, theirs, side_by_side);
  return side_by_side;
}

struct Options {
  std::string take, person = "alex", act = "walk", frames, views;
  bool every_frame = false;
};

class TruthBench {
 public:
  explicit TruthBench(const Options& options)
      : performance_(simulator::make_performance({.person = options.person, .act = options.act})),
        views_(options.views),
        take_(options.take),
        studio_(recon::read_take_studio(take_, std::nullopt)),
        scene_(*performance_, with_novel_views(studio_.views.cameras)) {
    const auto video = recon::geometry_video_of(take_.folder());
    if (std::filesystem::exists(video)) video_.emplace(video);
    if (!views_.empty()) std::filesystem::create_directories(views_);
  }

  // False if the frame was not reconstructed.
  bool measure(std::size_t frame, Measured& measured) {
    const auto surface = recon::frame_surface(take_.folder(), frame);
    if (!surface) return false;
    const auto set = take_.read(frame);
    const auto exposure_start = exposure_start_of(set);
    const int act_frame = simulator::act_frame_at(exposure_start, performance_->frames());
    const auto pictures = scene_.pictures(simulator::act_seconds(act_frame), frame);
    measure_mattes(set, pictures, measured);
    const auto truth = simulator::truth_mesh(*performance_, exposure_start);
    measure_surface("surface", *surface, truth, measured);
    measure_hull_of_true_mattes(truth, pictures, measured);
    measure_geometry_image(frame, truth, pictures, measured);
    return true;
  }

  std::size_t frame_count() const { return take_.frame_set_count(); }
  double key_cpu_ms() const {
    for (const auto& cost : clock_.costs())
      if (cost.stage == "key") return cost.median_cpu_ms;
    return 0.0;
  }

 private:
  static capture::Timestamp exposure_start_of(const capture::FrameSet& set) {
    for (const auto& slot : set.slots)
      if (slot.frame) return slot.frame->exposure_start;
    throw InvalidInput("a frame set without a single frame has no truth");
  }

  void measure_mattes(const capture::FrameSet& set, const std::vector<simulator::ScenePicture>& pictures,
                      Measured& measured) {
    const auto views = recon::key_frame(set, studio_.views, {}, clock_);
    std::size_t view = 0;
    for (std::size_t camera = 0; camera < set.slots.size(); ++camera)
      if (set.slots[camera].frame) measure_matte(views.mattes[view++].alpha, pictures[camera].matte, measured);
  }

  void measure_hull_of_true_mattes(const recon::TriangleMesh& truth,
                                   const std::vector<simulator::ScenePicture>& pictures, Measured& measured) {
    std::vector<capture::Matte> mattes;
    for (std::size_t i = 0; i < studio_.views.cameras.size(); ++i) mattes.push_back({pictures[i].matte});
    const auto result =
        recon::reconstruct_surface(studio_.views.cameras, mattes, {.bounds = studio_.volume, .unit = studio_.unit});
    if (result.failure.empty()) measure_surface("true mattes", result.mesh, truth, measured);
  }

  void measure_geometry_image(std::size_t frame, const recon::TriangleMesh& truth,
                              const std::vector<simulator::ScenePicture>& pictures, Measured& measured) {
    if (!video_) return;
    const auto at = static_cast<std::int64_t>(frame) - video_->header().first_frame;
    if (at < 0 || at >= video_->frame_count()) return;
    const auto image = video_->read(static_cast<int>(at));
    measure_surface("geometry image", recon::remesh(image), truth, measured);
    for (auto i = studio_.views.cameras.size(); i < pictures.size(); ++i) {
      const auto drawn = playback::render_geometry_image(image, playback::viewpoint_of(scene_.cameras()[i]));
      const auto both = measure_view(drawn, pictures[i], measured);
      if (!views_.empty()) capture::write_png(views_ / fmt::format("frame{:06}-view{}.png", frame, i), both);
    }
  }

  std::unique_ptr<simulator::Performance> performance_;
  std::filesystem::path views_;  // folder for pictures of ours beside the truth; empty: none
  capture::TakeReader take_;
  recon::TakeStudio studio_;
  simulator::SceneRenderer scene_;
  playback::HeadlessDisplay display_;
  std::optional<recon::GeometryVideoReader> video_;
  recon::StageClock clock_;
};

void print(const Measured& measured) {
  for (const auto& figure : figures()) {
    const auto found = measured.find(figure.name);
    if (found == measured.end()) continue;
    const auto& values = found->second;
    const double worst = figure.more_is_better ? *std::min_element(values.begin(), values.end())
                                               : *std::max_element(values.begin(), values.end());
    fmt::print("{:<30} median {:8.3f} {:<3} worst {:8.3f}  asked {}\n", figure.name, quantile(values, 0.5), figure.unit,
               worst, figure.asked.empty() ? "-" : figure.asked);
  }
}

std::pair<std::size_t, std::size_t> range_of(const std::string& text, std::size_t count) {
  const auto colon = text.find(':');
  if (text.empty()) return {0, count};
  if (colon == std::string::npos) throw InvalidInput("--frames wants FIRST:END, not " + text);
  return {std::stoul(text.substr(0, colon)), std::min<std::size_t>(count, std::stoul(text.substr(colon + 1)))};
}

void run(const Options& options) {
  TruthBench bench(options);
  const auto [first, end] = range_of(options.frames, bench.frame_count());
  Measured all;
  int frames = 0;
  for (auto frame = first; frame < end; ++frame) {
    Measured of_frame;
    if (!bench.measure(frame, of_frame)) continue;
    ++frames;
    if (options.every_frame) {
      fmt::print("frame {}\n", frame);
      print(of_frame);
    }
    for (const auto& [name, values] : of_frame) all[name].insert(all[name].end(), values.begin(), values.end());
  }
  if (frames == 0) throw InvalidInput(options.take + " has no reconstructed frame; run rotunda recon on it");
  fmt::print("{} reconstructed frames of {}, key {:.1f} ms CPU a picture\n", frames, options.take, bench.key_cpu_ms());
  print(all);
}

}  // namespace
}  // namespace rotunda

int main(int argc, char** argv) {
  rotunda::playback::keep_scene_memory();
  rotunda::Options options;
  CLI::App app("How near a reconstructed take of the simulated studio comes to the truth", "truth_bench");
  app.add_option("take", options.take, "the take's folder")->required();
  app.add_option("--person", options.person, "who was before the cameras");
  app.add_option("--act", options.act, "doing what");
  app.add_option("--frames", options.frames, "FIRST:END; else all that are reconstructed");
  app.add_option("--views", options.views, "write the novel views here, ours left, truth right");
  app.add_flag("--every-frame", options.every_frame, "print each frame too");
  CLI11_PARSE(app, argc, argv);
  try {
    rotunda::run(options);
    return rotunda::kDone;
  } catch (...) {
    return rotunda::report_current_exception("truth_bench");
  }
}
