// How true the correspondence of aligned frames is: each sample's nearest point of the simulator's true surface at one
// frame is followed to the other frame, where the same sample's nearest point should be it.
//   match_bench align TAKE TRUTH [--joints JSON] [--sphere] [--frames FIRST:END]          a take in its own reference
//   match_bench pair TAKE TRUTH JSON FRAME TAKE TRUTH JSON FRAME               frames of two takes of one person
// TAKE: a reconstructed take of the simulated studio, with recon/frames; TRUTH: the truth that rotunda-sim wrote; JSON:
// what `rotunda mocap TAKE --joints JSON` wrote; without, surfaces are tracked from frame to frame. Baseline: each
// vertex of the first frame's surface goes to the nearest point of the next frame's that faces its way, frame by frame.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <map>
#include <numeric>
#include <string>

#include "config/errors.h"
#include "config/exit_code.h"
#include "config/median.h"
#include "recon/frame_store.h"
#include "recon/mesh/mesh_file.h"
#include "recon/sphere/resample.h"
#include "recon/track/surface_target.h"
#include "recon/video/geometry_video.h"
#include "recon/video/sequence_alignment.h"

namespace rotunda {
namespace {

namespace fs = std::filesystem;

struct Spread {
  double mean = 0.0, p95 = 0.0, within_50_mm = 0.0;
};

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  const auto within = std::upper_bound(values.begin(), values.end(), 0.05) - values.begin();
  return {1e3 * std::accumulate(values.begin(), values.end(), 0.0) / count,
          1e3 * values[static_cast<std::size_t>(0.95 * (count - 1.0))], static_cast<double>(within) / count};
}

double cpu_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

recon::TriangleMesh truth_mesh(const fs::path& truth, std::size_t frame) {
  auto mesh = recon::read_ply(truth / "meshes" / fmt::format("frame{:06}.ply", frame));
  recon::compute_normals(mesh);
  return mesh;
}

// Where samples lie on the truth: the truth's triangles have the same numbers in every frame.
constexpr std::size_t kStride = 4;  // of rows and columns

struct OnTruth {
  recon::TriangleMesh mesh;
  std::vector<std::optional<recon::SurfaceHit>> hits;
};

OnTruth on_truth(const recon::GeometryImage& image, recon::TriangleMesh truth) {
  constexpr double kGate = 0.1;
  OnTruth result{std::move(truth), {}};
  const recon::SurfaceTarget target(result.mesh);
  const auto side = static_cast<std::size_t>(image.side());
  for (std::size_t y = 0; y < side; y += kStride)
    for (std::size_t x = 0; x < side; x += kStride) {
      const auto at = y * side + x;
      result.hits.push_back(
          target.closest(image.positions[at].cast<double>(), image.normals[at].cast<double>(), kGate));
    }
  return result;
}

Eigen::Vector3d followed(const recon::SurfaceHit& hit, const recon::TriangleMesh& to) {
  const auto& t = to.triangles[hit.sample.triangle];
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    point += hit.sample.barycentric[i] * to.positions[t[static_cast<std::size_t>(i)]].cast<double>();
  return point;
}

// Metres, on the true surface at `b`.
std::vector<double> errors(const OnTruth& a, const OnTruth& b) {
  std::vector<double> result;
  for (std::size_t i = 0; i < a.hits.size(); ++i)
    if (a.hits[i] && b.hits[i]) result.push_back((followed(*a.hits[i], b.mesh) - b.hits[i]->point).norm());
  return result;
}

// What is left if correspondence were perfect but for the surfaces: the true point, laid on the reconstructed surface,
// told by its nearest point of the truth.
std::vector<double> floor_of(const OnTruth& a, const OnTruth& b, const recon::GeometryImage& image_b) {
  constexpr double kGate = 0.1;
  const auto surface = recon::remesh(image_b);
  const recon::SurfaceTarget on_surface(surface), on_mesh(b.mesh);
  std::vector<double> result;
  for (const auto& hit : a.hits) {
    if (!hit) continue;
    const auto truth = followed(*hit, b.mesh);
    const auto& t = b.mesh.triangles[hit->sample.triangle];
    const Eigen::Vector3d normal = b.mesh.normals[t[0]].cast<double>();
    const auto laid = on_surface.closest(truth, normal, kGate);
    if (!laid) continue;
    const auto back = on_mesh.closest(laid->point, laid->normal, kGate);
    if (back) result.push_back((back->point - truth).norm());
  }
  return result;
}

// Grey where a sample has kept its place on the body since `a`, red where it is 50 mm or more away, blue: nobody knows.
recon::GeometryImage error_picture(recon::GeometryImage image, const OnTruth& a, const OnTruth& b) {
  image.colour_level = image.level;
  image.colours.assign(image.positions.size(), {});
  image.coverage.assign(image.positions.size(), 255);
  const Eigen::Vector3f light = Eigen::Vector3f(1.0F, 1.0F, 1.5F).normalized();
  const auto side = static_cast<std::size_t>(image.side()), coarse = (side - 1) / kStride + 1;
  for (std::size_t i = 0; i < image.colours.size(); ++i) {
    const auto at = i / side / kStride * coarse + i % side / kStride;
    const float shade = 140.0F + 100.0F * image.normals[i].dot(light);
    if (!a.hits[at] || !b.hits[at]) {
      image.colours[i] = {0, 0, static_cast<std::uint8_t>(shade)};
      continue;
    }
    const double error = (followed(*a.hits[at], b.mesh) - b.hits[at]->point).norm();
    const auto rest = static_cast<std::uint8_t>(shade * std::max(0.0, 1.0 - error / 0.05));
    image.colours[i] = {static_cast<std::uint8_t>(shade), rest, rest};
  }
  return image;
}

struct Arguments {
  std::string take, truth, frames = "0:1000", joints, clip;
  recon::MatchingOptions matching{.most_updates = 200, .one_by_one = true};
  bool baseline = false, sphere = false, own_maps = false;
};

void print(const std::string& what, const Spread& spread, const std::string& asked) {
  fmt::print("{:<36} mean {:6.2f} mm  p95 {:6.2f} mm  within 50 mm {:6.2f} %   {}\n", what, spread.mean, spread.p95,
             1e2 * spread.within_50_mm, asked);
}

// A take's frames, and who was found in them.
class Take {
 public:
  Take(const std::string& folder, std::string truth, const std::string& joints)
      : store_(recon::FrameStore::folder_of(folder)), truth_(std::move(truth)) {
    if (!store_.finished(0)) throw InvalidInput(folder + ": no reconstructed frames; run rotunda recon first");
    if (!joints.empty()) track_ = recon::steadied(recon::read_joints_json(joints));
  }

