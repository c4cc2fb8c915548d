#include "recon/live_reconstruction.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "capture/matte/chroma_key.h"
#include "capture/picture.h"
#include "config/errors.h"
#include "recon/hull/capture_volume.h"
#include "recon/hull/rim_fit.h"
#include "recon/live/live_hull.h"
#include "recon/live/live_paint.h"
#include "recon/live/live_rims.h"
#include "recon/live/live_skin.h"

namespace rotunda::recon {
namespace {

// Of the offline cell: the hull's cost goes with the square, and a viewer shows little more of that detail.
constexpr double kCoarser = 2.0;
// Cells a pixel of a silhouette may cover: its outline is known to a tenth of a pixel.
constexpr double kCoarsestPixel = 0.5;
// Over cells of a quarter of the membrane's length: after the tenth round nothing moves by a millimetre.
constexpr int kMembraneRounds = 10;
constexpr std::size_t kEnoughKeys = 6;  // views that leave little of a body's surroundings
constexpr double kSliverMargin = 0.15;  // cells: the shortest edges are 0.2 cells long

// The full key at half its size, for cameras without a live one.
capture::HalfMatte full_key(const capture::Image& image, const StudioViews& studio, std::size_t camera) {
  const cv::Mat stage = camera < studio.stages.size() ? studio.stages[camera] : cv::Mat();
  const cv::Mat whole = capture::chroma_key(capture::to_rgb(image), {.backdrop = studio.backdrop, .stage = stage},
                                            studio.backgrounds[camera])
                            .alpha;
  capture::HalfMatte matte{.alpha = {}, .box = {}, .picture = capture::half_picture(image)};
  const cv::Size half = matte.picture.planes[0].size();
  cv::Mat alpha;
  cv::resize(whole(cv::Rect(0, 0, 2 * half.width, 2 * half.height)), alpha, half, 0, 0, cv::INTER_AREA);
  matte.box = cv::boundingRect(alpha);
  if (!matte.box.empty()) matte.alpha = alpha(matte.box).clone();
  return matte;
}

// Nothing where the camera has no picture, or a damaged one.
std::optional<capture::HalfMatte> matte_of(const capture::FrameSlot& slot, const StudioViews& studio,
                                           std::size_t camera) {
  if (!slot.frame) return std::nullopt;
  const auto& image = slot.frame->image;
  const auto& model = studio.cameras[camera];
  if (image.width != model.width || image.height != model.height)
    throw InvalidInput(fmt::format("{}: the picture has {} x {} pixels, the calibration says {} x {}", model.name,
                                   image.width, image.height, model.width, model.height));
  try {
    if (camera < studio.live_keys.size() && studio.live_keys[camera]) return studio.live_keys[camera]->half(image);
    return full_key(image, studio, camera);
  } catch (const CorruptData&) {
    return std::nullopt;
  }
}

// A key without a screen is slow, and what it misses is cut off the performer: where enough cameras have a live key,
// the others are done without.
bool done_without(const capture::FrameSet& set, const StudioViews& studio, std::size_t camera) {
  std::size_t with_key = 0;
  for (std::size_t i = 0; i < std::min(set.slots.size(), studio.live_keys.size()); ++i)
    with_key += set.slots[i].frame && studio.live_keys[i] ? 1 : 0;
  return with_key >= kEnoughKeys && !studio.live_keys[camera];
}

std::vector<LiveView> key_views(const capture::FrameSet& set, const StudioViews& studio) {
  std::vector<std::optional<capture::HalfMatte>> mattes(set.slots.size());
  tbb::parallel_for(std::size_t{0}, mattes.size(), [&](std::size_t i) {
    if (!done_without(set, studio, i)) mattes[i] = matte_of(set.slots[i], studio, i);
  });
  std::vector<LiveView> views;
  for (std::size_t i = 0; i < mattes.size(); ++i)
    if (mattes[i]) views.push_back({studio.cameras[i].name, i, std::move(*mattes[i])});
  return views;
}

struct SearchedVolume {
  Eigen::AlignedBox3d bounds;
  double cell_size = 0.0;
  double metre = 1.0;  // or what is to this body as a metre is to a person
};

// From the mattes alone. Throws InvalidInput if they meet nowhere.
Eigen::AlignedBox3d found_volume(std::span<const LiveView> keyed, const StudioViews& studio) {
  std::vector<SilhouetteView> views;
  for (const auto& view : keyed) {
    if (view.matte.alpha.empty()) continue;
    capture::Matte half{cv::Mat::zeros(view.matte.picture.planes[0].size(), CV_8UC1)};
    view.matte.alpha.copyTo(half.alpha(view.matte.box));
    views.emplace_back(reduced_camera(studio.cameras[view.slot], 2), half);
  }
  return capture_volume(views);
}

SearchedVolume volume_of(std::span<const LiveView> keyed, const StudioViews& studio, const LiveOptions& options) {
  SearchedVolume volume;
  volume.bounds = options.bounds ? *options.bounds : found_volume(keyed, studio);
  const double usual = default_cell_size(volume.bounds, studio.unit);
  volume.metre = usual / kPersonCell;
  volume.cell_size = options.cell_size > 0.0 ? options.cell_size : kCoarser * usual;
  if (volume.cell_size >= volume.bounds.sizes().minCoeff())
    throw InvalidInput(fmt::format("cells of {:.4g} do not fit into the volume: give them in the calibration's unit",
                                   volume.cell_size));
  return volume;
}

// How many half-size pixels, along each axis, become one of the silhouette.
int reduction_of(const capture::CameraModel& half, const SearchedVolume& volume) {
  const double depth = half.R.row(2).dot(volume.bounds.center()) + half.t.z();
  const double pixel = depth / std::max(half.K(0, 0), half.K(1, 1));
  int reduction = 1;
  while (2 * reduction * pixel < kCoarsestPixel * volume.cell_size && half.width >= 64 * reduction) reduction *= 2;
  return reduction;
}

std::vector<LiveSilhouette> silhouettes_of(std::span<const LiveView> keyed, const StudioViews& studio,
                                           const SearchedVolume& volume) {
  std::vector<std::optional<LiveSilhouette>> made(keyed.size());
  tbb::parallel_for(std::size_t{0}, made.size(), [&](std::size_t i) {
    const auto half = reduced_camera(studio.cameras[keyed[i].slot], 2);
    const auto& matte = keyed[i].matte;
    made[i].emplace(half, matte.alpha, matte.box, reduction_of(half, volume));
  });
  std::vector<LiveSilhouette> silhouettes;
  for (auto& view : made) silhouettes.push_back(std::move(*view));
  return silhouettes;
}

std::string names_of(std::span<const LiveSilhouette* const> views) {
  std::string names;
  for (const auto* view : views) names += (names.empty() ? "" : ", ") + view->camera().name;
  return names;
}

// Whether nobody is where the surface is: then the key failed.
bool watches(const LiveSilhouette& view, const TriangleMesh& mesh) {
  LivePixel pixel;
  return std::any_of(mesh.positions.begin(), mesh.positions.end(),
                     [&](const Eigen::Vector3f& point) { return view.project(point, pixel); });
}

std::string nothing_inside(std::span<const LiveView> keyed, const StudioViews& studio) {
  const std::string what = "empty hull: no point of the volume lies inside all silhouettes";
  try {
    const auto found = found_volume(keyed, studio);
    return fmt::format(
        "{}, which meet between ({:.3g}, {:.3g}, {:.3g}) and ({:.3g}, {:.3g}, {:.3g}): is it the volume of this rig?",
        what, found.min().x(), found.min().y(), found.min().z(), found.max().x(), found.max().y(), found.max().z());
  } catch (const InvalidInput&) {
    return what + ", nor any other point: check the calibration, and the key";
  }
}

Eigen::AlignedBox3d box_of(const TriangleMesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const auto& position : mesh.positions) box.extend(position);
  return box.cast<double>();
}

void draw_in(std::span<const LiveSilhouette> views, const SearchedVolume& volume, TriangleMesh& mesh,
             StageClock& clock) {
  double pixel = 0.0;  // mean, world units
  for (const auto& view : views) {
    const double depth = view.camera().R.row(2).dot(volume.bounds.center()) + view.camera().t.z();
    pixel += depth / static_cast<double>(view.focal()) / static_cast<double>(views.size());
  }
  // An outline crosses 4 / pi lines between pixel centres a pixel; a rim a cell or so is enough.
  const int stride = std::max(1, static_cast<int>(std::lround(4.0 / std::numbers::pi * volume.cell_size / pixel)));
  const auto rims =
      clock.run("rims", [&] { return live_rims(views, rim_options(box_of(mesh), volume.metre, stride)); });
  auto fit = rim_fit_options(volume.cell_size, volume.metre, 2 * stride);
  fit.rounds = kMembraneRounds;
  clock.run("fit", [&] { fit_to_rims(mesh, rims, fit); });
}

struct SortedViews {
  std::vector<LiveSilhouette> with_silhouette;
  std::vector<const LiveSilhouette*> empty;
};

SortedViews sort_views(std::span<const LiveSilhouette> all) {
  SortedViews sorted;
  for (const auto& view : all)
    if (view.is_empty())
      sorted.empty.push_back(&view);
    else
      sorted.with_silhouette.push_back(view);
  const auto& seen = sorted.with_silhouette;
  if (seen.size() < 2) throw InvalidInput("empty silhouette in " + names_of(sorted.empty));
  if (std::all_of(seen.begin(), seen.end(), [](const LiveSilhouette& view) { return view.is_full(); }))
    throw InvalidInput("the silhouettes fill all pictures: the key found no backdrop");
  return sorted;
}

TriangleMesh make_surface(std::span<const LiveView> keyed, const StudioViews& studio, const SearchedVolume& volume,
                          std::span<const LiveSilhouette> all, StageClock& clock) {
  auto views = sort_views(all);
  auto grid = clock.run("hull", [&] { return live_hull(views.with_silhouette, volume.bounds, volume.cell_size); });
  auto mesh = clock.run("skin", [&] { return live_skin(grid, kSliverMargin); });
  if (mesh.triangles.empty()) throw InvalidInput(nothing_inside(keyed, studio));
  const auto misses_all = [&](const LiveSilhouette* view) { return !watches(*view, mesh); };
  views.empty.erase(std::remove_if(views.empty.begin(), views.empty.end(), misses_all), views.empty.end());
  if (!views.empty.empty()) throw InvalidInput("empty silhouette in " + names_of(views.empty));
  compute_normals(mesh);
  draw_in(views.with_silhouette, volume, mesh, clock);
  compute_normals(mesh);
  return mesh;
}

std::vector<PaintView> paint_views(std::span<const LiveView> keyed, const StudioViews& studio,
                                   std::span<const LiveSilhouette> silhouettes) {
  std::vector<PaintView> views;
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    views.push_back({.view = &silhouettes[i], .matte = &keyed[i].matte});
    if (!studio.colour.empty()) views.back().colour = studio.colour[keyed[i].slot];
  }
  return views;
}

