#pragma once
// One V4L2 capture node: opened, its format agreed, its buffers mapped, streaming. Single- and multi-planar drivers,
// images in one piece of memory. The kernel's documentation: Video for Linux API, "Streaming I/O (Memory Mapping)".
// What the driver does not do as agreed is a DeviceError that names camera, node, the driver's answer and what to do;
// what may happen to any frame is a value. Use it from one thread, but stop() may be called beside wait().
#include <linux/videodev2.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/source/source.h"
#include "capture/source/v4l2_format.h"
#include "capture/source/v4l2_system.h"

namespace rotunda::capture {

// A frame in the driver's memory until it is given back.
struct V4l2Frame {
  std::uint32_t buffer = 0;
  std::span<const std::uint8_t> bytes;  // those the driver filled
  std::uint32_t sequence = 0;
  std::chrono::nanoseconds time{};  // by the driver
  bool time_is_monotonic = false;   // and by CLOCK_MONOTONIC
  bool time_is_start = false;       // of the exposure's start; else of the frame's end
  bool damaged = false;             // the driver says so
};

enum class V4l2Answer { frame, nothing, error, gone };  // error: this time; gone: for good

class V4l2Camera {
 public:
  // Finds the node by path, USB serial number or bus address ("usb-0000:00:14.0-3") and opens it.
  V4l2Camera(V4l2System& system, const SourceSettings& settings);
  ~V4l2Camera();  // stops and lets go of everything
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;

  const V4l2Node& node() const { return *node_; }
  // Size, format, controls, rate; what the camera answered, differences as warnings.
  SourceDescription configure();
  const BufferLayout& layout() const { return layout_; }
  std::size_t buffer_bytes() const { return buffer_bytes_; }

  void map_buffers();
  void start();  // every buffer is the driver's
  void stop() noexcept;

  bool wait(std::chrono::milliseconds timeout) const;  // true: ask next()
  V4l2Answer next(V4l2Frame& frame);
  // The driver may refuse it for the moment: then it is offered again with the next one. False: no buffer is left
  // with the driver.
  bool give_back(std::uint32_t buffer);

 private:
  struct Mapping {
    void* address = nullptr;
    std::size_t bytes = 0;
  };

  std::string path_of_device() const;
  [[noreturn]] void fail(const std::string& doing) const;  // with errno
  void require_capture_node();
  std::string offered_formats() const;
  std::string offered_rates() const;
  v4l2_format current_format() const;
  void choose_format() const;
  void adopt_format(SourceDescription& description);
  void require_as_agreed(const v4l2_format& format) const;
  void set_rate(std::vector<std::string>& warnings);
  v4l2_buffer buffer_for(std::uint32_t index, v4l2_plane& plane) const;
  std::uint32_t request_buffers(std::uint32_t count);
  void map_one(std::uint32_t index);
  bool queue(std::uint32_t index);
  void release_buffers() noexcept;
  bool multiplanar() const { return type_ == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE; }

  V4l2System& system_;
  const SourceSettings settings_;
  std::string path_;
  std::optional<V4l2Node> node_;
  v4l2_capability capability_{};
  std::uint32_t type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  BufferLayout layout_;
  std::size_t buffer_bytes_ = 0;
  std::vector<Mapping> mappings_;
  std::vector<std::uint32_t> refused_;  // by the driver when it was given back
};

// Capture nodes of this machine, as `rotunda cameras` lists them.
std::vector<DiscoveredCamera> discover_v4l2_cameras(V4l2System& system);

}  // namespace rotunda::capture
