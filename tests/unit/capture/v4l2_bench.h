#pragma once
// A V4L2 source on a fake driver, and what it sends.
#include <array>
#include <thread>

#include "capture/base/bounded_queue.h"
#include "capture/source/v4l2_source.h"
#include "config/errors.h"
#include "fake_v4l2.h"

namespace rotunda::capture::test {

using namespace std::chrono_literals;

constexpr auto kSoon = 10s;  // to wait for what comes at once on an idle machine
constexpr std::uint32_t kStart = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
constexpr std::uint32_t kEnd = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;

inline SourceSettings settings_for(PixelFormat format = PixelFormat::yuyv) {
  SourceSettings settings;
  settings.camera = "cam03";
  settings.kind = "v4l2";
  settings.device = "/dev/video0";
  settings.format = format;
  settings.frame_rate_hz = 25.0;
  settings.buffers = 4;
  settings.buffers_at_most = 6;
  return settings;
}

// A source on a fake device, with what it sends.
class Bench {
 public:
  explicit Bench(FakeDriver driver = {}, SourceSettings settings = settings_for())
      : fake({std::move(driver)}), source(make_v4l2_source(settings, fake)) {}

  void stream() {
    source->open();
    source->arm();
    start();
  }
  void start() {
    source->start([this](Frame&& frame) { frames.try_push(std::move(frame)); },
                  [this](const IncompleteFrame& frame) { losses.try_push(frame); });
  }
  Frame next() {
    auto frame = frames.wait_pop(kSoon);
    if (!frame) throw std::runtime_error("no frame came");
    return std::move(*frame);
  }
  IncompleteFrame next_loss() {
    auto loss = losses.wait_pop(kSoon);
    if (!loss) throw std::runtime_error("no loss was told");
    return std::move(*loss);
  }
  bool becomes(SourceState state) const {
    for (const auto end = std::chrono::steady_clock::now() + kSoon; std::chrono::steady_clock::now() < end;) {
      if (source->state() == state) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }
  // What arming says is wrong.
  std::string refusal() {
    try {
      if (source->state() == SourceState::closed) source->open();
      source->arm();
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "";
  }

  FakeV4l2 fake;
  BoundedQueue<Frame> frames{100};
  BoundedQueue<IncompleteFrame> losses{100};
  std::unique_ptr<Source> source;  // last: its thread fills the queues
};

inline std::vector<std::uint8_t> counting(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 37 + i / 251);
  return bytes;
}

inline std::vector<std::uint8_t> bytes_of(const Image& image) {
  return {image.bytes().begin(), image.bytes().end()};
}

inline FakeFrame whole_frame(std::uint32_t sequence = 0) {
  return {counting(16 * 8 * 2), sequence, 999'990ms, kStart};
}

}  // namespace rotunda::capture::test
