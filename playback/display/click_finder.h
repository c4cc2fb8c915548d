#pragma once
// Tells clicks from drags: a button that is pressed and let go without the mouse having gone anywhere between.
#include <cmath>
#include <optional>

#include "playback/display/window_input.h"

namespace rotunda::playback {

class ClickFinder {
 public:
  void press(const MousePlace& at) {
    from_ = at;
    still_ = true;
  }
  void move(const MousePlace& to) {
    constexpr double kHandShakes = 4.0;  // pixels
    if (from_ && std::hypot(to.x - from_->x, to.y - from_->y) > kHandShakes) still_ = false;
  }
  // Where it was clicked; nothing after a drag.
  std::optional<MousePlace> release(const MousePlace& at) {
    move(at);
    const auto from = from_;
    from_.reset();
    return still_ ? from : std::nullopt;
  }
  const std::optional<MousePlace>& held_from() const { return from_; }

 private:
  std::optional<MousePlace> from_;
  bool still_ = false;
};

}  // namespace rotunda::playback
