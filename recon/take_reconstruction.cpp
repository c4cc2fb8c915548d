#include "recon/take_reconstruction.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <mutex>
#include <nlohmann/json.hpp>

#include "capture/picture.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "recon/alignment_store.h"
#include "recon/frame_reconstruction.h"
#include "recon/frame_report.h"
#include "recon/mesh/mesh_file.h"
#include "recon/neighbour_mattes.h"
#include "recon/take_cameras.h"
#include "recon/take_plates.h"
#include "recon/take_studio.h"
#include "recon/video/geometry_video.h"
#include "recon/video/paper_video.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

double process_cpu_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

// One take's reconstruction: the fixed settings, and the few things that frames share while they are worked on.
class TakeReconstruction {
 public:
  TakeReconstruction(const TakeReconstructionOptions& options,
                     const std::function<void(std::size_t, std::size_t)>& tell, std::stop_token stop);
  TakeReconstructionReport run();

 private:
  struct Work {
    std::size_t frame = 0;
    FrameViews views;
    MappedFrame mapped;
  };

  void choose_frames();
  void check_cameras();
  std::string settings_json() const;
  void reconstruct_frames();
  Work begin(std::size_t frame);
  void align_to_previous(Work& work);
  void finish(Work& work);
  void export_mattes(const capture::FrameSet& set, const FrameViews& views, std::size_t frame) const;
  void count_finished();
  void export_mesh(std::size_t frame, const TriangleMesh& mesh) const;
  void export_resumed(std::size_t frame);
  std::vector<std::size_t> mapped_frames() const;
  void align_frames();
  GeometryImage image(std::size_t frame) const;
  GeometryImage image_or_between(std::size_t frame, const std::vector<std::size_t>& mapped) const;
  void write_video();

  const TakeReconstructionOptions& options_;
  const std::function<void(std::size_t, std::size_t)>& tell_;
  std::stop_token stop_;
  capture::TakeReader take_;
  TakeStudio studio_;
  SurfaceOptions surface_options_;
  std::size_t first_ = 0, end_ = 0;
  std::optional<FrameStore> store_;
  StageClock clock_;
  std::optional<NeighbourMattes> neighbours_;
  std::optional<MappedSurface> previous_;  // of the last mapped frame, in order
  std::mutex done_mutex_;
  std::size_t done_ = 0;
  TakeReconstructionReport report_;
};

TakeReconstruction::TakeReconstruction(const TakeReconstructionOptions& options,
                                       const std::function<void(std::size_t, std::size_t)>& tell, std::stop_token stop)
    : options_(options),
      tell_(tell),
      stop_(std::move(stop)),
      take_(options.take),
      studio_(read_take_studio(take_, options.calibration)) {
  surface_options_.bounds = studio_.volume;
  surface_options_.unit = studio_.unit;
  surface_options_.cell_size = options_.cell_size;
  surface_options_.triangles = options_.triangles;
  surface_options_.paper = options_.paper;
  surface_options_.tolerate_misses = options_.tolerate_misses;
  surface_options_.performer_at = options_.performer_at;
  surface_options_.tied_litres = options_.tied_litres;
  if (options_.quality == Quality::live) surface_options_ = live_surface(surface_options_);
  choose_frames();
  store_.emplace(FrameStore::folder_of(take_.folder()), settings_json());
}

void TakeReconstruction::choose_frames() {
  const auto count = take_.frame_set_count();
  std::tie(first_, end_) = options_.frames.value_or(std::pair<std::size_t, std::size_t>{0, count});
  end_ = std::min(end_, count);
  if (first_ >= end_)
    throw InvalidInput(
        fmt::format("take {} has the frames 0:{}; none of them are asked for", take_.info().name, count));
  report_.frames = end_ - first_;
}

std::string TakeReconstruction::settings_json() const {
  nlohmann::json cameras = nlohmann::json::array();
  for (const auto& camera : studio_.views.cameras) {
    std::vector<double> numbers(camera.K.data(), camera.K.data() + 9);
    numbers.insert(numbers.end(), camera.R.data(), camera.R.data() + 9);
    numbers.insert(numbers.end(), camera.t.data(), camera.t.data() + 3);
    numbers.insert(numbers.end(), camera.distortion.data(), camera.distortion.data() + 5);
    cameras.push_back(numbers);
  }
  nlohmann::json settings{{"version", 6},
                          {"quality", options_.quality == Quality::live ? "live" : "full"},
                          {"paper", options_.paper},
                          {"tolerate_misses", options_.tolerate_misses},
                          {"cell_size", options_.cell_size},
                          {"triangles", options_.triangles},
                          {"level", options_.level},
                          {"colour_level", options_.colour_level},
                          {"cameras", cameras}};
  if (options_.performer_at) settings["performer_at"] = {options_.performer_at->x(), options_.performer_at->y()};
  if (options_.tied_litres > 0.0) settings["tied_litres"] = options_.tied_litres;
  for (const auto& matrix : studio_.views.colour)
    settings["colour"].push_back(std::vector<double>(matrix.data(), matrix.data() + 9));
  return settings.dump();
}

