#include "recon/take_plates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "capture/picture.h"
#include "capture/take/take_writer.h"
#include "config/errors.h"
#include "tests/unit/capture/take_fixture.h"

namespace rotunda::recon {
namespace {

using capture::PixelFormat;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWidth = 96, kHeight = 64;
constexpr std::uint64_t kFrames = 8;

// A disc of cloth that walks through before paint; grey cameras see its brightness.
std::vector<std::uint8_t> pixels(PixelFormat format, const cv::Vec3b& paint, std::uint64_t frame) {
  const double centre = 12.0 + 10.0 * static_cast<double>(frame);
  std::vector<std::uint8_t> bytes;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const cv::Vec3b colour = std::hypot(x - centre, y - 30) < 9 ? cv::Vec3b(190, 140, 120) : paint;
      if (format == PixelFormat::mono8) bytes.push_back(colour[1]);
      if (format == PixelFormat::rgb8) bytes.insert(bytes.end(), {colour[0], colour[1], colour[2]});
    }
  return bytes;
}

void write_take(const std::filesystem::path& folder, PixelFormat format, const cv::Vec3b& paint) {
  const auto cameras = capture::test::cameras_of(2, kWidth, kHeight, format);
  capture::TakeWriter writer(capture::test::options_for(folder, cameras));
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    auto set = capture::test::frame_set(cameras, i);
    for (auto& slot : set.slots)
      slot.frame->image = capture::make_image(kWidth, kHeight, format, pixels(format, paint, i));
    writer.write(set);
  }
  writer.finish();
}

StudioViews without_plates() {
  StudioViews studio;
  studio.cameras.resize(2);
  studio.backgrounds.resize(2);
  return studio;
}

std::string message_of(const capture::TakeReader& take) {
  auto studio = without_plates();
  try {
    learn_missing_plates(take, studio);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(TakePlates, AreLearntKeptAndMakeLiveKeys) {
  const capture::test::TemporaryFolder folder;
  write_take(folder.path() / "take", PixelFormat::rgb8, {40, 80, 180});
  const capture::TakeReader take(folder.path() / "take");
  auto studio = without_plates();
  learn_missing_plates(take, studio);
  for (const char* name : {"cam00", "cam01"}) {
    const auto kept = capture::read_rgb(learnt_plate_file(take.folder(), name));
    EXPECT_LE(cv::norm(kept, cv::Mat(kept.size(), CV_8UC3, cv::Scalar(40, 80, 180)), cv::NORM_INF), 2.0);
  }
  make_live_keys(take, studio);
  const auto frame = take.read(3, 1);
  const auto matte = (*studio.live_keys[1])(frame.frame->image);
  EXPECT_NEAR(cv::sum(matte.alpha)[0] / 255.0, CV_PI * 81.0, 25.0);
}

TEST(TakePlates, NothingTellsThePerformerInGreyPicturesOrWithoutAScreenAndSoItSays) {
  const capture::test::TemporaryFolder folder;
  write_take(folder.path() / "grey", PixelFormat::mono8, {40, 80, 180});
  EXPECT_THAT(message_of(capture::TakeReader(folder.path() / "grey")),
              AllOf(HasSubstr("cam00, cam01"), HasSubstr("grey"), HasSubstr("rotunda plate"), HasSubstr("--mattes")));
  write_take(folder.path() / "wood", PixelFormat::rgb8, {150, 110, 70});
  EXPECT_THAT(message_of(capture::TakeReader(folder.path() / "wood")),
              AllOf(HasSubstr("no camera"), HasSubstr("blue screen"), HasSubstr("--background")));
}

}  // namespace rotunda::recon
