// V4L2 capture against a real kernel's driver. Counts and pixels are asserted, never rates: the processor is emulated
// where there is no KVM.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <system_error>
#include <thread>

#include "capture/picture.h"
#include "capture/source/v4l2_format.h"
#include "vivid.h"

namespace rotunda::vm {
namespace {

using namespace std::chrono_literals;
using capture::PixelFormat;
using capture::SourceState;
using testing::Contains;
using testing::HasSubstr;

constexpr auto kSameClock = 60s;  // of another clock it would be years; frames may wait that long on a busy machine
constexpr int kNoText = 2;        // of osd_text_mode: the picture is the pattern alone

TEST(Vivid, TenCamerasAndAnInputAreListed) {
  int cameras = 0;
  for (const auto& camera : capture::discover_cameras())
    if (camera.kind == "v4l2") {
      EXPECT_EQ(camera.model, "vivid");
      EXPECT_FALSE(camera.pixel_format.empty());
      ++cameras;
    }
  EXPECT_EQ(cameras, kCameras + 1);
}

capture::Frame one_frame(const capture::SourceSettings& settings) {
  Stream stream(settings);
  stream.begin();
  return stream.next();
}

// The eight bars, between their edges, where no format's half-resolution colour blurs them.
std::vector<cv::Vec3b> bars_in(const capture::Frame& frame) {
  const cv::Mat rgb = capture::to_rgb(frame.image);
  std::vector<cv::Vec3b> bars;
  for (int i = 0; i < 8; ++i) bars.push_back(rgb.at<cv::Vec3b>(90, (2 * i + 1) * rgb.cols / 16));
  return bars;
}

int furthest(const std::vector<cv::Vec3b>& a, const std::vector<cv::Vec3b>& b) {
  int most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(a[i][c] - b[i][c]));
  return most;
}

TEST(Vivid, EveryFormatOfTheDriverShowsTheSameColours) {
  set_vivid(camera_node(0), "osd_text_mode", kNoText);
  const auto expected = bars_in(one_frame(settings_of(0, PixelFormat::rgb8)));
  EXPECT_GT(furthest({expected[0]}, {expected[7]}), 150) << "bars from white to black";
  int tried = 0;
  for (const auto format : capture::pixel_formats()) {
    if (format == PixelFormat::mono8 || format == PixelFormat::rgb8) continue;
    Stream stream(settings_of(0, format));
    stream.source->open();
    try {
      stream.source->arm();
    } catch (const DeviceError& error) {
      EXPECT_THAT(error.what(), HasSubstr("does not send"));
      continue;
    }
    stream.start();
    // Rounding in Y'CbCr; and vivid's own, which computes every format from a table.
    EXPECT_LE(furthest(bars_in(stream.next()), expected), 4) << capture::to_string(format);
    ++tried;
  }
  EXPECT_GE(tried, 15);  // three of Y'CbCr, twelve of Bayer
}

TEST(Vivid, TheMultiPlanarApiCarriesTheSamePictures) {
  set_vivid(camera_node(9), "osd_text_mode", kNoText);
  const auto expected = bars_in(one_frame(settings_of(0, PixelFormat::rgb8)));
  for (const auto format : {PixelFormat::yuyv, PixelFormat::nv12, PixelFormat::bayer_gr10})
    EXPECT_LE(furthest(bars_in(one_frame(settings_of(9, format))), expected), 4) << capture::to_string(format);
}

TEST(Vivid, ColoursComeOutRightHoweverTheDriverSaysTheyAreCoded) {
  const auto expected = bars_in(one_frame(settings_of(0, PixelFormat::rgb8)));
  for (const auto& [encoding, range, coding] :
       {std::tuple("ITU-R 601", "Limited Range", capture::YcbcrCoding::bt601_limited),
        std::tuple("ITU-R 601", "Full Range", capture::YcbcrCoding::bt601_full),
        std::tuple("Rec. 709", "Limited Range", capture::YcbcrCoding::bt709_limited),
        std::tuple("Rec. 709", "Full Range", capture::YcbcrCoding::bt709_full)}) {
    auto settings = settings_of(0);
    settings.controls = {{"y_cbcr_encoding", encoding}, {"quantization", range}};
    Stream stream(settings);
    stream.begin();
    EXPECT_EQ(stream.source->description().ycbcr, coding);
    EXPECT_LE(furthest(bars_in(stream.next()), expected), 4) << encoding << ", " << range;
  }
  set_vivid(camera_node(0), "y_cbcr_encoding", 0);
  set_vivid(camera_node(0), "quantization", 0);
}

// Shows one picture on the output for as long as it lives. (The driver's write() is not for interlaced pictures.)
class Playout {
 public:
  explicit Playout(const std::vector<std::uint8_t>& picture) : node_(capture::kernel_v4l2(), kOutput) {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    ask(VIDIOC_G_FMT, format);
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_UYVY;
    ask(VIDIOC_S_FMT, format);
    v4l2_requestbuffers request{};
    request.count = kBuffers;
    request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    request.memory = V4L2_MEMORY_MMAP;
    ask(VIDIOC_REQBUFS, request);
    for (std::uint32_t i = 0; i < kBuffers; ++i) fill(i, picture);
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    ask(VIDIOC_STREAMON, type);
    thread_ = std::jthread([this](const std::stop_token& stop) {
      for (; !stop.stop_requested(); std::this_thread::sleep_for(2ms)) show_again();
    });
  }
  ~Playout() {
    thread_ = {};
    for (void* memory : memory_) capture::kernel_v4l2().unmap(memory, bytes_);
  }
  Playout(const Playout&) = delete;
  Playout& operator=(const Playout&) = delete;

