#include "recon/take_alignment.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>
#include <nlohmann/json.hpp>

#include "capture/base/sha256.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "recon/alignment_report.h"
#include "recon/alignment_store.h"
#include "recon/colour/surface_colour.h"
#include "recon/frame_reconstruction.h"
#include "recon/geometry_image_file.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/resample.h"
#include "recon/take_body.h"
#include "recon/take_plates.h"
#include "recon/take_studio.h"
#include "recon/whole_file.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The settings of the frames that are there.
std::string frame_settings(const fs::path& take) {
  const auto text = read_text(FrameStore::folder_of(take) / "settings.json");
  if (text.empty())
    throw InvalidInput(fmt::format("take {} is not reconstructed; run `rotunda recon {}` first", take.string(),
                                   take.filename().string()));
  return text;
}

[[noreturn]] void refuse_unaligned(const fs::path& take) {
  throw InvalidInput(fmt::format("take {} is not aligned; run `rotunda recon {} --align` first", take.string(),
                                 take.filename().string()));
}

class TakeAlignment {
 public:
  TakeAlignment(const TakeAlignmentOptions& options, const std::function<void(std::size_t, std::size_t)>& tell,
                std::stop_token stop);
  TakeAlignmentReport run();

 private:
  void carry_or_follow();
  void choose_frames();
  std::optional<BodyTrack> found_body();
  std::optional<AlignmentReference> own_reference(const BodyTrack& track);
  AlignmentReference foreign_reference(const std::optional<BodyTrack>& track) const;
  void open_store(const std::string& reference);
  void carry(const AlignmentReference& reference, const BodyTrack& track);
  void follow();
  void match();
  std::optional<GeometryImage> first_of_reference() const;
  bool all_finished() const;
  void finish(const AlignmentReference& reference, std::size_t frame, AlignedFrame aligned);
  void colour(const AlignmentReference& reference, std::size_t frame, AlignedFrame& aligned);
  bool has_surface(std::size_t frame) const;
  std::optional<MappedSurface> mapped(std::size_t frame) const;
  LoadSurface surfaces_from(std::size_t first) const;
  void make_report();

  const TakeAlignmentOptions& options_;
  const std::function<void(std::size_t, std::size_t)>& tell_;
  std::stop_token stop_;
  capture::TakeReader take_;
  TakeStudio studio_;
  std::string settings_;
  FrameStore frames_;
  std::optional<AlignmentStore> store_;
  int level_ = 8, colour_level_ = 8;
  std::size_t first_ = 0, end_ = 0, done_ = 0;
  std::mutex done_mutex_;
  StageClock clock_;
  TakeAlignmentReport report_;
};

TakeAlignment::TakeAlignment(const TakeAlignmentOptions& options,
                             const std::function<void(std::size_t, std::size_t)>& tell, std::stop_token stop)
    : options_(options),
      tell_(tell),
      stop_(std::move(stop)),
      take_(options.take),
      studio_(read_take_studio(take_, options.calibration)),
      settings_(frame_settings(options.take)),
      frames_(FrameStore::folder_of(take_.folder())) {
  if (studio_.unit != "m")
    throw InvalidInput(fmt::format("take {}: its calibration is not in metres; frames are aligned by lengths of bodies",
                                   take_.info().name));
  const auto settings = json::parse(settings_, nullptr, false);
  level_ = settings.value("level", 8);
  colour_level_ = settings.value("colour_level", 8);
  choose_frames();
  clock_.run("plates", [&] { learn_missing_plates(take_, studio_.views); });
  if (settings.value("quality", "full") == "live") make_live_keys(take_, studio_.views);
}

void TakeAlignment::choose_frames() {
  std::tie(first_, end_) = options_.frames.value_or(std::pair<std::size_t, std::size_t>{0, take_.frame_set_count()});
  end_ = std::min(end_, take_.frame_set_count());
  while (first_ < end_ && !has_surface(first_)) ++first_;
  while (end_ > first_ && !has_surface(end_ - 1)) --end_;
  if (first_ >= end_)
    throw InvalidInput(fmt::format("take {}: none of the frames is reconstructed; run `rotunda recon {}` first",
                                   take_.info().name, take_.info().name));
}

bool TakeAlignment::has_surface(std::size_t frame) const {
  return frames_.finished(frame) && !frames_.failure(frame);
}

std::optional<MappedSurface> TakeAlignment::mapped(std::size_t frame) const {
  if (!has_surface(frame)) return std::nullopt;
  return frames_.surface(frame);
}

