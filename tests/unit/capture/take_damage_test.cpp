// Takes that something happened to: cut short, bytes flipped, files gone. Never a crash, never a wrong pixel.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <random>
#include <set>

#include "capture/take/frame_record.h"
#include "capture/take/take_reader.h"
#include "capture/take/take_recovery.h"
#include "capture/take/take_verify.h"
#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace test;

constexpr std::size_t kSets = 4;

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void replace(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

class TakeDamage : public testing::TestWithParam<PixelFormat> {
 protected:
  TakeDamage() : folder(root.path() / "take"), cameras(cameras_of(2, 12, 10, GetParam())) {
    TakeWriter writer(options_for(folder, cameras));
    for (std::uint64_t trigger = 0; trigger < kSets; ++trigger) writer.write(frame_set(cameras, trigger));
    writer.finish();
    file = camera_file(folder, "cam01");
    whole = content(file);
  }

  // Not every place of the file but every kind: the sanitizers make FFV1 slow.
  static std::size_t stride() { return GetParam() == PixelFormat::rgb8 ? 61 : 7; }

  // How many of cam01's frames are there; every frame the reader gives must be the one recorded.
  std::size_t frames_read() const {
    const TakeReader take(folder);
    std::size_t frames = 0;
    for (std::size_t index = 0; index < take.frame_set_count(); ++index) {
      const FrameSlot slot = take.read(index, 1);
      const FrameSet written = frame_set(cameras, index);
      if (!slot.frame) {
        EXPECT_TRUE(slot.missing_because);
        continue;
      }
      ++frames;
      const auto read = slot.frame->image.bytes();
      const auto expected = written.slots[1].frame->image.bytes();
      EXPECT_TRUE(std::equal(read.begin(), read.end(), expected.begin(), expected.end()));
      EXPECT_EQ(slot.frame->exposure_start, written.slots[1].frame->exposure_start);
    }
    return frames;
  }

  TemporaryFolder root;
  fs::path folder;
  std::vector<TakeCamera> cameras;
  fs::path file;
  std::string whole;
};

TEST_P(TakeDamage, CutAtEveryLengthKeepsTheWholeFramesBeforeTheCut) {
  std::size_t last = 0;
  for (std::size_t length = 0; length < whole.size(); length += stride()) {
    replace(file, whole.substr(0, length));
    const std::size_t frames = frames_read();
    EXPECT_GE(frames, last) << "cut at " << length;
    last = frames;
  }
  EXPECT_EQ(last, kSets);
}

TEST_P(TakeDamage, AnyFlippedByteCostsNoOtherFrameAWrongPixel) {
  std::set<std::size_t> seen;
  for (std::size_t at = 0; at < whole.size(); at += stride()) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
    replace(file, damaged);
    seen.insert(frames_read());
  }
  EXPECT_TRUE(seen.contains(kSets));      // a byte that matters to no frame
  EXPECT_TRUE(seen.contains(kSets - 1));  // one frame's pixels
}

INSTANTIATE_TEST_SUITE_P(Formats, TakeDamage, testing::Values(PixelFormat::mono8, PixelFormat::rgb8),
                         [](const auto& format) { return std::string(to_string(format.param)); });

class DamagedTake : public testing::Test {
 protected:
  DamagedTake() : folder(root.path() / "take"), cameras(cameras_of(3)) {
    TakeWriter writer(options_for(folder, cameras));
    for (std::uint64_t trigger = 0; trigger < 6; ++trigger) writer.write(frame_set(cameras, trigger));
    writer.finish();
  }

  // Flips a pixel of the camera's n-th frame.
  void damage_pixels(const CameraId& camera, std::size_t frame) {
    const auto path = camera_file(folder, camera);
    const auto stored = CameraFileReader(path, cameras[0]).frames().at(frame);
    std::string bytes = content(path);
    bytes[static_cast<std::size_t>(stored.offset) + stored.size / 2] ^= 1;
    replace(path, bytes);
  }

  TemporaryFolder root;
  fs::path folder;
  std::vector<TakeCamera> cameras;
};