  const std::optional<recon::BodyTrack>& track() const { return track_; }
  std::size_t end() const {
    std::size_t end = 0;
    while (store_.finished(end)) ++end;
    return end;
  }
  std::optional<recon::MappedSurface> mapped(std::size_t frame) const {
    if (!store_.finished(frame) || store_.failure(frame)) return std::nullopt;
    return store_.surface(frame);
  }
  std::optional<recon::GeometryImage> image(std::size_t frame) const {
    if (!store_.finished(frame) || store_.failure(frame)) return std::nullopt;
    return store_.image(frame);
  }
  std::optional<recon::TriangleMesh> surface(std::size_t frame) const {
    auto surface = mapped(frame);
    if (!surface) return std::nullopt;
    return std::move(surface->mesh);
  }
  OnTruth on_truth(const recon::GeometryImage& image, std::size_t frame) const {
    return rotunda::on_truth(image, truth_mesh(truth_, frame));
  }
  recon::AlignmentReference reference() const {
    const double begun = cpu_s();
    auto found = recon::body_reference(*track_, 8, [&](std::size_t i) { return surface(track_->first_frame + i); });
    if (!found) throw InvalidInput("no frame of the take is reconstructed");
    fmt::print("reference: {} triangles, {:.1f} CPU s\n", found->surface.mesh.triangles.size(), cpu_s() - begun);
    return *found;
  }
  recon::AlignedFrame align(const recon::BodyCarrier& carrier, std::size_t frame) const {
    const auto mesh = surface(frame);
    const auto pose = track_->pose(frame);
    if (!mesh || !pose) throw InvalidInput(fmt::format("frame {} has no surface or no pose", frame));
    return carrier.align(*mesh, track_->body.skeleton, *pose);
  }

 private:
  recon::FrameStore store_;
  std::string truth_;
  std::optional<recon::BodyTrack> track_;
};

// What is told of a sequence of aligned frames.
class Score {
 public:
  Score(const Take& take, std::string clip) : take_(take), clip_file_(std::move(clip)) { start_clock(); }

