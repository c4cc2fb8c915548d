// How good a picture from where no camera stands is, of simulated people with every flaw of studio, lens and sensor,
// through the real key and the real surface:
//   view_bench [--person NAME]... [--act NAME]... [--frame N]... [--pictures DIR]
// Held-out cameras stand between the ring's; beside them one camera of the ring is left out, of surface and colours.
// PSNR and SSIM in the box of the true silhouette, over black outside of it: against what the held-out camera gave,
// which has noise, and the backdrop mixed into its edges, and against the figures alone. The table: the surface of true
// mattes with the blend, ours with its stored colours and with the blend, and the true surface: how much is left to
// gain.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>

#include "capture/matte/chroma_key.h"
#include "capture/matte/stage_mask.h"
#include "capture/picture.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "playback/display/headless.h"
#include "playback/render/mesh_renderer.h"
#include "playback/render/orbit_film.h"
#include "playback/render/view_dependent_renderer.h"
#include "recon/frame_reconstruction.h"
#include "recon/hull/matte_support.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/light.h"
#include "simulator/studio/pixel_encoding.h"
#include "simulator/studio/scene_renderer.h"
#include "simulator/studio/truth.h"
#include "tests/bench/picture_score.h"

namespace rotunda::bench {
namespace {

using recon::FrameViews;
using recon::TriangleMesh;

constexpr std::size_t kHeldOut = 3;  // cameras
constexpr std::size_t kLeftOut = 2;  // of the ring: its place in the layout
constexpr int kSupersampling = 2;    // as `rotunda render` draws

struct Options {
  std::vector<std::string> people{"alex", "carla"}, acts{"walk", "capoeira"};
  std::vector<int> frames{7, 31};
  std::string pictures;
  double angle_power = playback::ViewDependentOptions{}.angle_power;
};

std::vector<capture::CameraModel> with_held_out(std::vector<capture::CameraModel> cameras) {
  const auto like = cameras.front();
  const double ring = like.centre().head<2>().norm();
  for (std::size_t i = 0; i < kHeldOut; ++i) {
    const double azimuth = std::numbers::pi * (1.0 / 8.0 + 0.5 * static_cast<double>(i));
    const Eigen::Vector3d eye(ring * std::cos(azimuth), ring * std::sin(azimuth), 1.3 + 0.3 * static_cast<double>(i));
    cameras.push_back(simulator::look_at(eye, {0.0, 0.0, 0.95}, like.width, like.height, like.K(0, 0), like.K(1, 1)));
    cameras.back().name = fmt::format("held{}", i);
  }
  return cameras;
}

cv::Mat over_black(const cv::Mat& rgb, const cv::Mat& alpha) {
  cv::Mat result(rgb.size(), CV_8UC3);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x)
      for (int c = 0; c < 3; ++c)
        result.at<cv::Vec3b>(y, x)[c] =
            cv::saturate_cast<std::uint8_t>(rgb.at<cv::Vec3b>(y, x)[c] * alpha.at<std::uint8_t>(y, x) / 255.0);
  return result;
}

cv::Mat over_black(const cv::Mat& rgba) {
  cv::Mat rgb, alpha;
  cv::cvtColor(rgba, rgb, cv::COLOR_RGBA2RGB);
  cv::extractChannel(rgba, alpha, 3);
  return over_black(rgb, alpha);
}

// A moment before all cameras, the held-out ones last.
struct Seen {
  std::vector<simulator::ScenePicture> pictures;
  std::vector<cv::Mat> alone;  // figures without noise and backdrop, of cameras that pictures are judged by
};

struct Score {
  double psnr, ssim;              // against the camera's picture
  double psnr_alone, ssim_alone;  // against the figures alone
};

class ViewBench {
 public:
  explicit ViewBench(Options options) : options_(std::move(options)), cameras_(simulator::camera_layout()) {}

