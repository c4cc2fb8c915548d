#include "recon/take_cameras.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "recon/hull/capture_volume.h"
#include "recon/hull/matte_support.h"
#include "recon/take_plates.h"
#include "recon/take_studio.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kFramesLookedAt = 12;
// Of the search for what no other view supports, in hull cells: a camera turned by two degrees keeps its performer.
constexpr double kCoarse = 20.0;

std::vector<std::size_t> spread_frames(std::size_t count) {
  const std::size_t looked_at = std::min(count, kFramesLookedAt);
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < looked_at; ++i) frames.push_back((2 * i + 1) * count / (2 * looked_at));
  return frames;
}

// Lamps and marks beside the performer would be touched instead.
std::vector<capture::Matte> without_strays(const FrameViews& views, const StudioViews& studio) {
  if (!studio.volume || views.cameras.size() < 2) return views.mattes;
  const double cube = kCoarse * default_cell_size(*studio.volume, studio.unit);
  return supported_mattes(views.cameras, views.mattes,
                          {.bounds = studio.volume, .cube_size = cube, .unit = studio.unit})
      .mattes;
}

// A slot a camera of the take.
std::vector<ConvexOutline> outlines_of(const capture::FrameSet& set, std::span<const capture::Matte> given,
                                       const StudioViews& studio, const StudioViews& anywhere) {
  StageClock clock;
  const auto views = key_frame(set, anywhere, given, clock);
  const auto mattes = without_strays(views, studio);
  std::vector<ConvexOutline> outlines(set.slots.size());
  for (std::size_t view = 0; view < views.cameras.size(); ++view)
    for (std::size_t i = 0; i < studio.cameras.size(); ++i)
      if (studio.cameras[i].name == views.cameras[view].name)
        outlines[i] = convex_outline(views.cameras[view], mattes[view]);
  return outlines;
}

}  // namespace

std::vector<CameraStanding> camera_standings(const capture::TakeReader& take, const StudioViews& studio,
                                             const std::stop_token& stop) {
  StudioViews anywhere = studio;  // the other views' say comes later, and is a coarser one
  anywhere.volume.reset();
  make_live_keys(take, anywhere);
  const auto frames = spread_frames(take.frame_set_count());
  std::vector<std::vector<ConvexOutline>> seen(frames.size());
  tbb::parallel_for(std::size_t{0}, frames.size(), [&](std::size_t i) {
    if (!stop.stop_requested())
      seen[i] = outlines_of(take.read(frames[i]), given_mattes(take, frames[i]), studio, anywhere);
  });
  std::vector<OutlinesOverTime> outlines(studio.cameras.size());
  for (const auto& frame : seen)
    for (std::size_t i = 0; i < frame.size(); ++i) outlines[i].push_back(frame[i]);
  std::vector<CameraStanding> standings;
  for (const auto& camera : studio.cameras) standings.push_back({camera.name, std::nullopt});
  if (stop.stop_requested()) return standings;
  const auto shifts = camera_shifts(studio.cameras, outlines);
  for (std::size_t i = 0; i < shifts.size(); ++i) standings[i].shift = shifts[i];
  return standings;
}

}  // namespace rotunda::recon