LoadSurface TakeAlignment::surfaces_from(std::size_t first) const {
  return [this, first](std::size_t i) -> std::optional<TriangleMesh> {
    auto surface = mapped(first + i);
    if (!surface) return std::nullopt;
    return std::move(surface->mesh);
  };
}

// None where nobody is found. With a reference its measures of the person hold: loose clothes would make another body
// of the same person in every take.
std::optional<BodyTrack> TakeAlignment::found_body() {
  TakeBodyOptions options{
      .take = options_.take, .calibration = options_.calibration, .frames = {first_, end_}, .body = {}};
  if (options_.reference) options.body = kept_body_of(*options_.reference);
  try {
    return body_of_take(options, clock_, stop_);
  } catch (const InvalidInput& e) {
    report_.why_no_skeleton = e.what();
    return std::nullopt;
  }
}

// Frames that another motion carried are made again: it was captured anew, over more frames.
void TakeAlignment::open_store(const std::string& reference) {
  const json settings{{"version", 2},
                      {"frames", settings_},
                      {"how", report_.how},
                      {"reference", reference},
                      {"motion", report_.how == "skeleton" ? capture::sha256_of(joints_file_of(take_.folder())) : ""}};
  store_.emplace(AlignmentStore::folder_of(take_.folder()), settings.dump());
}

// Nothing where the body is none or asked to stop.
std::optional<AlignmentReference> TakeAlignment::own_reference(const BodyTrack& track) {
  report_.how = "skeleton";
  open_store("own");
  if (auto kept = store_->reference()) return kept;
  try {
    auto reference =
        clock_.run("reference", [&] { return body_reference(track, level_, surfaces_from(track.first_frame), stop_); });
    if (reference) store_->save_reference(*reference);
    return reference;
  } catch (const InvalidInput& e) {
    report_.why_no_skeleton = e.what();
    return std::nullopt;
  }
}

AlignmentReference TakeAlignment::foreign_reference(const std::optional<BodyTrack>& track) const {
  const AlignmentStore other(AlignmentStore::folder_of(*options_.reference));
  auto reference = other.reference();
  if (!reference) refuse_unaligned(*options_.reference);
  if (!reference->body)
    throw InvalidInput(
        fmt::format("take {} was followed from frame to frame, without a person's skeleton; no other "
                    "take can be aligned to it",
                    options_.reference->string()));
  if (!track)
    throw InvalidInput(fmt::format("take {} cannot be aligned to {}: {}", take_.info().name,
                                   options_.reference->filename().string(), report_.why_no_skeleton));
  return *reference;
}

TakeAlignmentReport TakeAlignment::run() {
  const tbb::global_control threads(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(options_.jobs > 0 ? options_.jobs : tbb::info::default_concurrency()));
  if (options_.paper)
    match();
  else
    carry_or_follow();
  report_.interrupted = stop_.stop_requested();
  if (!report_.interrupted) make_report();
  report_.stages = clock_.costs();
  return report_;
}

void TakeAlignment::carry_or_follow() {
  const auto track = found_body();
  if (options_.reference && !stop_.stop_requested()) {
    const auto reference = foreign_reference(track);
    report_.how = "skeleton";
    open_store(fs::absolute(*options_.reference).lexically_normal().string() +
               read_text(AlignmentStore::folder_of(*options_.reference) / "reference.json"));
    store_->save_reference(reference);
    carry(reference, *track);
  } else if (!stop_.stop_requested()) {
    const auto reference = track ? own_reference(*track) : std::nullopt;
    if (reference)
      carry(*reference, *track);
    else if (!stop_.stop_requested())
      follow();
  }
}

// Frames side by side: none needs another.
void TakeAlignment::carry(const AlignmentReference& reference, const BodyTrack& track) {
  const BodyCarrier carrier(reference);
  tbb::parallel_for(
      first_, end_,
      [&](std::size_t frame) {
        const auto pose = track.pose(frame);
        if (stop_.stop_requested() || store_->finished(frame)) return finish(reference, frame, {});
        const auto surface = mapped(frame);
        if (!surface || !pose) return finish(reference, frame, {});
        tbb::task_arena alone(1, 1);  // nested loops stay on this thread: the frame's CPU time is all its own
        alone.execute([&] {
          finish(reference, frame,
                 clock_.run("align", [&] { return carrier.align(surface->mesh, track.body.skeleton, *pose); }));
        });
      },
      tbb::simple_partitioner());
}

