// Archived takes: the same frames, the same files again, and never a wrong one as good.
#include "capture/take/take_archive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <map>
#include <random>

#include "capture/take/archive_manifest.h"
#include "capture/take/camera_file_writer.h"
#include "capture/take/take_copy.h"
#include "capture/take/take_edit.h"
#include "capture/take/take_reader.h"
#include "capture/take/take_recovery.h"
#include "capture/take/take_restore.h"
#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using namespace test;

constexpr std::uint64_t kFirst = 100;
constexpr std::uint64_t kSets = 4;

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void replace(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[entry.path().lexically_relative(folder)] = content(entry.path());
  return files;
}

// A smooth picture with a sensor's noise, in the format's bytes: FFV1 has something to find.
Image smooth_image(const TakeCamera& camera, std::uint64_t seed) {
  Image noise = noise_image(camera, seed);
  if (camera.format == PixelFormat::mjpeg || layout_of(camera.format).packing != PixelPacking::bytes) return noise;
  std::vector<std::uint8_t> bytes(noise.bytes().begin(), noise.bytes().end());
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::uint8_t>(40 + i / 8 % 128 + i % 2 * 60 + bytes[i] % 4);
  return make_image(camera.width, camera.height, camera.format, std::move(bytes), camera.ycbcr);
}

// A take with a hole, a mark, a plate, a matte, something of the user's, and something derived.
fs::path record(const fs::path& folder, const std::vector<TakeCamera>& cameras) {
  auto options = options_for(folder, cameras);
  options.note = "the note";
  TakeWriter writer(options);
  for (std::uint64_t trigger = kFirst; trigger < kFirst + kSets; ++trigger) {
    auto set = frame_set(cameras, trigger);
    for (std::size_t i = 0; i < cameras.size(); ++i)
      set.slots[i].frame->image = smooth_image(cameras[i], trigger * 100 + i);
    if (trigger == kFirst + 2) set.slots[0] = {.frame = std::nullopt, .missing_because = HoleReason::packets_lost};
    writer.write(set);
  }
  writer.mark("slip");
  writer.finish();
  for (const char* file : {"background/cam00.png", "mattes/cam00/frame000000.png", "notes of the day.txt"}) {
    fs::create_directories((folder / file).parent_path());
    replace(folder / file, file);
  }
  fs::create_directories(folder / "recon");
  replace(folder / "recon" / "geometry.mkv", "derived");
  return folder;
}

std::vector<TakeCamera> cameras_of_all_formats() {
  std::vector<TakeCamera> cameras;
  for (const auto format : pixel_formats()) {
    TakeCamera camera = cameras_of(1, 12, 10, format)[0];
    camera.name = std::string(to_string(format));
    if (is_ycbcr(format)) camera.ycbcr = YcbcrCoding::bt709_full;
    cameras.push_back(camera);
  }
  for (const auto format : {PixelFormat::bayer_gr8, PixelFormat::bayer_bg12, PixelFormat::bayer_rg12p}) {
    TakeCamera camera = cameras_of(1, 7, 5, format)[0];  // quadrants of four sizes; 12p without its last nibble
    camera.name = "odd " + std::string(to_string(format));
    if (format != PixelFormat::bayer_rg12p) cameras.push_back(camera);
  }
  return cameras;
}

TEST(TakeArchive, EveryFormatIsReadAsItWasAndRestoredToTheLastBit) {
  const TemporaryFolder root;
  const auto cameras = cameras_of_all_formats();
  const auto take = record(root.path() / "take", cameras);
  auto recorded = files_in(take);
  const auto archive = root.path() / "shelf" / "take";
  std::size_t last = 0, total = 0;
  const auto result = archive_take(take, archive, [&](std::size_t done, std::size_t of) { last = done, total = of; });
  EXPECT_EQ(last, total);
  EXPECT_EQ(result.frames, (cameras.size() - 2) * kSets - 1);  // RGB8 is FFV1 already, a JPEG is a JPEG; one hole
  EXPECT_EQ(result.damaged, 0U);
  EXPECT_EQ(files_in(take), recorded);  // only read

  const TakeReader before(take), after(archive);
  EXPECT_THAT(after.problems(), testing::IsEmpty());
  ASSERT_EQ(after.frame_set_count(), kSets);
  for (std::size_t i = 0; i < kSets; ++i) expect_same(after.read(i), before.read(i));
  EXPECT_EQ(after.read(2).slots[0].missing_because, HoleReason::packets_lost);
  EXPECT_EQ(after.journal().marks, before.journal().marks);
  EXPECT_EQ(verify_take(archive).complete, kSets - 1);
  EXPECT_THAT(verify_take(archive).problems, testing::IsEmpty());

  restore_take(archive, root.path() / "again");
  recorded.erase("recon/geometry.mkv");
  EXPECT_EQ(files_in(root.path() / "again"), recorded);
}