TEST_F(DamagedTake, VerifyTellsTheCorruptFrameAndTheGap) {
  damage_pixels("cam01", 2);
  damage_pixels("cam01", 3);
  const TakeReport report = verify_take(folder);
  EXPECT_EQ(report.complete, 4U);
  EXPECT_EQ(report.incomplete, 2U);
  EXPECT_FALSE(report.whole());
  EXPECT_EQ(report.cameras[1].corrupt, 2U);
  EXPECT_EQ(report.cameras[1].missing, 2U);
  EXPECT_EQ(report.cameras[0].missing, 0U);
  ASSERT_THAT(report.gaps, SizeIs(1));
  EXPECT_EQ(report.gaps[0].camera, "cam01");
  EXPECT_EQ(report.gaps[0].first_trigger, 2U);
  EXPECT_EQ(report.gaps[0].frames, 2U);
  EXPECT_EQ(TakeReader(folder).read(2, 1).missing_because, HoleReason::corrupt);
}

TEST_F(DamagedTake, IsWholeWhenNothingHappened) {
  std::size_t last = 0;
  EXPECT_TRUE(verify_take(folder, [&](std::size_t done, std::size_t total) {
                EXPECT_EQ(total, 6U);
                last = done;
              }).whole());
  EXPECT_EQ(last, 6U);
}

TEST_F(DamagedTake, ReadsOnWithoutACamerasFile) {
  fs::remove(camera_file(folder, "cam02"));
  const TakeReader take(folder);
  ASSERT_THAT(take.problems(), SizeIs(1));
  EXPECT_THAT(take.problems()[0], HasSubstr("cam02"));
  EXPECT_EQ(take.info().complete_sets, 0U);
  EXPECT_TRUE(take.read(3).slots[1].frame);
  EXPECT_FALSE(take.read(3).slots[2].frame);
  EXPECT_FALSE(verify_take(folder).whole());
}

TEST_F(DamagedTake, RecoveryCountsWhatIsThereAndTouchesNoFrame) {
  TakeInfo info = read_take_info(folder);
  info.state = TakeState::recording;  // as a killed writer leaves it
  info.frame_sets = info.complete_sets = 0;
  write_take_info(folder, info);
  fs::resize_file(camera_file(folder, "cam02"), fs::file_size(camera_file(folder, "cam02")) / 2);
  damage_pixels("cam00", 1);
  const std::string before = content(camera_file(folder, "cam02"));
  const TakeReport report = recover_take(folder);
  const TakeInfo recovered = read_take_info(folder);
  EXPECT_EQ(recovered.state, TakeState::recovered);
  EXPECT_EQ(recovered.frame_sets, 6U);
  EXPECT_EQ(recovered.complete_sets, report.complete);
  EXPECT_EQ(recovered.cameras[0].frames, 5U);
  EXPECT_EQ(recovered.cameras[1].frames, 6U);
  EXPECT_LT(recovered.cameras[2].frames, 4U);
  EXPECT_GT(recovered.cameras[2].frames, 0U);
  EXPECT_EQ(recovered.start, trigger_time(0));
  EXPECT_EQ(content(camera_file(folder, "cam02")), before);
}

TEST_F(DamagedTake, RecoveryMakesALostTakeYamlAnew) {
  const TakeInfo before = read_take_info(folder);
  fs::remove(folder / "take.yaml");
  EXPECT_EQ(resolve_take("take", root.path()), folder);
  EXPECT_EQ(recover_take(folder).complete, 6U);
  const TakeInfo anew = read_take_info(folder);
  EXPECT_EQ(anew.state, TakeState::recovered);
  EXPECT_EQ(anew.fps, before.fps);
  EXPECT_EQ(anew.start, before.start);
  ASSERT_EQ(anew.cameras.size(), 3U);
  EXPECT_EQ(anew.cameras[1].name, "cam01");
  EXPECT_EQ(anew.cameras[1].format, PixelFormat::bayer_rg8);
  expect_same(TakeReader(folder).read(5), frame_set(cameras, 5));
}

TEST_F(DamagedTake, RecoveryKeepsATakeYamlItCannotRead) {
  replace(folder / "take.yaml", "state: [complete");
  EXPECT_EQ(recover_take(folder).complete, 6U);
  EXPECT_EQ(content(folder / "take.yaml.broken"), "state: [complete");
  fs::create_directories(root.path() / "empty");
  EXPECT_THROW(recover_take(root.path() / "empty"), InvalidInput);
  EXPECT_TRUE(fs::is_empty(root.path() / "empty"));
}

TEST_F(DamagedTake, RecoveryLeavesACompleteTakeAsItIs) {
  const std::string before = content(folder / "take.yaml");
  EXPECT_EQ(recover_take(folder).state, TakeState::complete);
  EXPECT_EQ(content(folder / "take.yaml"), before);
}