TakeReconstructionReport TakeReconstruction::run() {
  const auto begun = std::chrono::steady_clock::now();
  const double cpu_begun = process_cpu_s();
  reconstruct_frames();
  report_.interrupted = stop_.stop_requested();
  for (std::size_t frame = first_; frame < end_; ++frame)
    if (const auto reason = store_->failure(frame)) report_.failed.push_back({frame, *reason});
  report_.mapped = mapped_frames().size();
  if (!report_.interrupted && report_.mapped > 0 && options_.align != Alignment::none) align_frames();
  report_.interrupted = stop_.stop_requested();
  if (!report_.interrupted && report_.mapped > 0) clock_.run("encode", [&] { write_video(); });
  report_.stages = clock_.costs();
  report_.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  report_.cpu_s = process_cpu_s() - cpu_begun;
  return report_;
}

// Frames are worked on side by side, each on one thread; only the turn of a sphere map to the previous frame's goes in
// the frames' order.
void TakeReconstruction::reconstruct_frames() {
  const auto jobs = static_cast<std::size_t>(options_.jobs > 0 ? options_.jobs : tbb::info::default_concurrency());
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, jobs);
  clock_.run("plates", [&] { learn_missing_plates(take_, studio_.views); });
  clock_.run("cameras", [&] { check_cameras(); });
  if (options_.quality == Quality::live) make_live_keys(take_, studio_.views);
  neighbours_.emplace(take_, studio_.views, clock_, jobs);
  std::size_t next = first_;
  const auto source = [&](tbb::flow_control& control) -> std::size_t {
    for (; next < end_ && !stop_.stop_requested() && store_->finished(next); ++next) {
      ++report_.resumed;
      export_resumed(next);
      count_finished();
    }
    if (next < end_ && !stop_.stop_requested()) return next++;
    control.stop();
    return end_;
  };
  const auto alone = [](auto&& work) {  // nested loops stay on this thread: the frame's CPU time is all its own
    tbb::task_arena arena(1, 1);
    return arena.execute(work);
  };
  tbb::parallel_pipeline(
      jobs + 1,
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, source) &
          tbb::make_filter<std::size_t, std::shared_ptr<Work>>(
              tbb::filter_mode::parallel,
              [&](std::size_t frame) { return std::make_shared<Work>(alone([&] { return begin(frame); })); }) &
          tbb::make_filter<std::shared_ptr<Work>, std::shared_ptr<Work>>(tbb::filter_mode::serial_in_order,
                                                                         [&](std::shared_ptr<Work> work) {
                                                                           alone([&] { align_to_previous(*work); });
                                                                           return work;
                                                                         }) &
          tbb::make_filter<std::shared_ptr<Work>, void>(
              tbb::filter_mode::parallel, [&](std::shared_ptr<Work> work) { alone([&] { finish(*work); }); }));
}

void TakeReconstruction::check_cameras() {
  report_.cameras = camera_standings(take_, studio_.views, stop_);
  if (!stop_.stop_requested()) write_standings(take_.folder() / "recon" / "cameras.json", report_.cameras);
}

TakeReconstruction::Work TakeReconstruction::begin(std::size_t frame) {
  const auto set = clock_.run("read", [&] { return take_.read(frame); });
  Work work{.frame = frame,
            .views = key_frame(set, studio_.views, given_mattes(take_, frame), clock_, neighbours_->held(frame)),
            .mapped = {}};
  if (options_.mattes) export_mattes(set, work.views, frame);
  work.mapped = map_frame(work.views, surface_options_, clock_);
  return work;
}

void TakeReconstruction::export_mattes(const capture::FrameSet& set, const FrameViews& views, std::size_t frame) const {
  std::size_t view = 0;
  for (std::size_t i = 0; i < set.slots.size(); ++i) {
    if (!set.slots[i].frame) continue;
    const auto folder = *options_.mattes / take_.info().cameras[i].name;
    fs::create_directories(folder);
    capture::write_png(folder / capture::frame_file_name(frame), views.mattes[view++].alpha);
  }
}

void TakeReconstruction::align_to_previous(Work& work) {
  if (!work.mapped.surface) return;
  auto& surface = *work.mapped.surface;
  if (!previous_ && work.frame > first_ && store_->finished(work.frame - 1) && !store_->failure(work.frame - 1))
    previous_ = store_->surface(work.frame - 1);
  if (previous_)
    surface.map =
        clock_.run("align", [&] { return align_to(surface.mesh, surface.map, previous_->mesh, previous_->map); });
  previous_ = surface;
}

void TakeReconstruction::finish(Work& work) {
  if (work.mapped.surface) {
    const auto image = sample_frame(*work.mapped.surface, work.views, options_.level, options_.colour_level, clock_);
    if (options_.meshes) {
      colour_vertices(work.mapped.surface->mesh, work.views, clock_);
      export_mesh(work.frame, work.mapped.surface->mesh);
    }
    store_->save_report(work.frame, frame_report(work.frame, "", work.mapped.report, unseen_share(image)));
    clock_.run("store", [&] { store_->save(work.frame, *work.mapped.surface, image); });
  } else {
    store_->save_report(work.frame, frame_report(work.frame, work.mapped.failure, work.mapped.report, std::nullopt));
    store_->save_failure(work.frame, work.mapped.failure);
  }
  count_finished();
}