  void add(std::size_t frame, const recon::AlignedFrame& aligned) {
    cpu_.push_back(cpu_s() - cpu_begun_);
    wall_.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count());
    fmt::print("frame {} residual {:.1f} / {:.1f} mm stretch {:.2f} folds {} {:.2f} CPU s {:.2f} s\n", frame,
               aligned.residual_mean_mm, aligned.residual_p95_mm, aligned.stretch_p95, aligned.folds, cpu_.back(),
               wall_.back());
    std::fflush(stdout);
    folds_ += aligned.folds;
    places_.emplace(frame, take_.on_truth(aligned.image, frame));
    for (const auto& hit : places_.at(frame).hits)
      if (hit) from_truth_.push_back(hit->distance);
    const auto before = places_.find(frame - 1);
    if (before != places_.end() && floor_.size() < 30000) {
      const auto more = floor_of(before->second, places_.at(frame), aligned.image);
      floor_.insert(floor_.end(), more.begin(), more.end());
    }
    if (!clip_file_.empty()) clip_.emplace(frame, aligned.image);
    start_clock();
  }

  void print() const {
    std::vector<double> consecutive, whole;
    for (auto at = places_.begin(); std::next(at) != places_.end(); ++at) {
      const auto more = errors(at->second, std::next(at)->second);
      consecutive.insert(consecutive.end(), more.begin(), more.end());
    }
    double worst = 0.0;
    for (auto at = std::next(places_.begin()); at != places_.end(); ++at) {
      const auto more = errors(places_.begin()->second, at->second);
      worst = std::max(worst, spread_of(more).mean);
      whole.insert(whole.end(), more.begin(), more.end());
    }
    rotunda::print("surface, from the true one", spread_of(from_truth_), "");
    rotunda::print("were it perfect on these surfaces", spread_of(floor_), "consecutive frames");
    rotunda::print("consecutive frames", spread_of(consecutive), "asked <= 6 / 15");
    rotunda::print("first to any frame", spread_of(whole), "asked <= 12 / 35");
    fmt::print("worst frame {:.2f} mm, folds {}, a frame (median) {:.2f} s wall, {:.2f} CPU s\n", worst, folds_,
               median(wall_), median(cpu_));
    write_clip();
  }

 private:
  void start_clock() {
    cpu_begun_ = cpu_s();
    begun_ = std::chrono::steady_clock::now();
  }
  void write_clip() const {
    if (clip_file_.empty()) return;
    std::vector<recon::GeometryImage> images;
    for (const auto& [frame, image] : clip_)
      images.push_back(error_picture(image, places_.begin()->second, places_.at(frame)));
    recon::write_geometry_video(clip_file_, images);
  }

  const Take& take_;
  std::string clip_file_;
  std::map<std::size_t, OnTruth> places_;
  std::map<std::size_t, recon::GeometryImage> clip_;
  std::vector<double> floor_, from_truth_, cpu_, wall_;
  std::size_t folds_ = 0;
  double cpu_begun_ = 0.0;
  std::chrono::steady_clock::time_point begun_;
};

void carry_by_nearest_points(const Take& take, std::size_t first, std::size_t end, Score& score) {
  auto start = take.mapped(first);
  if (!start) throw InvalidInput(fmt::format("frame {} has no surface", first));
  recon::KeyFrame key{.frame = 0, .reference = {.surface = *start, .lattice = {}, .body = {}}};
  key.reference = recon::key_reference(1, 8, [&](std::size_t) { return start; })->reference;
  auto mesh = key.reference.surface.mesh;
  for (auto frame = first; frame < end; ++frame) {
    auto surface = take.surface(frame);
    if (!surface) continue;
    recon::compute_normals(*surface);
    const recon::SurfaceTarget target(*surface);
    constexpr double kAnywhere = 1.0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const auto hit = target.closest(mesh.positions[v].cast<double>(), mesh.normals[v].cast<double>(), kAnywhere);
      if (hit) mesh.positions[v] = hit->point.cast<float>();
    }
    recon::compute_normals(mesh);
    score.add(frame, {.surface = mesh, .image = recon::resample(mesh, start->map, key.reference.lattice)});
  }
}

int align(const Arguments& arguments) {
  const Take take(arguments.take, arguments.truth, arguments.joints);
  std::size_t first = 0, end = 0;
  if (std::sscanf(arguments.frames.c_str(), "%zu:%zu", &first, &end) != 2) throw InvalidInput("--frames A:B");
  end = std::min(end, take.end());
  if (arguments.baseline) {
    Score score(take, arguments.clip);
    carry_by_nearest_points(take, first, end, score);
    score.print();
  } else if (arguments.own_maps) {
    Score score(take, arguments.clip);
    for (auto frame = first; frame < end; ++frame)
      if (const auto image = take.image(frame)) score.add(frame, {.surface = recon::remesh(*image), .image = *image});
    score.print();
  } else if (arguments.sphere) {
    Score score(take, arguments.clip);
    recon::match_sequence(
        end - first, std::nullopt, arguments.matching, [&](std::size_t i) { return take.image(first + i); },
        [&](std::size_t i, const recon::AlignedFrame& frame) { score.add(first + i, frame); });
    score.print();
  } else if (take.track()) {
    const auto reference = take.reference();
    const recon::BodyCarrier carrier(reference);
    Score score(take, arguments.clip);
    for (auto frame = first; frame < end; ++frame) score.add(frame, take.align(carrier, frame));
    score.print();
  } else {
    const auto key = recon::key_reference(end - first, 8, [&](std::size_t i) { return take.mapped(first + i); });
    if (!key) throw InvalidInput("no frame of the take is reconstructed");
    Score score(take, arguments.clip);
    recon::track_sequence(
        end - first, *key, [&](std::size_t i) { return take.surface(first + i); },
        [&](std::size_t i, const recon::AlignedFrame& frame) { score.add(first + i, frame); });
    score.print();
  }
  return 0;
}

