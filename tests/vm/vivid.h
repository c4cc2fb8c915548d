#pragma once
// The kernel's virtual video driver (vivid) as the tests load it: ten web cameras, /dev/video0 to 9, the last of them
// by the multi-planar API, and one S-Video input, /dev/video10, that can be wired to the output /dev/video11. The
// kernel's documentation: "The Virtual Video Test Driver (vivid)".
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <string>

#include "capture/base/bounded_queue.h"
#include "capture/source/v4l2_control.h"
#include "capture/source/v4l2_source.h"
#include "config/errors.h"

namespace rotunda::vm {

inline constexpr int kCameras = 10;
inline constexpr const char* kInput = "/dev/video10";
inline constexpr const char* kOutput = "/dev/video11";

inline std::string camera_node(int number) {
  return "/dev/video" + std::to_string(number);
}

// The smallest picture its web camera sends; at this rate an emulated processor keeps up with ten of them.
inline capture::SourceSettings settings_of(int number, capture::PixelFormat format = capture::PixelFormat::yuyv) {
  capture::SourceSettings settings;
  settings.camera = "cam" + std::to_string(number);
  settings.kind = "v4l2";
  settings.device = camera_node(number);
  settings.width = 320;
  settings.height = 180;
  settings.format = format;
  settings.frame_rate_hz = 5.0;
  settings.buffers = 6;
  return settings;
}

// A control of vivid's own, by its name; buttons take any value.
inline void set_vivid(const std::string& node_path, const std::string& name, std::int64_t value) {
  const capture::V4l2Node node(capture::kernel_v4l2(), node_path);
  ASSERT_TRUE(node) << node_path;
  for (const auto& control : capture::list_controls(node))
    if (control.name == name) return capture::write_control(node, node_path, control, value);
  FAIL() << "vivid has no control " << name;
}

// A source and what it sends.
class Stream {
 public:
  explicit Stream(const capture::SourceSettings& settings) : source(capture::make_source(settings)) {}
  void open_and_arm() {
    source->open();
    source->arm();
  }
  void start() {
    source->start([this](capture::Frame&& frame) { frames.push_drop_oldest(std::move(frame)); },
                  [this](const capture::IncompleteFrame& loss) { losses.push_drop_oldest(loss); });
  }
  void begin() {
    open_and_arm();
    start();
  }
  capture::Frame next() {
    auto frame = frames.wait_pop(kPatience);
    if (!frame) throw DeviceError("test", "no frame came");
    return std::move(*frame);
  }
  bool becomes(capture::SourceState state) const {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end) {
      if (source->state() == state) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  static constexpr auto kPatience = std::chrono::seconds(20);  // an emulated processor on a busy machine
  capture::BoundedQueue<capture::Frame> frames{20};
  capture::BoundedQueue<capture::IncompleteFrame> losses{20};
  std::unique_ptr<capture::Source> source;  // last: its thread fills the queues
};

}  // namespace rotunda::vm
