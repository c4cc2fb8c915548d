// USB3 Vision cameras through unmodified Aravis and libusb, behind a mocked USB port. Counts and pixels are asserted,
// never this machine's speed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "capture/base/bounded_queue.h"
#include "capture/source/source.h"
#include "config/errors.h"
#include "tests/support/private_network.h"
#include "tests/usb/mocked_usb_device.h"
#include "tests/usb/u3v_camera.h"

namespace rotunda::tests {
namespace {

using namespace std::chrono_literals;
using capture::SourceState;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr auto kPatience = 30s;  // on a machine that is busy elsewhere
constexpr auto kQuiet = 300ms;   // in which nothing may come
constexpr auto kShutter = 2ms;   // how often the sensor looks whether a frame is due
constexpr const char* kSerial = "U3V0007";

// The camera on a port; its frames come from a thread, as from a sensor.
class MockedU3vCamera {
 public:
  explicit MockedU3vCamera(const U3vCameraOptions& options = {.serial = kSerial})
      : camera_(options),
        usb_(usb_options(options), {.string = [this](unsigned number) { return camera_.string_descriptor(number); },
                                    .receive = [this](unsigned, std::span<const std::uint8_t> bytes) { obey(bytes); },
                                    .send = [this](unsigned endpoint) { return next(endpoint); }}) {
    sensor_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        std::this_thread::sleep_for(kShutter);
        expose();
        usb_.serve();
      }
    });
  }
  // Its power comes by the same cable.
  void unplug() {
    usb_.unplug();
    camera_.power_up();
    const std::lock_guard lock(mutex_);
    transfers_.clear();
    acknowledges_.clear();
  }
  void plug_in() { usb_.plug_in(); }

 private:
  MockedUsbOptions usb_options(const U3vCameraOptions& options) const {
    Bytes descriptors = camera_.device_descriptor();
    const Bytes configuration = camera_.configuration(512);
    descriptors.insert(descriptors.end(), configuration.begin(), configuration.end());
    return {.port = "1-5", .number = 3, .serial = options.serial, .speed = "480", .descriptors = descriptors};
  }

  void obey(std::span<const std::uint8_t> command) {
    const std::lock_guard lock(mutex_);
    acknowledges_.push_back(camera_.answer(command));
  }

  // A frame only when the last has gone: a camera that is not fetched from drops what it exposes.
  void expose() {
    const std::lock_guard lock(mutex_);
    if (!camera_.stream_enabled()) transfers_.clear();
    if (!transfers_.empty()) return;
    for (auto& transfer : camera_.next_frame()) transfers_.push_back(std::move(transfer));
  }

  std::optional<Bytes> next(unsigned endpoint) {
    const std::lock_guard lock(mutex_);
    auto& queue = endpoint == U3vCamera::kStreamIn ? transfers_ : acknowledges_;
    if (queue.empty()) return std::nullopt;
    Bytes bytes = std::move(queue.front());
    queue.pop_front();
    return bytes;
  }

  std::mutex mutex_;  // guards the queues; taken after the mocked device's
  std::deque<Bytes> acknowledges_, transfers_;
  U3vCamera camera_;
  MockedUsbDevice usb_;
  std::jthread sensor_;  // last: ends before what it uses goes
};

capture::SourceSettings u3v_settings(std::optional<double> frame_rate_hz = std::nullopt) {
  capture::SourceSettings settings;
  settings.camera = "cam00";
  settings.device = kSerial;
  settings.format = capture::PixelFormat::mono8;
  settings.trigger = capture::TriggerMode::freerun;
  settings.frame_rate_hz = frame_rate_hz;
  return settings;
}

// A source whose frames can be waited for.
class U3vStream {
 public:
  explicit U3vStream(const capture::SourceSettings& settings) : source_(capture::make_source(settings)) {}
  ~U3vStream() { source_->close(); }

  capture::Source& source() { return *source_; }
  void begin() {
    source_->open();
    source_->arm();
    start();
  }
  void start() {
    while (next(0s)) {  // what came before
    }
    source_->start([this](capture::Frame&& frame) { frames_.push_drop_oldest(std::move(frame)); });
  }
  std::optional<capture::Frame> next(std::chrono::nanoseconds patience = kPatience) {
    return frames_.wait_pop(patience);
  }
  bool becomes(SourceState state) const {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (source_->state() != state && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(20ms);
    return source_->state() == state;
  }

 private:
  capture::BoundedQueue<capture::Frame> frames_{64};
  std::unique_ptr<capture::Source> source_;  // last: its thread fills the queue
};

// Every pixel is the one the camera sent.
void expect_frame(const capture::Frame& frame, int width, int height) {
  ASSERT_EQ(frame.image.width, width);
  ASSERT_EQ(frame.image.height, height);
  ASSERT_TRUE(frame.id);
  const auto bytes = frame.image.bytes();
  std::size_t wrong = 0, at = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) wrong += bytes[at++] != U3vCamera::pixel(*frame.id, x, y);
  EXPECT_EQ(wrong, 0U) << "of frame " << *frame.id;
}

