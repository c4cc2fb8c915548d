#pragma once
// How the editor of markers divides its window: the template left, the scan right, seen by the same eye, and below both
// the motion as a bar. Pixels, (0, 0) the middle of the top left one.
#include "playback/display/window_input.h"
#include "playback/viewpoint.h"

namespace rotunda::playback {

enum class MarkerSide { body, scan };

struct MarkerLayout {
  int width = 1280, height = 720;

  static constexpr int kBar = 14;  // its height
  int left(MarkerSide side) const { return side == MarkerSide::body ? 0 : width / 2; }
  int width_of(MarkerSide side) const { return side == MarkerSide::body ? width / 2 : width - width / 2; }
  bool operator==(const MarkerLayout&) const = default;
  bool has_room() const { return width >= 2 && height > kBar; }
  bool in_bar(const MousePlace& place) const { return place.y > height - kBar - 0.5; }
  MarkerSide side_of(const MousePlace& place) const {
    return place.x < width / 2 - 0.5 ? MarkerSide::body : MarkerSide::scan;
  }
  // Of the motion, 0 to 1, where the bar is pointed at.
  double share(const MousePlace& place) const { return (place.x + 0.5) / width; }
  Viewpoint viewpoint(MarkerSide side, const Orbit& orbit) const { return orbit.viewpoint(width_of(side), height); }
  // In the pixels of a side's own viewpoint.
  Eigen::Vector2d within(MarkerSide side, const MousePlace& place) const { return {place.x - left(side), place.y}; }
};

}  // namespace rotunda::playback