void TakeReconstruction::count_finished() {
  const std::lock_guard lock(done_mutex_);
  ++done_;
  if (tell_) tell_(done_, (end_ - first_) * (options_.align != Alignment::none ? 2 : 1));
}

void TakeReconstruction::export_mesh(std::size_t frame, const TriangleMesh& mesh) const {
  fs::create_directories(*options_.meshes);
  write_ply(*options_.meshes / capture::frame_file_name(frame, "ply"), mesh);
}

// What this run is asked to write beside the video, of a frame that an earlier run has finished.
void TakeReconstruction::export_resumed(std::size_t frame) {
  if (!options_.meshes && !options_.mattes) return;
  const auto set = take_.read(frame);
  const auto views = key_frame(set, studio_.views, given_mattes(take_, frame), clock_, neighbours_->held(frame));
  if (options_.mattes) export_mattes(set, views, frame);
  if (!options_.meshes || store_->failure(frame)) return;
  auto mesh = store_->surface(frame).mesh;
  if (mesh.colours.empty()) colour_vertices(mesh, views, clock_);
  export_mesh(frame, mesh);
}

std::vector<std::size_t> TakeReconstruction::mapped_frames() const {
  std::vector<std::size_t> mapped;
  for (std::size_t frame = first_; frame < end_; ++frame)
    if (store_->finished(frame) && !store_->failure(frame)) mapped.push_back(frame);
  return mapped;
}

// Hands and hair that a template lacks are less; a skirt or a prop is more.
constexpr double kMostUncovered = 0.03;

// What has no lengths that a body could be told by stays as it is, and the report says so.
void TakeReconstruction::align_frames() {
  const TakeAlignmentOptions options{.take = options_.take,
                                     .reference = options_.reference,
                                     .calibration = options_.calibration,
                                     .frames = std::pair(first_, end_),
                                     .paper = options_.paper,
                                     .jobs = options_.jobs};
  if (!options_.reference && studio_.unit != "m") {
    report_.unaligned = "the calibration is not in metres";
    return;
  }
  auto alignment = align_take(
      options, [&](std::size_t, std::size_t) { count_finished(); }, stop_);
  if (options_.align == Alignment::where_it_fits && !options_.reference && alignment.uncovered() > kMostUncovered)
    report_.unaligned =
        fmt::format("{:.1f} % of the surface is not of the body that was found in it", 1e2 * alignment.uncovered());
  else
    report_.alignment = std::move(alignment);
}

GeometryImage TakeReconstruction::image(std::size_t frame) const {
  if (!report_.alignment) return store_->image(frame);
  return AlignmentStore(AlignmentStore::folder_of(take_.folder())).image(frame);
}

GeometryImage TakeReconstruction::image_or_between(std::size_t frame, const std::vector<std::size_t>& mapped) const {
  const auto after = std::lower_bound(mapped.begin(), mapped.end(), frame);
  if (after != mapped.end() && *after == frame) return image(frame);
  if (after == mapped.begin()) return image(*after);
  if (after == mapped.end()) return image(mapped.back());
  const auto before = after[-1];
  const double share = static_cast<double>(frame - before) / static_cast<double>(*after - before);
  return interpolate(image(before), image(*after), share);
}

void TakeReconstruction::write_video() {
  const auto mapped = mapped_frames();
  GeometryVideoHeader header;
  header.fps = take_.info().fps;
  header.aligned = report_.alignment.has_value();
  header.first_frame = static_cast<std::int64_t>(first_);
  MeanSurface mean;
  for (std::size_t frame = first_; frame < end_; ++frame) {
    const auto reason = store_->failure(frame);
    const auto image = image_or_between(frame, mapped);
    add_frame(header, image, {reason.has_value(), reason.value_or("")});
    mean.add(image.positions, header.root_path.back());
  }
  const auto folder = take_.folder() / "recon";
  GeometryVideoWriter video(geometry_video_of(take_.folder()), header, mean);
  std::optional<PaperVideoWriter> paper;
  if (options_.paper) paper.emplace(folder / "geometry.avi", folder / "geometry.json", header);
  for (std::size_t frame = first_; frame < end_; ++frame) {
    const auto image = image_or_between(frame, mapped);
    video.write(image);
    if (paper) paper->write(image);
  }
  video.finish();
  if (paper) paper->finish();
  report_.video = geometry_video_of(take_.folder());
}

}  // namespace

TakeReconstructionReport reconstruct_take(const TakeReconstructionOptions& options,
                                          const std::function<void(std::size_t, std::size_t)>& progress,
                                          std::stop_token stop) {
  return TakeReconstruction(options, progress, std::move(stop)).run();
}

}  // namespace rotunda::recon