TEST_F(DamagedTake, RecoveryRefusesATakeBeingRecorded) {
  const auto other = root.path() / "live";
  TakeWriter writer(options_for(other, cameras));
  writer.write(frame_set(cameras, 0));
  EXPECT_THROW(recover_take(other), InvalidInput);
  EXPECT_EQ(TakeReader(other).frame_set_count(), 1U);  // reading beside the writer is fine
}

TEST_F(DamagedTake, TellsLineAndKeyOfAMistakeInTakeYaml) {
  struct {
    const char *from, *to, *told;
  } const rows[] = {
      {"fps: 25", "fps: fast", "fps: expected frame sets a second"},
      {"fps: 25", "fps: -1", "fps: expected a number above 0"},
      {"state: complete", "state: done", "state: expected recording, complete or recovered"},
      {"version: 1", "version: 9", "version: is 9"},
      {"name: cam01", "name: ../../etc/cam01", "cameras[1].name: cannot be a file name"},
      {"name: cam01", "name: cam00", "cameras[1].name: is there twice"},
      {"width: 64", "width: 6400000", "cameras[0].width: expected 1 to 65536"},
      {"format: BayerRG8", "format: BayerRG99", "cameras[0].format: 'BayerRG99'"},
      {"cameras:", "kameras:", "cameras: expected a list"},
      {"slate: take", "slate: [take", "recover"},
  };
  const std::string good = content(folder / "take.yaml");
  for (const auto& row : rows) {
    std::string bad = good;
    ASSERT_NE(bad.find(row.from), std::string::npos) << row.from;
    replace(folder / "take.yaml", bad.replace(bad.find(row.from), std::string(row.from).size(), row.to));
    try {
      TakeReader take(folder);
      FAIL() << row.to;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), HasSubstr(row.told));
      EXPECT_THAT(error.what(), HasSubstr("take.yaml"));
    }
  }
}

TEST_F(DamagedTake, AnyCutOfTakeYamlIsRefusedOrRead) {
  const std::string good = content(folder / "take.yaml");
  for (std::size_t length = 0; length < good.size(); ++length) {
    replace(folder / "take.yaml", good.substr(0, length));
    try {
      EXPECT_LE(read_take_info(folder).cameras.size(), 3U);
    } catch (const ConfigError&) {
    }
  }
}

TEST_F(DamagedTake, TakesAreListedByNameAndFoundByNameOrPath) {
  TakeInfo info = read_take_info(folder);
  fs::create_directories(root.path() / "another");
  write_take_info(root.path() / "another", info);
  fs::create_directories(root.path() / "broken");
  replace(root.path() / "broken" / "take.yaml", "nothing");
  fs::create_directories(root.path() / "no take");
  std::vector<std::string> problems;
  const auto takes = list_takes(root.path(), &problems);
  ASSERT_THAT(takes, SizeIs(2));
  EXPECT_EQ(takes[0].name, "another");
  EXPECT_EQ(takes[1].name, "take");
  ASSERT_THAT(problems, SizeIs(1));
  EXPECT_THAT(problems[0], HasSubstr("broken"));
  EXPECT_THAT(list_takes(root.path() / "nowhere"), IsEmpty());
  EXPECT_EQ(resolve_take("take", root.path()), folder);
  EXPECT_EQ(resolve_take(folder.string(), "/nowhere"), folder);
  try {
    resolve_take("tkae", root.path());
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("another, take"));
  }
  EXPECT_THROW(read_take_info(root.path() / "no take"), InvalidInput);
}

TEST(FrameRecord, SurvivesEncodingAndNoDamage) {
  const FrameRecord record{.trigger = 0x0102030405060708,
                           .trigger_time = trigger_time(7),
                           .exposure_start = trigger_time(8),
                           .exposure = std::chrono::nanoseconds(-5),
                           .pixels_crc = 0xDEADBEEF};
  const auto bytes = encode(record);
  EXPECT_EQ(bytes[8], 0x08);  // little-endian
  EXPECT_EQ(decode_frame_record(bytes), record);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    auto damaged = bytes;
    damaged[i] ^= 0x10;
    EXPECT_EQ(decode_frame_record(damaged), std::nullopt) << "byte " << i;
    EXPECT_EQ(decode_frame_record(std::span(bytes).first(i)), std::nullopt);
  }
}

}  // namespace
}  // namespace rotunda::capture
