#include "capture/source/v4l2_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/picture.h"
#include "capture/source/v4l2_camera.h"
#include "capture/source/v4l2_format.h"
#include "v4l2_bench.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using namespace test;
using testing::AllOf;
using testing::HasSubstr;

TEST(V4l2Source, HandsOnEveryFormatBitForBitWithoutThePaddingOfItsRows) {
  int tried = 0;
  for (const auto format : pixel_formats()) {
    if (fourccs_of(format).empty() || format == PixelFormat::mjpeg) continue;
    for (const std::uint32_t padding : {0U, 24U}) {
      FakeDriver driver;
      driver.formats = {fourccs_of(format).front()};
      driver.stored_bits = static_cast<std::uint32_t>(layout_of(format).stored_bits);
      driver.padding = padding;
      Bench bench(driver, settings_for(format));
      bench.stream();
      const auto pixels = counting(image_bytes(16, 8, format));
      const std::size_t row = bytes_in_row(16, format);
      FakeFrame frame = whole_frame();
      frame.bytes.clear();
      for (std::size_t at = 0; at < pixels.size(); at += row) {
        frame.bytes.insert(frame.bytes.end(), pixels.begin() + static_cast<std::ptrdiff_t>(at),
                           pixels.begin() + static_cast<std::ptrdiff_t>(at + row));
        frame.bytes.insert(frame.bytes.end(), padding, 0xEE);
      }
      ASSERT_TRUE(bench.fake.send(frame));
      const Frame got = bench.next();
      EXPECT_EQ(got.camera, "cam03");
      EXPECT_EQ(got.image.format, format);
      EXPECT_EQ(bytes_of(got.image), pixels) << to_string(format) << " padding " << padding;
      ++tried;
    }
  }
  EXPECT_EQ(tried, 50);
}

TEST(V4l2Source, TellsHowColoursAreCodedAsTheDriverSays) {
  FakeDriver driver;
  driver.colorspace = V4L2_COLORSPACE_REC709;
  driver.quantization = V4L2_QUANTIZATION_FULL_RANGE;
  Bench bench(driver);
  bench.stream();
  EXPECT_EQ(bench.source->description().ycbcr, YcbcrCoding::bt709_full);
  ASSERT_TRUE(bench.fake.send(whole_frame()));
  EXPECT_EQ(bench.next().image.ycbcr, YcbcrCoding::bt709_full);
}

// 16 x 8 pixels in the plainest JPEG there can be, for its frame is never decoded here.
std::vector<std::uint8_t> small_jpeg(std::uint8_t width = 16) {
  return {0xFF, 0xD8, 0xFF, 0xC0, 0, 11, 8, 0, 8, 0, width, 1, 1, 0x11, 0, 0xFF, 0xDA, 0, 2, 7, 7, 7, 0xFF, 0xD9};
}

TEST(V4l2Source, AJpegIsAsLongAsItIsAndADamagedOneIsALossWithItsReason) {
  FakeDriver driver;
  driver.formats = {V4L2_PIX_FMT_H264, V4L2_PIX_FMT_JPEG};  // the older of the two names
  Bench bench(driver, settings_for(PixelFormat::mjpeg));
  bench.stream();
  FakeFrame frame = whole_frame();
  frame.bytes = small_jpeg();
  bench.fake.send(frame);
  EXPECT_EQ(bytes_of(bench.next().image), small_jpeg());
  frame.bytes.pop_back();
  bench.fake.send(frame);
  EXPECT_EQ(bench.next_loss().flaw, "damaged JPEG: cut short");
  frame.bytes = small_jpeg(24);
  bench.fake.send(frame);
  EXPECT_THAT(bench.next_loss().flaw, HasSubstr("24 x 8 where 16 x 8 was agreed"));
  frame.bytes.clear();
  bench.fake.send(frame);
  EXPECT_THAT(bench.next_loss().flaw, HasSubstr("no beginning"));
  EXPECT_EQ(bench.source->stats().frames, 1U);
  EXPECT_EQ(bench.source->stats().incomplete, 3U);
}

