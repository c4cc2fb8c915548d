// Finding a camera, agreeing with its driver, its controls.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/source/v4l2_camera.h"
#include "v4l2_bench.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using namespace test;
using testing::AllOf;
using testing::HasSubstr;

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