  void run() {
    for (const auto& person : options_.people)
      for (const auto& act : options_.acts) run(person, act);
    fmt::print("{:<44} {:>8}   {:<24}   {:<24}\n", "PSNR / SSIM", "pictures", "as the camera gave them",
               "the figures alone");
    for (const auto& [name, scores] : scores_) {
      const auto mean = [&](double Score::*of) {
        double sum = 0.0;
        for (const auto& score : scores) sum += score.*of;
        return sum / static_cast<double>(scores.size());
      };
      fmt::print("{:<44} {:>8}   {:>8.2f} dB / {:<12.3f}   {:>8.2f} dB / {:<12.3f}\n", name, scores.size(),
                 mean(&Score::psnr), mean(&Score::ssim), mean(&Score::psnr_alone), mean(&Score::ssim_alone));
    }
  }

 private:
  void run(const std::string& person, const std::string& act) {
    const auto performance = simulator::make_performance({.person = person, .act = act});
    const simulator::SceneRenderer studio(*performance, with_held_out(cameras_));
    std::vector<cv::Mat> plates;
    for (std::size_t i = 0; i < cameras_.size(); ++i) plates.push_back(capture::to_rgb(as_sent(studio.clean_plate(i))));
    for (const int frame : options_.frames) {
      const double seconds = simulator::act_seconds(frame);
      const auto pictures = studio.pictures(seconds, static_cast<std::uint64_t>(frame));
      std::vector<cv::Mat> alone(pictures.size());
      for (std::size_t i = 0; i < alone.size(); ++i)
        if (i == kLeftOut || i >= cameras_.size()) alone[i] = studio.figures_alone(i, seconds, simulator::kWallGlow);
      const auto views = keyed(pictures, plates);
      what_ = fmt::format("{}-{}-{}", person, act, frame);
      measure({pictures, alone}, views, performance->surfaces_at(seconds).front());
    }
  }

  static capture::Image as_sent(const cv::Mat& picture) {
    return capture::make_image(picture.cols, picture.rows, capture::PixelFormat::bayer_rg8,
                               simulator::encode_pixels(picture, capture::PixelFormat::bayer_rg8));
  }

  FrameViews keyed(const std::vector<simulator::ScenePicture>& pictures, const std::vector<cv::Mat>& plates) const {
    FrameViews views;
    views.cameras = cameras_;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      views.images.push_back(as_sent(pictures[i].deep));
      views.pictures.push_back(capture::to_rgb(views.images.back()));
      const cv::Mat stage = capture::stage_mask(cameras_[i], simulator::kStageVolume);
      views.mattes.push_back(capture::chroma_key(views.pictures.back(), {.backdrop = {}, .stage = stage}, plates[i]));
    }
    views.mattes = recon::supported_mattes(cameras_, views.mattes, {.bounds = simulator::kStageVolume}).mattes;
    return views;
  }

  static FrameViews without(FrameViews views, std::size_t camera) {
    const auto at = static_cast<std::ptrdiff_t>(camera);
    views.cameras.erase(views.cameras.begin() + at);
    views.images.erase(views.images.begin() + at);
    views.pictures.erase(views.pictures.begin() + at);
    views.mattes.erase(views.mattes.begin() + at);
    return views;
  }

  TriangleMesh surface_of(const FrameViews& views) {
    auto result = recon::reconstruct_surface(recon::silhouette_views(views.cameras, views.mattes), views.pictures,
                                             {.bounds = simulator::kStageVolume});
    if (!result.failure.empty()) throw InvalidInput(what_ + ": " + result.failure);
    recon::colour_vertices(result.mesh, views, clock_);
    return std::move(result.mesh);
  }