TEST(TakeArchive, IsSmallerAndTheSameBytesEveryTime) {
  const TemporaryFolder root;
  const auto take = record(root.path() / "take", cameras_of(2, 128, 96));
  const auto result = archive_take(take, root.path() / "a");
  EXPECT_LT(result.bytes_after, result.bytes_before / 2);  // two bits of noise a sample
  archive_take(take, root.path() / "b");
  EXPECT_EQ(files_in(root.path() / "a"), files_in(root.path() / "b"));
}

TEST(TakeArchive, KeepsADamagedFrameAsDamagedAndWhatNoFrameIsToldOf) {
  const TemporaryFolder root;
  const auto cameras = cameras_of(1);
  const auto take = record(root.path() / "take", cameras);
  const auto file = camera_file(take, "cam00");
  std::string bytes = content(file);
  const auto frames = CameraFileReader(file, cameras[0]).frames();
  bytes[static_cast<std::size_t>(frames[0].offset) + 100] ^= 1;                  // a pixel
  bytes[static_cast<std::size_t>(frames[1].offset) + frames[1].size + 20] ^= 1;  // its record, or about it
  bytes.resize(bytes.size() - 700);                                              // and no end
  replace(file, bytes);
  const auto result = archive_take(take, root.path() / "archive");
  EXPECT_EQ(result.damaged, 1U);
  EXPECT_EQ(TakeReader(root.path() / "archive").read(0, 0).missing_because, HoleReason::corrupt);
  restore_take(root.path() / "archive", root.path() / "again");
  EXPECT_EQ(content(camera_file(root.path() / "again", "cam00")), bytes);
}

class ArchivedTake : public testing::Test {
 protected:
  ArchivedTake() : cameras(cameras_of(2, 12, 10)), take(record(root.path() / "take", cameras)) {
    archive = root.path() / "archive";
    archive_take(take, archive);
    whole = files_in(take);
    whole.erase("recon/geometry.mkv");
  }

  // Restores, and is true if it was refused; what is restored is what was recorded.
  bool refused() const {
    const auto again = root.path() / "again";
    try {
      restore_take(archive, again);
    } catch (const CorruptData&) {
      EXPECT_FALSE(fs::exists(again));
      return true;
    } catch (const ConfigError&) {
      EXPECT_FALSE(fs::exists(again));
      return true;
    }
    auto files = files_in(again);
    auto expected = whole;
    files.erase("take.yaml");
    expected.erase("take.yaml");
    EXPECT_EQ(files, expected);
    fs::remove_all(again);
    return false;
  }

  TemporaryFolder root;
  std::vector<TakeCamera> cameras;
  fs::path take, archive;
  std::map<std::string, std::string> whole;
};

TEST_F(ArchivedTake, ABitFlippedAnywhereIsRefusedOrHarmless) {
  std::size_t refusals = 0, tries = 0;
  for (const auto& [file, bytes] : files_in(archive)) {
    const std::size_t stride = std::max<std::size_t>(bytes.size() / 12, 1) | 1U;
    for (std::size_t at = 0; at < bytes.size(); at += stride, ++tries) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
      replace(archive / file, damaged);
      if (refused()) ++refusals;
      EXPECT_TRUE(file == "take.yaml" || !archive_problems(archive).empty()) << file << " byte " << at;
    }
    replace(archive / file, bytes);
  }
  EXPECT_GT(refusals, tries / 2);  // Matroska's own headers have bits nobody needs: seek heads, cues, void
  EXPECT_FALSE(refused());
}

TEST_F(ArchivedTake, CutShortOrWithoutAFileIsRefused) {
  for (const auto& [file, bytes] : files_in(archive)) {
    if (file == "take.yaml") continue;
    const std::size_t lengths[] = {0, bytes.size() / 3, bytes.size() - 1};
    for (const auto length : lengths) {
      replace(archive / file, bytes.substr(0, length));
      // A Matroska file without the last byte of its index has all its frames.
      const bool harmless = file == "archive/SHA256SUMS" || (fs::path(file).extension() == ".mkv" && length > 0);
      EXPECT_TRUE(refused() || harmless) << file << " cut at " << length;
      EXPECT_FALSE(archive_problems(archive).empty()) << file << " cut at " << length;
    }
    fs::remove(archive / file);
    EXPECT_THROW(restore_take(archive, root.path() / "again"), std::runtime_error) << file;
    EXPECT_FALSE(fs::exists(root.path() / "again"));
    replace(archive / file, bytes);
  }
}

TEST_F(ArchivedTake, VerifyTellsWhatHasChangedBesideTheFrames) {
  replace(archive / "background/cam00.png", "another");
  replace(archive / "archive/cam01.rest", content(archive / "archive/cam01.rest") + "x");
  const auto report = verify_take(archive);
  EXPECT_FALSE(report.whole());
  EXPECT_THAT(report.problems,
              testing::UnorderedElementsAre(HasSubstr("background/cam00.png"), HasSubstr("cam01.rest")));
}