// The first frames since the start, none missing.
void expect_frames(U3vStream& stream, std::uint64_t count, int width, int height) {
  for (std::uint64_t id = 0; id < count; ++id) {
    const auto frame = stream.next();
    ASSERT_TRUE(frame) << "frame " << id << " of " << count << " never came";
    EXPECT_EQ(frame->id, id);
    expect_frame(*frame, width, height);
  }
}

std::string refusal(const std::function<void(capture::SourceSettings&)>& change) {
  auto settings = u3v_settings();
  change(settings);
  U3vStream stream(settings);
  try {
    stream.source().open();
    stream.source().arm();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "";
}

// Looking for cameras, Aravis asks the network too: one of our own.
class U3vSource : public testing::Test {
 protected:
  void SetUp() override {
    if (const auto why_not = enter_private_network(); !why_not.empty()) GTEST_SKIP() << why_not;
  }
};

MATCHER(IsTheU3vCamera, "") {
  return arg.kind == "aravis" && arg.serial == kSerial && arg.vendor == "Rotunda" && arg.model == "U3V test camera";
}

TEST_F(U3vSource, IsListedWithSerialNumberAndMakers) {
  const MockedU3vCamera camera;
  EXPECT_THAT(capture::discover_cameras(), testing::Contains(IsTheU3vCamera()));
}

TEST_F(U3vSource, StreamsStopsAndStreamsAgainEveryPixelAsSent) {
  const MockedU3vCamera camera;
  auto settings = u3v_settings(20.0);
  settings.exposure_us = 2000.0;
  U3vStream stream(settings);
  stream.begin();
  expect_frames(stream, 10, 64, 48);
  EXPECT_EQ(stream.source().description().serial, kSerial);
  EXPECT_EQ(stream.source().description().exposure, 2ms) << "as the camera answered";
  EXPECT_THAT(stream.source().look().temperature_c, testing::Optional(41.5));
  stream.source().stop();
  EXPECT_EQ(stream.source().state(), SourceState::armed);
  while (stream.next(0s)) {
  }
  EXPECT_FALSE(stream.next(kQuiet)) << "it was stopped";
  stream.start();
  expect_frames(stream, 5, 64, 48);
  EXPECT_EQ(stream.source().stats().incomplete, 0U);
}

TEST_F(U3vSource, CanBeClosedAndOpenedAgainWithAnotherRegion) {
  const MockedU3vCamera camera;
  auto settings = u3v_settings(20.0);
  {
    U3vStream stream(settings);
    stream.begin();
    expect_frames(stream, 3, 64, 48);
    stream.source().close();
    EXPECT_EQ(stream.source().state(), SourceState::closed);
  }
  settings.width = 40;
  settings.height = 24;
  U3vStream again(settings);
  again.begin();
  expect_frames(again, 5, 40, 24);
}

TEST_F(U3vSource, FiresOneFrameForEachSoftwareTrigger) {
  const MockedU3vCamera camera;
  auto settings = u3v_settings();
  settings.trigger = capture::TriggerMode::software;
  U3vStream stream(settings);
  stream.begin();
  EXPECT_FALSE(stream.next(kQuiet)) << "nobody has triggered";
  for (std::uint64_t trigger = 0; trigger < 4; ++trigger) {
    stream.source().software_trigger();
    const auto frame = stream.next();
    ASSERT_TRUE(frame) << "of trigger " << trigger;
    EXPECT_EQ(frame->id, trigger);
    expect_frame(*frame, 64, 48);
  }
  EXPECT_FALSE(stream.next(kQuiet));
}

TEST_F(U3vSource, SaysWhatItCannotTake) {
  const MockedU3vCamera camera;
  using Settings = capture::SourceSettings;
  EXPECT_THAT(refusal([](Settings& s) { s.format = capture::PixelFormat::bayer_rg8; }), HasSubstr("Mono8"));
  EXPECT_THAT(refusal([](Settings& s) { s.width = 4096; }), HasSubstr("4096"));
  EXPECT_THAT(refusal([](Settings& s) { s.device = "NOBODY"; }), HasSubstr("no camera answers"));
  EXPECT_THAT(refusal([](Settings& s) { s.trigger = capture::TriggerMode::action; }), HasSubstr("no action commands"));
  EXPECT_EQ(refusal([](Settings&) {}), "");
}

TEST_F(U3vSource, PulledOutItIsLostAndPluggedInAgainItStreams) {
  MockedU3vCamera camera;
  U3vStream stream(u3v_settings(20.0));
  stream.begin();
  expect_frames(stream, 2, 64, 48);
  EXPECT_EQ(stream.source().state(), SourceState::streaming);
  camera.unplug();
  EXPECT_TRUE(stream.becomes(SourceState::lost));
  EXPECT_THAT([&] { stream.source().stop(); }, ThrowsMessage<DeviceError>(HasSubstr("was lost")));
  stream.source().close();
  EXPECT_THAT([&] { stream.source().open(); }, ThrowsMessage<DeviceError>(HasSubstr("no camera")));
  camera.plug_in();
  stream.begin();
  expect_frames(stream, 2, 64, 48);
}

}  // namespace
}  // namespace rotunda::tests