 private:
  static constexpr std::uint32_t kBuffers = 4;

  template <class Argument>
  void ask(unsigned long request, Argument& argument) {
    if (!node_.ask(request, argument)) throw std::system_error(errno, std::generic_category(), kOutput);
  }
  v4l2_buffer buffer(std::uint32_t index) const {
    v4l2_buffer one{};
    one.index = index;
    one.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    one.memory = V4L2_MEMORY_MMAP;
    one.field = V4L2_FIELD_INTERLACED;
    one.bytesused = static_cast<std::uint32_t>(bytes_);
    return one;
  }
  void fill(std::uint32_t index, const std::vector<std::uint8_t>& picture) {
    bytes_ = picture.size();
    v4l2_buffer one = buffer(index);
    ask(VIDIOC_QUERYBUF, one);
    if (one.length < bytes_) throw DeviceError(kOutput, "its pictures are smaller");
    memory_.push_back(capture::kernel_v4l2().map(node_.fd(), bytes_, one.m.offset));
    if (memory_.back() == nullptr) throw std::system_error(errno, std::generic_category(), kOutput);
    std::copy(picture.begin(), picture.end(), static_cast<std::uint8_t*>(memory_.back()));
    one = buffer(index);
    ask(VIDIOC_QBUF, one);
  }
  void show_again() {
    v4l2_buffer shown = buffer(0);
    if (!node_.ask(VIDIOC_DQBUF, shown)) return;
    v4l2_buffer next = buffer(shown.index);
    node_.ask(VIDIOC_QBUF, next);
  }