// Throws InvalidInput where no surface can be had.
TriangleMesh painted_surface(std::span<const LiveView> keyed, const StudioViews& studio, const LiveOptions& options,
                             StageClock& clock) {
  const auto volume = volume_of(keyed, studio, options);
  const auto silhouettes = clock.run("silhouette", [&] { return silhouettes_of(keyed, studio, volume); });
  auto mesh = make_surface(keyed, studio, volume, silhouettes, clock);
  clock.run("colour", [&] { paint_live(mesh, paint_views(keyed, studio, silhouettes), studio.backdrop); });
  return mesh;
}

}  // namespace

LiveFrame key_live(const capture::FrameSet& frame_set, const StudioViews& studio, StageClock& clock) {
  LiveFrame frame;
  frame.views = clock.run("key", [&] { return key_views(frame_set, studio); });
  if (frame.views.size() < 2) frame.failure = "fewer than two cameras have a picture";
  return frame;
}

LiveFrame reconstruct_live(const capture::FrameSet& frame_set, const StudioViews& studio, const LiveOptions& options,
                           StageClock& clock) {
  auto frame = key_live(frame_set, studio, clock);
  if (!frame.failure.empty()) return frame;
  try {
    frame.mesh = painted_surface(frame.views, studio, options, clock);
  } catch (const InvalidInput& nothing) {
    frame.failure = nothing.what();
  }
  return frame;
}

}  // namespace rotunda::recon
