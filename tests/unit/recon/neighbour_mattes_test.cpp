#include "recon/neighbour_mattes.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cmath>

#include "capture/picture.h"
#include "capture/take/take_writer.h"
#include "tests/unit/capture/take_fixture.h"

namespace rotunda::recon {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr std::uint64_t kFrames = 7, kLosing = 3;

// A disc of cloth before paint; in one frame a fold of it is nearly as blue as the paint.
std::vector<std::uint8_t> pixels(std::uint64_t frame) {
  std::vector<std::uint8_t> bytes;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool disc = std::hypot(x - 80, y - 60) < 40, fold = frame == kLosing && std::hypot(x - 80, y - 60) < 12;
      const cv::Vec3b colour = fold ? cv::Vec3b(46, 86, 168) : disc ? cv::Vec3b(190, 140, 120) : cv::Vec3b(40, 80, 180);
      bytes.insert(bytes.end(), {colour[0], colour[1], colour[2]});
    }
  return bytes;
}

void write_take(const std::filesystem::path& folder) {
  const auto cameras = capture::test::cameras_of(2, kWidth, kHeight, capture::PixelFormat::rgb8);
  capture::TakeWriter writer(capture::test::options_for(folder, cameras));
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    auto set = capture::test::frame_set(cameras, i);
    for (auto& slot : set.slots)
      slot.frame->image = capture::make_image(kWidth, kHeight, capture::PixelFormat::rgb8, pixels(i));
    writer.write(set);
  }
  writer.finish();
}

StudioViews studio_of_two() {
  StudioViews studio;
  studio.cameras.resize(2);
  studio.backgrounds.assign(2, cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar(40, 80, 180)));
  return studio;
}

double area_of(const capture::Matte& matte) {
  return cv::sum(matte.alpha)[0] / 255.0;
}

TEST(NeighbourMattes, HoldWhatOneFrameLoses) {
  const capture::test::TemporaryFolder folder;
  write_take(folder.path() / "take");
  const capture::TakeReader take(folder.path() / "take");
  const auto studio = studio_of_two();
  StageClock clock;
  NeighbourMattes neighbours(take, studio, clock, 2);
  const auto set = take.read(kLosing);
  const auto alone = key_frame(set, studio, {}, clock),
             held = key_frame(set, studio, {}, clock, neighbours.held(kLosing));
  const double disc = CV_PI * 40.0 * 40.0, fold = CV_PI * 12.0 * 12.0;
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(area_of(alone.mattes[i]), disc - fold, 0.1 * fold);
    EXPECT_NEAR(area_of(held.mattes[i]), disc, 0.1 * fold);
  }
}

TEST(NeighbourMattes, AreKeyedOnceForTheirNeighboursAndTheTakesEndsHaveNone) {
  const capture::test::TemporaryFolder folder;
  write_take(folder.path() / "take");
  const capture::TakeReader take(folder.path() / "take");
  auto studio = studio_of_two();
  StageClock clock;
  NeighbourMattes neighbours(take, studio, clock, 8);
  std::vector<std::vector<cv::Mat>> held(kFrames);
  tbb::parallel_for(std::size_t{0}, held.size(), [&](std::size_t frame) { held[frame] = neighbours.held(frame); });
  EXPECT_TRUE(held.front().empty());
  EXPECT_TRUE(held.back().empty());
  for (std::size_t frame = 1; frame + 1 < held.size(); ++frame) ASSERT_EQ(held[frame].size(), 2U);
  ASSERT_EQ(clock.costs().size(), 1U);
  EXPECT_EQ(clock.costs().front().count, kFrames);
  studio.live_keys.resize(2);
  EXPECT_TRUE(neighbours.held(kLosing).empty()) << "at live quality nobody waits for the frame after";
}

}  // namespace
}  // namespace rotunda::recon
