#include "playback/take_view.h"

#include <algorithm>
#include <cmath>

#include "recon/sphere/resample.h"

namespace rotunda::playback {
namespace {

constexpr int kShadowLevel = 6;         // of the lattice: a shadow is soft
constexpr float kNearTheFloor = 0.15F;  // metres

// Not every calibration has the world's z = 0 on a floor.
bool stands_on_floor(const recon::GeometryImage& image) {
  const auto lowest = std::min_element(image.positions.begin(), image.positions.end(),
                                       [](const auto& a, const auto& b) { return a.z() < b.z(); });
  return std::abs(lowest->z()) < kNearTheFloor;
}

}  // namespace

void TakeView::show(const recon::GeometryImage& image, std::span<const SourceView> views) {
  if (!has_floor_) has_floor_ = stands_on_floor(image);
  stored_.upload(image);
  level_ = image.level;
  in_pictures_ = !views.empty();
  if (!in_pictures_) return;
  if (!from_pictures_) from_pictures_.emplace();
  from_pictures_->upload(recon::remesh(image), views);
}

void TakeView::show_between(const GeometryImageRenderer::Numbered& from, const GeometryImageRenderer::Numbered& to,
                            double share) {
  if (!has_floor_) has_floor_ = stands_on_floor(from.image);
  stored_.upload_between(from, to, share);
  level_ = from.image.level;
  in_pictures_ = false;
}

void TakeView::draw(const Viewpoint& viewpoint, const Eigen::Vector3d& performer, const DrawOptions& options,
                    int coarser) {
  clear(kDarkRoom);
  if (has_floor_.value_or(false))
    stage_.draw(viewpoint, {.place = performer.head<2>(), .background = kDarkRoom}, [&](const Viewpoint& above) {
      stored_.draw(above, {.shading = Shading::colour, .cull = false}, std::min(kShadowLevel, level_));
    });
  if (in_pictures_ && options.shading == Shading::colour)
    from_pictures_->draw(viewpoint);
  else
    stored_.draw(viewpoint, options, std::max(1, level_ - coarser));
}

}  // namespace rotunda::playback
