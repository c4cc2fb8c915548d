#include "playback/character_view.h"

#include <algorithm>
#include <cmath>

namespace rotunda::playback {
namespace {

constexpr double kFollow = 0.33;  // seconds
constexpr int kShadowLevel = 6;   // of the lattice: a shadow is soft

}  // namespace

CharacterView::CharacterView(const std::filesystem::path& character, const recon::MotionGraph& graph)
    : renderer_(character, graph) {}

Orbit CharacterView::orbit_for(double aspect) const {
  // Standing people fill three quarters of the picture's height; who lies or spreads the arms has as much width.
  constexpr double kFilled = 0.75;
  const auto box = renderer_.box();
  Orbit orbit;
  const double height = box.sizes().z() / std::min(1.0, aspect);
  orbit.distance = 0.5 * height / kFilled / std::tan(0.5 * orbit.field_of_view);
  orbit.target.z() = 0.5 * (box.min().z() + box.max().z());
  return orbit;
}

void CharacterView::follow(const Appearance& appearance, double seconds) {
  const double share = 1.0 - std::exp(-seconds / kFollow);
  orbit_.target.head<2>() += share * (appearance.place + beside_ - orbit_.target.head<2>());
}

void CharacterView::shift(const Eigen::Vector2d& heights) {
  const Eigen::Vector3d way = orbit_.shift(heights);
  orbit_.target += way;
  beside_ += way.head<2>();
}

void CharacterView::draw(const Appearance& appearance, int width, int height, const CharacterViewOptions& options) {
  const auto viewpoint = orbit_.viewpoint(width, height);
  clear(options.background);
  if (options.floor)
    stage_.draw(viewpoint, {.place = appearance.place, .background = options.background}, [&](const Viewpoint& above) {
      renderer_.draw(appearance, above, {.shading = Shading::colour, .cull = false}, kShadowLevel);
    });
  renderer_.draw(appearance, viewpoint, options.draw, std::max(1, renderer_.level() - options.coarser));
}

}  // namespace rotunda::playback
