#include "simulator/studio/re_exposure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "config/errors.h"
#include "simulator/gige/gige_studio.h"
#include "simulator/served_studio.h"
#include "simulator/studio/pixel_encoding.h"
#include "tests/support/aravis_client.h"
#include "tests/support/private_network.h"

namespace rotunda::simulator {
namespace {

using capture::PixelFormat;
using capture::Timestamp;
using tests::AravisClient;
using namespace std::chrono_literals;

constexpr int kWidth = 160, kHeight = 120;
constexpr std::size_t kCamera = 3;
constexpr std::uint64_t kFrame = 7;

// A ramp of grey from left to right, no light to a fifth of what saturates.
cv::Mat ramp() {
  cv::Mat light(kHeight, kWidth, CV_32FC3);
  for (int x = 0; x < kWidth; ++x) light.col(x).setTo(cv::Scalar::all(0.2 * x / kWidth));
  return light;
}

// What camera kCamera gives with the settings.
std::vector<std::uint8_t> exposed(const ExposureSettings& settings, PixelFormat format = PixelFormat::bayer_rg8) {
  SensorOptions options;
  options.cameras.resize(kCamera + 1);
  options.cameras[kCamera] = {settings.exposure_s, settings.gain_db, settings.balance[0], settings.balance[2]};
  return encode_pixels(Sensor({kWidth, kHeight}, kCamera, options).expose(ramp(), kFrame), format);
}

ReExposure re_exposure(PixelFormat format = PixelFormat::bayer_rg8) {
  SensorOptions options;
  options.cameras.resize(kCamera + 1);
  return {options, kCamera, format, kWidth};
}

double mean_of(const std::vector<std::uint8_t>& pixels) {
  double sum = 0.0;
  for (const auto pixel : pixels) sum += pixel;
  return sum / static_cast<double>(pixels.size());
}

// Root of the mean squared difference of two pictures, in codes.
double rms(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

class ReExposureOf : public testing::TestWithParam<ExposureSettings> {};

TEST_P(ReExposureOf, IsWhatTheSensorWouldHaveGiven) {
  const auto re_exposed = re_exposure()(exposed({}), kFrame, GetParam());
  const auto expected = exposed(GetParam());
  ASSERT_EQ(re_exposed.size(), expected.size());
  // The codes' own rounding, amplified by the change.
  EXPECT_LT(rms(re_exposed, expected), 1.6);
  EXPECT_NEAR(mean_of(re_exposed), mean_of(expected), 0.25);
  EXPECT_GT(rms(re_exposed, exposed({})), 5.0);
}

INSTANTIATE_TEST_SUITE_P(Settings, ReExposureOf,
                         testing::Values(ExposureSettings{.exposure_s = 0.0025}, ExposureSettings{.exposure_s = 0.020},
                                         ExposureSettings{.gain_db = 6.0},
                                         ExposureSettings{.balance = {1.5, 1.0, 0.6}}));

TEST(ReExposure, WithTheRenderedSettingsChangesNothing) {
  for (const auto format : {PixelFormat::bayer_rg8, PixelFormat::bayer_bg8, PixelFormat::rgb8, PixelFormat::mono8}) {
    const auto picture = exposed({}, format);
    EXPECT_LT(rms(re_exposure(format)(picture, kFrame, {}), picture), 0.1) << capture::to_string(format);
  }
  const auto deep = exposed({}, PixelFormat::bayer_rg12p);
  EXPECT_EQ(re_exposure(PixelFormat::bayer_rg12p)(deep, kFrame, {}).size(), deep.size());
}

TEST(ReExposure, TwelveBitsAreReExposedAsEightAre) {
  const ExposureSettings longer{.exposure_s = 0.010};
  const auto re_exposed = re_exposure(PixelFormat::bayer_rg12p)(exposed({}, PixelFormat::bayer_rg12p), kFrame, longer);
  const auto expected = exposed(longer, PixelFormat::bayer_rg12p);
  double difference = 0.0;
  for (std::size_t i = 0; i + 2 < expected.size(); i += 3)  // the first of each two pixels
    difference +=
        std::abs((re_exposed[i] | (re_exposed[i + 1] & 15) << 8) - (expected[i] | (expected[i + 1] & 15) << 8));
  EXPECT_LT(difference / static_cast<double>(expected.size() / 3), 12.0);  // of 4095
}

TEST(ReExposure, RefusesWhatIsNoWholeRows) {
  EXPECT_THROW(re_exposure()(std::vector<std::uint8_t>(kWidth + 1), kFrame, {}), InvalidInput);
}

// Through the wire: what Aravis writes is what the pictures show.
TEST(ReExposure, PicturesFollowWhatAClientWrites) {
  const auto refusal = tests::enter_private_network();
  if (!refusal.empty()) GTEST_SKIP() << refusal;
  const auto picture = exposed({});
  auto re_expose = re_exposure();
  GigeStudio studio({{.width = kWidth, .height = kHeight}},
                    [&](std::size_t, Timestamp) { return std::span<const std::uint8_t>{picture}; },
                    {.re_expose = [&](std::size_t, Timestamp, const ImageSettings& written,
                                      std::span<const std::uint8_t> as_rendered) {
                      return re_expose(as_rendered, kFrame, exposure_settings(written));
                    }});
  studio.start();
  AravisClient client("127.0.0.1", 1500);
  client.trigger_by("Software");
  client.start();
  // A frame that a busy machine lost on the way is asked for again: which pixels come is what matters here.
  const auto next = [&] {
    for (int attempt = 0; attempt < 10; ++attempt) {
      client.execute("TriggerSoftware");
      const auto frame = client.next_frame(5s);
      if (frame && frame->status == ARV_BUFFER_STATUS_SUCCESS) return frame->pixels;
    }
    ADD_FAILURE() << "no whole frame came";
    return std::vector<std::uint8_t>{};
  };
  EXPECT_EQ(next(), picture);  // not touched while nothing was written
  client.set_float("ExposureTime", 10000.0);
  EXPECT_LT(rms(next(), exposed({.exposure_s = 0.010})), 1.6);
  client.set_float("Gain", 6.0);
  EXPECT_LT(rms(next(), exposed({.exposure_s = 0.010, .gain_db = 6.0})), 2.5);
  client.set_float("ExposureTime", 5000.0);
  client.set_float("Gain", 0.0);
  client.set("BalanceRatioSelector", "Red");
  client.set_float("BalanceRatio", 0.5);
  EXPECT_LT(rms(next(), exposed({.balance = {0.5, 1.0, 1.0}})), 1.6);
  client.set_float("BalanceRatio", 1.0);
  EXPECT_EQ(next(), picture);
}

}  // namespace
}  // namespace rotunda::simulator