TEST(V4l2Source, MovesTimeStampsToTheRigsClock) {
  Bench bench;
  bench.stream();
  const Timestamp rig(1'763'000'000s);
  bench.fake.set_time(5000s, rig);
  FakeFrame frame = whole_frame();
  frame.time = 4999'960'123us;
  bench.fake.send(frame);
  EXPECT_EQ(bench.next().exposure_start, rig - 39'877us);
  bench.fake.set_time(5000s, rig + 37s);  // the rig's clock was set: the next frame follows
  bench.fake.send(frame);
  EXPECT_EQ(bench.next().exposure_start, rig + 37s - 39'877us);
  frame.time = 5000'020ms;  // some drivers stamp a little ahead
  bench.fake.send(frame);
  EXPECT_EQ(bench.next().exposure_start, rig + 37s + 20ms);
}

TEST(V4l2Source, TakesTheExposureOffAStampOfTheFramesEnd) {
  FakeDriver driver;
  driver.controls = {{.id = V4L2_CID_EXPOSURE_AUTO,
                      .name = "Auto Exposure",
                      .type = V4L2_CTRL_TYPE_MENU,
                      .maximum = 3,
                      .value = 3,
                      .menu = {"", "Manual Mode", "", "Aperture Priority Mode"}},
                     {.id = V4L2_CID_EXPOSURE_ABSOLUTE,
                      .name = "Exposure Time, Absolute",
                      .minimum = 1,
                      .maximum = 5000,
                      .value = 150}};
  auto settings = settings_for();
  settings.exposure_us = 4000;
  Bench bench(driver, settings);
  bench.stream();
  EXPECT_EQ(bench.fake.control("Auto Exposure"), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(bench.fake.control("Exposure Time, Absolute"), 40);
  const Timestamp rig(1'763'000'000s);
  bench.fake.set_time(5000s, rig);
  FakeFrame frame = whole_frame();
  frame.time = 5000s;
  frame.flags = kEnd;
  bench.fake.send(frame);
  const Frame got = bench.next();
  EXPECT_EQ(got.exposure, 4ms);
  EXPECT_EQ(got.exposure_start, rig - 4ms);
}

TEST(V4l2Source, TakesTheArrivalForStampsOfAnotherClockAndSaysSo) {
  for (const auto& [time, flags] :
       {std::pair(std::chrono::nanoseconds(2'147'483'632s), kStart),
        std::pair(std::chrono::nanoseconds(4'000s), kStart), std::pair(std::chrono::nanoseconds::max(), kStart),
        std::pair(std::chrono::nanoseconds(5'000s), std::uint32_t{0})}) {
    Bench bench;
    bench.stream();
    const Timestamp rig(1'763'000'000s);
    bench.fake.set_time(5000s, rig);
    FakeFrame frame = whole_frame();
    frame.time = time;
    frame.flags = flags;
    bench.fake.send(frame);
    EXPECT_EQ(bench.next().exposure_start, rig);
    EXPECT_THAT(bench.source->description().warnings, testing::Contains(HasSubstr("CLOCK_MONOTONIC")));
  }
}

TEST(V4l2Source, CountsGapsInTheDriversNumbersAlsoWhereTheyWrap) {
  Bench bench;
  bench.stream();
  std::vector<std::uint64_t> ids;
  for (const std::uint32_t sequence : {0xFFFFFFFDU, 0xFFFFFFFEU, 1U, 2U, 5U}) {  // two missing, then two
    ASSERT_TRUE(bench.fake.send(whole_frame(sequence)));
    ids.push_back(bench.next().id.value());
  }
  EXPECT_EQ(bench.source->stats().dropped, 4U);
  for (std::size_t i = 1; i < ids.size(); ++i) EXPECT_EQ(ids[i] - ids[0], (std::array{0U, 1U, 4U, 5U, 8U}[i]));
  for (const std::uint32_t sequence : {5U, 5U, 0U, 900'000U}) {  // drivers that do not count, or count anew
    ASSERT_TRUE(bench.fake.send(whole_frame(sequence)));
    EXPECT_FALSE(bench.next().id);
  }
  EXPECT_EQ(bench.source->stats().dropped, 4U);
  EXPECT_EQ(bench.source->stats().frames, 9U);
}

TEST(V4l2Source, ShortAndMarkedFramesAreLossesAndTheNextIsGood) {
  Bench bench;
  bench.stream();
  FakeFrame cut = whole_frame();
  cut.bytes.resize(100);
  bench.fake.send(cut);
  const auto loss = bench.next_loss();
  EXPECT_EQ(loss.because, HoleReason::damaged);
  EXPECT_EQ(loss.flaw, "cut short: 100 of 256 bytes");
  EXPECT_TRUE(loss.exposure_start);  // so that it finds its frame set
  FakeFrame marked = whole_frame();
  marked.flags |= V4L2_BUF_FLAG_ERROR;
  bench.fake.send(marked);
  EXPECT_THAT(bench.next_loss().flaw, HasSubstr("marked it as damaged"));
  bench.fake.send(whole_frame());
  EXPECT_EQ(bytes_of(bench.next().image), whole_frame().bytes);
}

TEST(V4l2Source, ReadersMayHoldFramesUpToTheLimitAndBeyondItFramesAreCounted) {
  Bench bench;
  bench.stream();
  std::vector<Frame> held;
  for (std::uint32_t i = 0; i < 6; ++i) {  // more than the driver has buffers
    ASSERT_TRUE(bench.fake.send(whole_frame(i)));
    held.push_back(bench.next());
  }
  ASSERT_TRUE(bench.fake.send(whole_frame(6)));
  EXPECT_THAT(bench.next_loss().flaw, HasSubstr("readers hold all"));
  EXPECT_EQ(bench.source->stats().underruns, 1U);
  held.pop_back();
  ASSERT_TRUE(bench.fake.send(whole_frame(7)));
  held.push_back(bench.next());
  bench.source->close();
  for (const auto& frame : held) EXPECT_EQ(bytes_of(frame.image), whole_frame().bytes);  // they outlive the camera
}

TEST(V4l2Source, IsLostWhenUnpluggedAndComesBackWhenOpenedAnew) {
  Bench bench;
  bench.stream();
  bench.fake.send(whole_frame());
  bench.next();
  bench.fake.unplug();
  EXPECT_TRUE(bench.becomes(SourceState::lost));
  EXPECT_THROW(bench.source->stop(), DeviceError);
  bench.source->close();
  EXPECT_THROW(bench.source->open(), DeviceError);
  bench.fake.plug_in();
  bench.stream();
  bench.fake.send(whole_frame());
  EXPECT_EQ(bytes_of(bench.next().image), whole_frame().bytes);
  bench.source->close();
  EXPECT_EQ(bench.fake.open_nodes(), 0);
  EXPECT_EQ(bench.fake.mapped(), 0);
}

TEST(V4l2Source, IsLostWhenTheDriverGivesUp) {
  for (const int error : {EIO, ENODEV, EPIPE}) {
    Bench bench;
    bench.stream();
    bench.fake.refuse(VIDIOC_DQBUF, error);
    EXPECT_TRUE(bench.becomes(SourceState::lost)) << std::strerror(error);
  }
}

TEST(V4l2Source, IsLostWhenNoFrameComesForSeconds) {
  Bench bench;
  bench.stream();
  bench.fake.set_time(1002s, Timestamp(1'763'000'002s));
  std::this_thread::sleep_for(250ms);
  EXPECT_EQ(bench.source->state(), SourceState::streaming);  // two seconds are not many
  bench.fake.set_time(1004s, Timestamp(1'763'000'004s));
  EXPECT_TRUE(bench.becomes(SourceState::lost));
}

TEST(V4l2Source, WaitsForACableThatTriggersHoweverLong) {
  auto settings = settings_for();
  settings.trigger = TriggerMode::line;
  Bench bench({}, settings);
  bench.stream();
  bench.fake.set_time(9000s, Timestamp(1'763'008'000s));
  std::this_thread::sleep_for(250ms);
  EXPECT_EQ(bench.source->state(), SourceState::streaming);
}

TEST(V4l2Source, ABufferTheDriverRefusesIsOfferedAgain) {
  Bench bench;
  bench.stream();
  bench.fake.refuse(VIDIOC_QBUF, EINVAL);
  for (std::uint32_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(bench.fake.send(whole_frame(i)));
    bench.next();
  }
  bench.fake.refuse(VIDIOC_QBUF, 0);
  for (std::uint32_t i = 3; i < 20; ++i) {  // one buffer would do, but all are in use again
    ASSERT_TRUE(bench.fake.send(whole_frame(i)));
    bench.next();
  }
  bench.fake.refuse(VIDIOC_QBUF, EINVAL);
  while (bench.fake.send(whole_frame())) {
  }
  EXPECT_TRUE(bench.becomes(SourceState::lost));  // none left
}

TEST(V4l2Source, StopsAndStartsAgainAndIsSilentInBetween) {
  Bench bench;
  bench.stream();
  for (int round = 0; round < 20; ++round) {
    ASSERT_TRUE(bench.fake.send(whole_frame()));
    if (round % 2 == 0) bench.next();  // odd rounds stop with a frame on its way
    bench.source->stop();
    EXPECT_EQ(bench.source->state(), SourceState::armed);
    EXPECT_FALSE(bench.fake.send(whole_frame()));
    while (bench.frames.wait_pop(0ns)) {
    }
    bench.start();
  }
  EXPECT_THROW(bench.source->software_trigger(), DeviceError);
  EXPECT_THROW(bench.source->open(), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
