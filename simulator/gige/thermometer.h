#pragma once
// The temperature inside a camera: it nears what its work asks for with one time constant, as a small housing does
// (Newton's law of cooling). Pure.
#include <chrono>
#include <cmath>

#include "capture/frame.h"

namespace rotunda::simulator {

class Thermometer {
 public:
  double celsius(capture::Timestamp at) const {
    const double passed = std::chrono::duration<double>(at - since_).count();
    return target_ + (from_ - target_) * std::exp(-std::max(passed, 0.0) / kTimeConstant);
  }
  void set_streaming(bool streaming, capture::Timestamp at) {
    from_ = celsius(at);
    since_ = at;
    target_ = streaming ? kStreaming : kIdle;
  }

 private:
  static constexpr double kIdle = 41.5, kStreaming = 54.0;  // degrees in a room of 22
  static constexpr double kTimeConstant = 420.0;            // seconds

  capture::Timestamp since_;
  double from_ = kIdle, target_ = kIdle;
};

}  // namespace rotunda::simulator