TEST_F(ArchivedTake, RefusalNamesEveryFileAndTheWayToTheWholeFrames) {
  std::string bytes = content(archive / "cam01.mkv");
  const auto stored = CameraFileReader(archive / "cam01.mkv", cameras[1]).frames().at(1);
  for (std::size_t at = 8; at < 24; ++at) bytes[static_cast<std::size_t>(stored.offset) + at] ^= 0x55;
  replace(archive / "cam01.mkv", bytes);
  replace(archive / "notes of the day.txt", "");
  EXPECT_THAT([&] { restore_take(archive, root.path() / "again"); },
              ThrowsMessage<CorruptData>(
                  testing::AllOf(HasSubstr("cam01.mkv"), HasSubstr("notes of the day.txt"), HasSubstr("take trim"))));
  const auto saved = copy_take(TakeReader(archive), {.folder = root.path() / "saved", .frame_sets = {0, kSets}});
  EXPECT_EQ(saved.cameras[1].frames, kSets - 1);
  EXPECT_FALSE(is_archive(root.path() / "saved"));
}

TEST_F(ArchivedTake, ItsNoteMayChangeAndGoesBackWithIt) {
  edit_take(archive, {.note = "better than we thought", .slate = {}, .circled = true});
  EXPECT_TRUE(verify_take(archive).problems.empty());
  EXPECT_EQ(restore_take(archive, root.path() / "again").note, "better than we thought");
}

TEST_F(ArchivedTake, RecoveryMakesItsLostTakeYamlAnew) {
  const auto before = read_take_info(archive);
  fs::remove(archive / "take.yaml");
  recover_take(archive);
  const auto anew = read_take_info(archive);
  ASSERT_EQ(anew.cameras.size(), 2U);
  EXPECT_EQ(anew.cameras[1].width, before.cameras[1].width);
  EXPECT_EQ(anew.cameras[1].format, before.cameras[1].format);
  EXPECT_EQ(anew.frame_sets, before.frame_sets);
}

TEST_F(ArchivedTake, IsNotMadeOfWhatIsNoClosedTakeOrOverAnother) {
  EXPECT_THAT([&] { archive_take(archive, root.path() / "b"); }, ThrowsMessage<InvalidInput>(HasSubstr("already")));
  EXPECT_THAT([&] { archive_take(take, archive); }, ThrowsMessage<InvalidInput>(HasSubstr("exists already")));
  EXPECT_THAT([&] { restore_take(archive, take); }, ThrowsMessage<InvalidInput>(HasSubstr("exists already")));
  EXPECT_THAT([&] { restore_take(take, root.path() / "b"); },
              ThrowsMessage<InvalidInput>(HasSubstr("no archived take")));
  auto info = read_take_info(take);
  info.state = TakeState::recording;
  write_take_info(take, info);
  EXPECT_THAT([&] { archive_take(take, root.path() / "b"); }, ThrowsMessage<InvalidInput>(HasSubstr("recover")));
}

TEST_F(ArchivedTake, AManifestThatLeavesTheTakeIsRefused) {
  const std::string sum(64, 'a');
  for (const std::string path : {"../outside", "/etc/passwd", "a/../../b", "./x", ""}) {
    replace(archive / "archive/recorded.sha256", sum + "  " + path + "\n");
    EXPECT_THROW(restore_take(archive, root.path() / "again"), CorruptData) << path;
  }
}

TEST_F(ArchivedTake, StoppedItLeavesNothing) {
  for (const std::size_t at : {1U, 7U, 10U}) {  // compressing, then reading back
    std::stop_source stop;
    const auto stop_soon = [&](std::size_t done, std::size_t) {
      if (done == at) stop.request_stop();
    };
    EXPECT_THROW(archive_take(take, root.path() / "shelf" / "b", stop_soon, stop.get_token()), std::system_error);
    EXPECT_TRUE(fs::is_empty(root.path() / "shelf"));
  }
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(restore_take(archive, root.path() / "shelf" / "b", {}, stop.get_token()), std::system_error);
  EXPECT_TRUE(fs::is_empty(root.path() / "shelf"));
}

// A limit on the size of files stands for a disk without room: write(2) fails at some byte.
TEST_F(ArchivedTake, WithoutRoomItIsRefusedAndLeavesNothing) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  for (const rlim_t room : {10U, 300U, 1000U}) {
    const rlimit little{room, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &little);
    EXPECT_THROW(archive_take(take, root.path() / "shelf" / "b"), std::system_error) << room;
    EXPECT_THROW(restore_take(archive, root.path() / "shelf" / "b"), std::system_error) << room;
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_TRUE(fs::is_empty(root.path() / "shelf")) << room;
  }
}

}  // namespace
}  // namespace rotunda::capture