struct PairArguments {
  std::string from, from_truth, from_joints, to, to_truth, to_joints;
  std::vector<std::size_t> from_frames, to_frames;
};

// Farther than half a metre, which no slide along a limb is: on another limb.
double swapped(const std::vector<double>& errors) {
  const auto far = std::count_if(errors.begin(), errors.end(), [](double error) { return error > 0.5; });
  return static_cast<double>(far) / static_cast<double>(errors.size());
}

int pair(const PairArguments& arguments) {
  const Take from(arguments.from, arguments.from_truth, arguments.from_joints),
      to(arguments.to, arguments.to_truth, arguments.to_joints);
  const auto reference = from.reference();
  const recon::BodyCarrier carrier(reference);
  for (std::size_t i = 0; i < std::min(arguments.from_frames.size(), arguments.to_frames.size()); ++i) {
    const auto a = arguments.from_frames[i], b = arguments.to_frames[i];
    const auto begun = std::chrono::steady_clock::now();
    const auto image_a = from.align(carrier, a), image_b = to.align(carrier, b);
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    const auto on_a = from.on_truth(image_a.image, a), on_b = to.on_truth(image_b.image, b);
    const auto all = errors(on_a, on_b);
    print(fmt::format("{} with {}", a, b), spread_of(all),
          fmt::format("swapped {:.2f} %, folds {}, {:.2f} s", 1e2 * swapped(all), image_a.folds + image_b.folds, wall));
    print("  were it perfect on this surface", spread_of(floor_of(on_a, on_b, image_b.image)), "");
  }
  return 0;
}

}  // namespace
}  // namespace rotunda

int main(int argc, char** argv) {
  CLI::App app("Correspondence of aligned frames against the simulator's truth.");
  rotunda::Arguments arguments;
  auto* align = app.add_subcommand("align", "a whole take");
  align->add_option("take", arguments.take, "the take's folder")->required();
  align->add_option("truth", arguments.truth, "the truth's folder")->required();
  align->add_option("--frames", arguments.frames, "FIRST:END");
  align->add_option("--joints", arguments.joints, "what rotunda mocap --joints wrote");
  align->add_option("--clip", arguments.clip, "write a geometry video whose colours are errors since the first frame");
  align->add_flag("--baseline", arguments.baseline, "nearest points from frame to frame");
  align->add_option("--lambda", arguments.matching.regularity, "of --sphere, eq. (4)")->capture_default_str();
  align->add_option("--updates", arguments.matching.most_updates, "of a level of --sphere")->capture_default_str();
  align->add_flag("!--side-by-side", arguments.matching.one_by_one, "--sphere moves samples on all cores");
  align->add_flag("--own-maps", arguments.own_maps, "each frame as it was mapped, turned to the one before");
  align->add_flag("--sphere", arguments.sphere, "spherical matching from frame to frame, as the first paper has it");
  rotunda::PairArguments pair_arguments;
  auto* pair = app.add_subcommand("pair", "frames of two takes of one person, in the first's reference");
  pair->add_option("from", pair_arguments.from)->required();
  pair->add_option("from_truth", pair_arguments.from_truth)->required();
  pair->add_option("from_joints", pair_arguments.from_joints)->required();
  pair->add_option("to", pair_arguments.to)->required();
  pair->add_option("to_truth", pair_arguments.to_truth)->required();
  pair->add_option("to_joints", pair_arguments.to_joints)->required();
  pair->add_option("--from-frames", pair_arguments.from_frames)->required();
  pair->add_option("--to-frames", pair_arguments.to_frames)->required();
  app.require_subcommand(1);
  CLI11_PARSE(app, argc, argv);
  try {
    return pair->parsed() ? rotunda::pair(pair_arguments) : rotunda::align(arguments);
  } catch (const std::exception& e) {
    fmt::print(stderr, "match_bench: {}\n", e.what());
    return rotunda::kBadInput;
  }
}