  void measure(const Seen& seen, const FrameViews& views, TriangleMesh truth) {
    FrameViews ideal = views;
    for (std::size_t i = 0; i < cameras_.size(); ++i) ideal.mattes[i] = {seen.pictures[i].matte};
    const auto ours = surface_of(views);
    const auto hull = surface_of(ideal);
    recon::colour_vertices(truth, views, clock_);
    const auto all = with_held_out(cameras_);
    for (std::size_t i = cameras_.size(); i < all.size(); ++i) {
      score("1 true mattes' surface, blended", draw(hull, views, all[i]), seen, i, {});
      score("2 our surface, stored colours", draw_stored(ours, all[i]), seen, i, "stored " + all[i].name);
      score("3 our surface, blended", draw(ours, views, all[i]), seen, i, "blended " + all[i].name);
      score("4 true surface, blended", draw(truth, views, all[i]), seen, i, {});
    }
    const auto fewer = without(views, kLeftOut);
    const auto nine = surface_of(fewer);
    score("5 a ring camera left out, stored colours", draw_stored(nine, cameras_[kLeftOut]), seen, kLeftOut, {});
    score("6 a ring camera left out, blended", draw(nine, fewer, cameras_[kLeftOut]), seen, kLeftOut,
          "left out " + cameras_[kLeftOut].name);
  }

  cv::Mat draw(const TriangleMesh& surface, const FrameViews& views, const capture::CameraModel& camera) {
    const auto sources = playback::source_views(views);
    const auto viewpoint = playback::magnified(playback::viewpoint_of(camera), kSupersampling);
    const playback::RenderTarget target(viewpoint.width, viewpoint.height);
    playback::ViewDependentRenderer renderer({.angle_power = options_.angle_power});
    renderer.upload(surface, sources);
    target.bind();
    playback::clear(std::nullopt);
    renderer.draw(viewpoint);
    return playback::reduce(target.read_rgba(), kSupersampling);
  }

  static cv::Mat draw_stored(const TriangleMesh& surface, const capture::CameraModel& camera) {
    const auto viewpoint = playback::magnified(playback::viewpoint_of(camera), kSupersampling);
    return playback::reduce(playback::render_mesh(surface, viewpoint), kSupersampling);
  }

  void score(const std::string& name, const cv::Mat& drawn, const Seen& seen, std::size_t camera,
             const std::string& picture) {
    const auto& truth = seen.pictures[camera];
    const cv::Rect box = cv::boundingRect(truth.matte >= 128);
    const cv::Mat ours = over_black(drawn)(box), theirs = over_black(truth.rgb, truth.matte)(box);
    const cv::Mat alone = over_black(seen.alone[camera], truth.matte)(box);
    scores_[name].push_back({psnr(ours, theirs), ssim(ours, theirs), psnr(ours, alone), ssim(ours, alone)});
    if (picture.empty() || options_.pictures.empty()) return;
    cv::Mat both;
    cv::hconcat(ours, theirs, both);
    capture::write_png(std::filesystem::path(options_.pictures) / fmt::format("{} {}.png", what_, picture), both);
  }

  Options options_;
  std::vector<capture::CameraModel> cameras_;
  playback::HeadlessDisplay display_;
  recon::StageClock clock_;
  std::string what_;
  std::map<std::string, std::vector<Score>> scores_;
};

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Pictures from where no camera stands against the simulator's truth", "view_bench");
  app.add_option("--person", options.people, "who")->capture_default_str();
  app.add_option("--act", options.acts, "doing what")->capture_default_str();
  app.add_option("--frame", options.frames, "of the act")->capture_default_str();
  app.add_option("--pictures", options.pictures, "write ours beside the truth into this folder");
  app.add_option("--angle-power", options.angle_power, "of the blend")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    if (!options.pictures.empty()) std::filesystem::create_directories(options.pictures);
    ViewBench(options).run();
    return kDone;
  } catch (...) {
    return report_current_exception("view_bench");
  }
}

}  // namespace
}  // namespace rotunda::bench

int main(int argc, char** argv) {
  rotunda::playback::keep_scene_memory();
  return rotunda::bench::run(argc, argv);
}
