#include "recon/live_take.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "capture/calibration_file.h"
#include "capture/take/take.h"
#include "capture/take/take_writer.h"
#include "config/errors.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/ball_scene.h"
#include "tests/unit/capture/take_fixture.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 160, kHeight = 128;
constexpr std::size_t kFrames = 3, kNobody = 1;

// A ball before a blue wall; in frame `kNobody` it has left.
void write_take(const fs::path& folder) {
  const auto models = simulator::camera_layout({.cameras = 4, .width = kWidth, .height = kHeight});
  const auto cameras = capture::test::cameras_of(models.size(), kWidth, kHeight, capture::PixelFormat::rgb8);
  capture::TakeWriter writer(capture::test::options_for(folder, cameras));
  const std::vector<tests::Ball> ball{{{0.0, 0.0, 1.0}, 0.4}}, nobody;
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    auto set = capture::test::frame_set(cameras, frame);
    for (std::size_t i = 0; i < models.size(); ++i) {
      const cv::Mat rgb = tests::picture_of(models[i], frame == kNobody ? nobody : ball, {40, 60, 190},
                                            [](std::size_t, const Eigen::Vector3d&) { return cv::Vec3f(200, 120, 60); })
                              .rgb;
      set.slots[i].frame->image =
          capture::make_image(kWidth, kHeight, capture::PixelFormat::rgb8, {rgb.datastart, rgb.dataend});
    }
    writer.write(set);
  }
  writer.finish();
  capture::write_calibration(capture::calibration_file(folder), models);
}

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write_bytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

TEST(LiveTake, KeepsEveryFramesSurfaceAndKnowsWhichHasNone) {
  const capture::test::TemporaryFolder folder;
  const auto take = folder.path() / "take";
  write_take(take);
  EXPECT_FALSE(make_live_take(take, [] { return false; }).finished);
  EXPECT_FALSE(fs::exists(live_take_file(take))) << "interrupted: nothing half-made is left";
  const auto report = make_live_take(take, [] { return true; });
  EXPECT_TRUE(report.finished);
  EXPECT_EQ(report.frames, kFrames);
  EXPECT_EQ(report.with_surface, kFrames - 1);
  LiveTakeReader reader(live_take_file(take));
  ASSERT_EQ(reader.frame_count(), kFrames);
  EXPECT_GT(reader.fps(), 0.0);
  EXPECT_FALSE(reader.read(kNobody));
  EXPECT_TRUE(topology_of(reader.read(2)->mesh).is_sphere());
  EXPECT_THROW(reader.read(kFrames), InvalidInput);

  const auto whole = bytes_of(live_take_file(take));
  const auto file = folder.path() / "spoilt";
  for (const std::size_t size : {0UL, 3UL, 11UL, 13UL, whole.size() / 2, whole.size() - 1}) {
    write_bytes(file, whole.substr(0, size));
    EXPECT_THROW(LiveTakeReader{file}, CorruptData) << size;
  }
  for (const std::size_t offset : {0UL, 7UL, 11UL, 15UL}) {  // magic, frames, rate, the first frame's length
    auto spoilt = whole;
    spoilt[offset] = '\x7f';
    write_bytes(file, spoilt);
    EXPECT_THROW(LiveTakeReader{file}, CorruptData) << offset;
  }
  auto spoilt = whole;
  spoilt[whole.size() - 100] ^= 0x10;
  write_bytes(file, spoilt);
  EXPECT_THROW(LiveTakeReader{file}.read(2), CorruptData);
}

}  // namespace
}  // namespace rotunda::recon
