#include "capture/source/v4l2_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "capture/base/bounded_queue.h"
#include "capture/picture.h"
#include "capture/source/v4l2_camera.h"
#include "capture/source/v4l2_format.h"
#include "config/errors.h"
#include "fake_v4l2.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using test::FakeControl;
using test::FakeDriver;
using test::FakeFrame;
using test::FakeV4l2;
using testing::AllOf;
using testing::HasSubstr;

constexpr auto kSoon = 10s;  // to wait for what comes at once on an idle machine
constexpr std::uint32_t kStart = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
constexpr std::uint32_t kEnd = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;

SourceSettings settings_for(PixelFormat format = PixelFormat::yuyv) {
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

std::vector<std::uint8_t> counting(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 37 + i / 251);
  return bytes;
}

std::vector<std::uint8_t> bytes_of(const Image& image) {
  return {image.bytes().begin(), image.bytes().end()};
}

FakeFrame whole_frame(std::uint32_t sequence = 0) {
  return {counting(16 * 8 * 2), sequence, 999'990ms, kStart};
}

TEST(V4l2Format, EveryFormatThatV4l2HasComesBackAsItself) {
  int known = 0;
  for (const auto format : pixel_formats())
    for (const auto fourcc : fourccs_of(format)) {
      EXPECT_EQ(pixel_format_of(fourcc), format) << fourcc_text(fourcc);
      ++known;
    }
  EXPECT_EQ(known, 27);
  EXPECT_TRUE(fourccs_of(PixelFormat::bayer_rg12p).empty());  // GenICam's own packing
  EXPECT_FALSE(pixel_format_of(V4L2_PIX_FMT_H264));
  EXPECT_EQ(fourcc_text(V4L2_PIX_FMT_SRGGB10P), "pRAA");
}

TEST(V4l2Format, ColorimetryFollowsTheKernelsDefaults) {
  const auto coding = [](std::uint32_t space, std::uint32_t encoding, std::uint32_t range) {
    return colorimetry_of(space, encoding, range).coding;
  };
  EXPECT_EQ(coding(V4L2_COLORSPACE_SRGB, 0, 0), YcbcrCoding::bt601_limited);
  EXPECT_EQ(coding(V4L2_COLORSPACE_SMPTE170M, 0, 0), YcbcrCoding::bt601_limited);
  EXPECT_EQ(coding(V4L2_COLORSPACE_REC709, 0, 0), YcbcrCoding::bt709_limited);
  EXPECT_EQ(coding(V4L2_COLORSPACE_JPEG, 0, 0), YcbcrCoding::bt601_full);
  EXPECT_EQ(coding(V4L2_COLORSPACE_SRGB, V4L2_YCBCR_ENC_709, V4L2_QUANTIZATION_FULL_RANGE), YcbcrCoding::bt709_full);
  EXPECT_EQ(coding(V4L2_COLORSPACE_REC709, V4L2_YCBCR_ENC_XV601, V4L2_QUANTIZATION_LIM_RANGE),
            YcbcrCoding::bt601_limited);
  EXPECT_TRUE(colorimetry_of(V4L2_COLORSPACE_REC709, 0, 0).exact);
  EXPECT_FALSE(colorimetry_of(V4L2_COLORSPACE_BT2020, 0, 0).exact);
}

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

std::string first_words(const std::function<void()>& call) {
  try {
    call();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "";
}

TEST(V4l2Source, SaysWhyItCannotOpenANodeAndWhatToDo) {
  const std::pair<int, const char*> cases[] = {
      {EACCES, "group video"}, {EBUSY, "fuser -v /dev/video0"}, {ENODEV, "rotunda cameras"}};
  for (const auto& [error, cure] : cases) {
    FakeDriver driver;
    driver.open_error = error;
    Bench bench(driver);
    EXPECT_THAT(first_words([&] { bench.source->open(); }), AllOf(HasSubstr("cam03"), HasSubstr(cure)));
  }
  FakeDriver metadata, reader, no_video;
  metadata.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  reader.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE;
  no_video.refusals = {{VIDIOC_QUERYCAP, ENOTTY}};
  EXPECT_THAT(first_words([&] { Bench(metadata).source->open(); }), HasSubstr("captures no pictures"));
  EXPECT_THAT(first_words([&] { Bench(reader).source->open(); }), HasSubstr("cannot stream"));
  EXPECT_THAT(first_words([&] { Bench(no_video).source->open(); }), HasSubstr("no video device"));
}

TEST(V4l2Source, FindsACameraBySerialNumberAndBusAddress) {
  FakeDriver first, second;
  second.serial = "A77";
  second.bus = "usb-0000:00:14.0-9";
  for (const auto* name : {"A77", "usb-0000:00:14.0-9", "/dev/video1"}) {
    FakeV4l2 fake({first, second});
    auto settings = settings_for();
    settings.device = name;
    const auto source = make_v4l2_source(settings, fake);
    source->open();
    source->arm();
    EXPECT_EQ(source->description().address, "/dev/video1");
    EXPECT_EQ(source->description().serial, "A77");
  }
  FakeV4l2 fake({first, second});
  auto settings = settings_for();
  settings.device = "B1";
  EXPECT_THAT(first_words([&] { make_v4l2_source(settings, fake)->open(); }), HasSubstr("\"B1\""));
}

TEST(V4l2Source, RefusesWhatTheCameraDoesNotSendAndNamesWhatItDoes) {
  FakeDriver driver;
  driver.formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_H264};
  EXPECT_THAT(Bench(driver, settings_for(PixelFormat::bayer_rg8)).refusal(),
              HasSubstr("does not send BayerRG8; set pixel_format to one of: YUYV, MJPEG, H264 (not supported)"));
  auto large = settings_for();
  large.width = 640;
  EXPECT_THAT(Bench(driver, large).refusal(), HasSubstr("sends 16 x 8 where 640 x"));
  driver.field = V4L2_FIELD_ALTERNATE;
  EXPECT_THAT(Bench(driver).refusal(), HasSubstr("half frames"));
  driver.field = V4L2_FIELD_NONE;
  driver.width = 15;
  EXPECT_THAT(Bench(driver).refusal(), HasSubstr("15 x 8, which YUYV cannot be"));
  driver.width = 16;
  driver.stored_bits = 8;
  EXPECT_THAT(Bench(driver).refusal(), HasSubstr("too few"));
  for (const auto mode : {TriggerMode::software, TriggerMode::action}) {
    auto triggered = settings_for();
    triggered.trigger = mode;
    EXPECT_THAT(Bench({}, triggered).refusal(), HasSubstr("set trigger.mode to freerun"));
  }
}

TEST(V4l2Source, TellsABusyCameraAndTakesFewerBuffersWhereMemoryIsShort) {
  for (const unsigned long request : {VIDIOC_S_FMT, VIDIOC_REQBUFS, VIDIOC_S_PARM}) {
    FakeDriver driver;
    driver.refusals = {{request, EBUSY}};
    EXPECT_THAT(Bench(driver).refusal(), HasSubstr("another program uses it")) << request;
  }
  FakeDriver short_of_memory;
  short_of_memory.most_buffers = 2;
  Bench bench(short_of_memory);
  bench.stream();
  EXPECT_TRUE(bench.fake.send(whole_frame()));
  FakeDriver hopeless;
  hopeless.most_buffers = 1;
  EXPECT_THAT(Bench(hopeless).refusal(), HasSubstr("asking for frame buffers"));
}

TEST(V4l2Source, TellsRatesThatDifferOrCannotBeSet) {
  const auto warnings = [](const FakeDriver& driver) {
    Bench bench(driver);
    bench.source->open();
    bench.source->arm();
    return bench.source->description().warnings;
  };
  FakeDriver driver;
  EXPECT_THAT(warnings(driver), testing::IsEmpty());
  driver.rates = {15, 30};
  EXPECT_THAT(warnings(driver), testing::ElementsAre(AllOf(HasSubstr("it sends 30 Hz"), HasSubstr("asks for 25"),
                                                           HasSubstr("it offers 15, 30 Hz"))));
  driver.rates = {};
  EXPECT_THAT(warnings(driver), testing::ElementsAre(HasSubstr("sets no frame rate")));
  driver.rates = {25};
  driver.field = V4L2_FIELD_INTERLACED;
  EXPECT_THAT(warnings(driver), testing::ElementsAre(HasSubstr("interlaced")));
}

FakeDriver with_controls() {
  FakeDriver driver;
  driver.controls = {
      {.id = V4L2_CID_GAIN, .name = "Gain", .maximum = 100},
      {.id = V4L2_CID_AUTO_WHITE_BALANCE,
       .name = "White Balance, Automatic",
       .type = V4L2_CTRL_TYPE_BOOLEAN,
       .maximum = 1,
       .value = 1},
      {.id = V4L2_CID_POWER_LINE_FREQUENCY,
       .name = "Power Line Frequency",
       .type = V4L2_CTRL_TYPE_MENU,
       .maximum = 2,
       .menu = {"Disabled", "50 Hz", "60 Hz"}},
      {.id = V4L2_CID_FOCUS_ABSOLUTE, .name = "Focus, Absolute", .maximum = 250, .read_only = true},
  };
  return driver;
}

TEST(V4l2Controls, AreSetByNameAndWhatDiffersIsTold) {
  for (const bool old_calls : {false, true}) {
    auto driver = with_controls();
    driver.old_control_calls = old_calls;
    auto settings = settings_for();
    settings.controls = {
        {"white_balance_automatic", "false"}, {"Power Line Frequency", "50 Hz"}, {"gain", "0x10"}, {"GAIN", "400"}};
    Bench bench(driver, settings);
    bench.source->open();
    bench.source->arm();
    EXPECT_EQ(bench.fake.control("White Balance, Automatic"), 0);
    EXPECT_EQ(bench.fake.control("Power Line Frequency"), 1);
    EXPECT_EQ(bench.fake.control("Gain"), 100);
    EXPECT_THAT(bench.source->description().warnings,
                testing::ElementsAre(HasSubstr("control gain is 100 where 400 was asked (it takes 0 to 100)")));
  }
}

TEST(V4l2Controls, NameWhatThereIsWhenOneIsUnknownOrRefused) {
  const auto refusal = [](CameraControl control) {
    auto settings = settings_for();
    settings.controls = {std::move(control)};
    return Bench(with_controls(), settings).refusal();
  };
  EXPECT_THAT(refusal({"sharpness", "3"}),
              AllOf(HasSubstr("has no control sharpness"), HasSubstr("power_line_frequency")));
  EXPECT_THAT(refusal({"power_line_frequency", "70 Hz"}), HasSubstr("takes one of Disabled, 50 Hz, 60 Hz"));
  EXPECT_THAT(refusal({"gain", "much"}), HasSubstr("takes 0 to 100, not \"much\""));
  EXPECT_THAT(refusal({"focus_absolute", "7"}), HasSubstr("read-only or held by an automatic mode"));
  auto settings = settings_for();
  settings.exposure_us = 3000;
  EXPECT_THAT(Bench(with_controls(), settings).refusal(), HasSubstr("no exposure in microseconds"));
  settings.exposure_us.reset();
  settings.controls = {{"gain", "3"}};
  EXPECT_THAT(Bench({}, settings).refusal(), HasSubstr("it has none"));
}

TEST(DiscoverV4l2, ListsTheNodesThatCapture) {
  FakeDriver camera, metadata, locked;
  camera.serial = "S1";
  camera.formats = {V4L2_PIX_FMT_H264, V4L2_PIX_FMT_NV12};
  metadata.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  locked.open_error = EACCES;
  FakeV4l2 fake({camera, metadata, locked});
  const auto found = discover_v4l2_cameras(fake);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, "v4l2");
  EXPECT_EQ(found[0].address, "/dev/video0");
  EXPECT_EQ(found[0].serial, "S1");
  EXPECT_EQ(found[0].model, "Fake Camera");
  EXPECT_EQ(found[0].pixel_format, "NV12");
  EXPECT_EQ(fake.open_nodes(), 0);
}

}  // namespace
}  // namespace rotunda::capture