  capture::V4l2Node node_;
  std::size_t bytes_ = 0;
  std::vector<void*> memory_;
  std::jthread thread_;  // last
};

TEST(Vivid, WhatGoesIntoTheOutputComesBitForBitOutOfTheInput) {
  capture::SourceSettings settings = settings_of(10, PixelFormat::uyvy);
  settings.width = 720;  // PAL
  settings.height = 576;
  settings.frame_rate_hz.reset();
  settings.controls = {{"loop_video", "true"}, {"osd_text_mode", "None"}};
  std::vector<std::uint8_t> picture(720 * 576 * 2);
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture[i] = static_cast<std::uint8_t>(16 + (i * 2654435761U >> 7U) % 220);  // noise within the video's range
  const Playout playout(picture);
  Stream stream(settings);
  stream.begin();
  EXPECT_THAT(stream.source->description().warnings, Contains(HasSubstr("interlaced")));
  std::size_t equal = 0;
  for (int i = 0; i < 30 && equal < 3; ++i) {  // the first may be from before the output began
    const auto frame = stream.next();
    ASSERT_EQ(frame.image.bytes().size(), picture.size());
    equal += std::equal(picture.begin(), picture.end(), frame.image.bytes().begin());
  }
  EXPECT_EQ(equal, 3U);
}

TEST(Vivid, TenCamerasOpenStreamStopAndOpenAgain) {
  std::vector<std::unique_ptr<Stream>> streams;
  for (int i = 0; i < kCameras; ++i) streams.push_back(std::make_unique<Stream>(settings_of(i)));
  for (int round = 0; round < 2; ++round) {
    for (const auto& stream : streams) stream->open_and_arm();
    for (int start = 0; start < 2; ++start) {
      for (const auto& stream : streams) stream->start();
      for (const auto& stream : streams) {
        const auto first = stream->next(), second = stream->next();
        EXPECT_LT(first.exposure_start, second.exposure_start);
        EXPECT_LT(std::chrono::abs(capture::RigClock::now() - second.exposure_start), kSameClock);
      }
      for (const auto& stream : streams) stream->source->stop();
    }
    for (const auto& stream : streams) stream->source->close();
  }
  for (const auto& stream : streams) EXPECT_EQ(stream->source->stats().incomplete, 0U);
}

TEST(Vivid, FramesAndGapsTogetherAreTheTimeThatPassed) {
  Stream stream(settings_of(0));
  stream.open_and_arm();
  set_vivid(camera_node(0), "percentage_of_dropped_buffers", 40);
  stream.start();
  const auto first = stream.next().exposure_start;
  auto last = first;
  for (int i = 0; i < 12; ++i) last = stream.next().exposure_start;
  stream.source->stop();
  set_vivid(camera_node(0), "percentage_of_dropped_buffers", 0);
  const auto stats = stream.source->stats();
  EXPECT_GT(stats.dropped, 0U);
  const double periods = std::chrono::duration<double>(last - first) / 200ms;
  // `dropped` may hold a gap after the last frame we took out, and the driver's clock ticks in jiffies of 4 ms.
  EXPECT_NEAR(static_cast<double>(stats.frames + stats.dropped) - 1.0, periods, 3.0);
}

TEST(Vivid, ACameraThatIsUnpluggedIsLostComesBackAndTheOthersStayAsTheyWere) {
  Stream gone(settings_of(0)), stays(settings_of(1));
  gone.begin();
  stays.begin();
  gone.next();
  stays.next();
  set_vivid(camera_node(0), "disconnect", 1);
  EXPECT_TRUE(gone.becomes(SourceState::lost));
  const auto before = stays.source->stats();
  for (int i = 0; i < 5; ++i) stays.next();
  EXPECT_EQ(stays.source->state(), SourceState::streaming);
  EXPECT_EQ(stays.source->stats().incomplete, before.incomplete);
  gone.source->close();
  while (gone.frames.wait_pop(0ns)) {
  }
  gone.begin();
  gone.next();
  EXPECT_EQ(gone.source->state(), SourceState::streaming);
}

TEST(Vivid, AFrameTheDriverMarksAsDamagedIsALossAndTheNextIsGood) {
  Stream stream(settings_of(0));
  stream.begin();
  stream.next();
  set_vivid(camera_node(0), "inject_v4l2_buf_flag_error", 1);
  const auto loss = stream.losses.wait_pop(Stream::kPatience);
  ASSERT_TRUE(loss);
  EXPECT_EQ(loss->because, capture::HoleReason::damaged);
  EXPECT_EQ(loss->flaw, "its driver marked it as damaged");
  for (int i = 0; i < 3; ++i) stream.next();
  EXPECT_EQ(stream.source->stats().incomplete, 1U);
}

TEST(Vivid, ErrorsOfTheBufferCallsAreToldOrOutlived) {
  Stream stream(settings_of(0));
  stream.source->open();
  set_vivid(camera_node(0), "inject_vidioc_reqbufs_error", 1);
  EXPECT_THROW(stream.source->arm(), DeviceError);
  stream.source->close();
  stream.open_and_arm();
  set_vivid(camera_node(0), "inject_vidioc_streamon_error", 1);
  EXPECT_THROW(stream.start(), DeviceError);
  stream.start();  // the fault was for once
  stream.next();
  set_vivid(camera_node(0), "inject_vidioc_qbuf_error", 1);
  for (int i = 0; i < 8; ++i) stream.next();  // more than there are buffers
  EXPECT_EQ(stream.source->state(), SourceState::streaming);
}

TEST(Vivid, AStreamThatBreaksIsALostCameraThatCanBeOpenedAnew) {
  Stream stream(settings_of(0));
  stream.begin();
  stream.next();
  set_vivid(camera_node(0), "inject_fatal_streaming_error", 1);
  EXPECT_TRUE(stream.becomes(SourceState::lost));
  stream.source->close();
  stream.begin();
  stream.next();
}

TEST(Vivid, FrameNumbersThatWrapAreNoGap) {
  auto settings = settings_of(0);
  settings.frame_rate_hz = 60.0;
  Stream fast(settings);
  fast.open_and_arm();
  set_vivid(camera_node(0), "wrap_sequence_number", 1);  // begins 128 before the wrap
  fast.start();
  const auto until = std::chrono::steady_clock::now() + Stream::kPatience;
  const auto seen = [&] { return fast.source->stats().frames + fast.source->stats().dropped; };
  while (seen() < 150 && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(20ms);
  fast.source->stop();
  set_vivid(camera_node(0), "wrap_sequence_number", 0);
  EXPECT_GE(seen(), 150U);
  EXPECT_LT(seen(), 5000U);  // a wrap taken for a gap would be thousands of millions
}

TEST(Vivid, TimeStampsOfAnotherClockGiveWayToTheMomentOfArrival) {
  Stream stream(settings_of(0));
  stream.open_and_arm();
  set_vivid(camera_node(0), "wrap_timestamp", 1);
  stream.start();
  const auto frame = stream.next();
  const auto warnings = stream.source->description().warnings;
  stream.source->stop();
  set_vivid(camera_node(0), "wrap_timestamp", 0);
  EXPECT_LT(std::chrono::abs(capture::RigClock::now() - frame.exposure_start), kSameClock);
  EXPECT_THAT(warnings, Contains(HasSubstr("CLOCK_MONOTONIC")));
}

TEST(Vivid, NothingStaysOpenOrMapped) {
  const auto descriptors = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
  };
  one_frame(settings_of(0));
  const auto before = descriptors();
  for (int i = 0; i < 5; ++i) one_frame(settings_of(i));
  EXPECT_EQ(descriptors(), before);
}

}  // namespace
}  // namespace rotunda::vm