void TakeAlignment::follow() {
  report_.how = "tracking";
  open_store("key");
  if (all_finished()) return;
  const auto key = clock_.run("reference", [&] {
    return key_reference(
        end_ - first_, level_, [&](std::size_t i) { return mapped(first_ + i); }, stop_);
  });
  if (!key) return;
  store_->save_reference(key->reference);
  track_sequence(
      end_ - first_, *key, surfaces_from(first_),
      [&](std::size_t i, const AlignedFrame& frame) { finish(key->reference, first_ + i, frame); }, stop_);
}

bool TakeAlignment::all_finished() const {
  bool all = true;
  for (auto frame = first_; frame < end_; ++frame) all = all && (store_->finished(frame) || !has_surface(frame));
  return all;
}

// Of the take that this one is matched to, the first frame as it was aligned.
std::optional<GeometryImage> TakeAlignment::first_of_reference() const {
  if (!options_.reference) return std::nullopt;
  const auto folder = AlignmentStore::folder_of(*options_.reference);
  const auto report = json::parse(read_text(folder / "report.json"), nullptr, false);
  const auto frames = report.is_object() ? report.value("frames", json::array()) : json::array();
  if (frames.empty()) refuse_unaligned(*options_.reference);
  return AlignmentStore(folder).image(frame_alignment_of(frames[0].dump(), folder).frame);
}

void TakeAlignment::match() {
  report_.how = "matching";
  const auto before = first_of_reference();
  open_store(before ? fs::absolute(*options_.reference).lexically_normal().string() : "own");
  if (all_finished()) return;
  match_sequence(
      end_ - first_, before, {.most_updates = 200, .one_by_one = true},
      [this](std::size_t i) {
        return has_surface(first_ + i) ? std::optional(frames_.image(first_ + i)) : std::nullopt;
      },
      [&](std::size_t i, const AlignedFrame& frame) { finish({}, first_ + i, frame); }, stop_);
}

// An empty frame: there is nothing to keep, or it is kept already.
void TakeAlignment::finish(const AlignmentReference& reference, std::size_t frame, AlignedFrame aligned) {
  if (!aligned.image.positions.empty()) {
    if (aligned.image.colours.empty()) clock_.run("colour", [&] { colour(reference, frame, aligned); });
    const FrameAlignment report{.frame = frame,
                                .residual_mean_mm = aligned.residual_mean_mm,
                                .residual_p95_mm = aligned.residual_p95_mm,
                                .stretch_p95 = aligned.stretch_p95,
                                .uncovered = aligned.uncovered,
                                .folds = aligned.folds};
    store_->save(frame, aligned.image, json_of(report).dump());
  }
  const std::lock_guard lock(done_mutex_);
  ++done_;
  if (tell_) tell_(done_, end_ - first_);
}

// From the frame's own pictures, where the carried surface is seen.
void TakeAlignment::colour(const AlignmentReference& reference, std::size_t frame, AlignedFrame& aligned) {
  const auto views = key_frame(take_.read(frame), studio_.views, given_mattes(take_, frame), clock_);
  auto lattice = reference.lattice;
  const int level = lattice_level(lattice.size());
  for (int finer = level + 1; finer <= colour_level_; ++finer) lattice = refine_directions(lattice, finer);
  const auto points = surface_points(aligned.surface, reference.surface.map, lattice);
  auto colours = surface_colour(points.positions, points.normals, aligned.surface, colour_views(views),
                                {.backdrop = views.backdrop});
  aligned.image.colour_level = std::max(level, colour_level_);
  aligned.image.colours = std::move(colours.colours);
  aligned.image.coverage = std::move(colours.coverage);
  fill_unseen(aligned.image);
}

void TakeAlignment::make_report() {
  const auto folder = AlignmentStore::folder_of(take_.folder());
  json frames = json::array();
  for (auto frame = first_; frame < end_; ++frame) {
    if (!store_->finished(frame)) continue;
    report_.frames.push_back(frame_alignment_of(store_->report(frame), folder));
    frames.push_back(json_of(report_.frames.back()));
  }
  json report{{"how", report_.how}, {"frames", frames}};
  if (!report_.why_no_skeleton.empty()) report["why_no_skeleton"] = report_.why_no_skeleton;
  write_text(folder / "report.json", report.dump(1) + "\n");
}

}  // namespace

TakeAlignmentReport align_take(const TakeAlignmentOptions& options,
                               const std::function<void(std::size_t, std::size_t)>& progress, std::stop_token stop) {
  return TakeAlignment(options, progress, std::move(stop)).run();
}

}  // namespace rotunda::recon
