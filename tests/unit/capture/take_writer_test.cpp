#include "capture/take/take_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <system_error>

#include "capture/take/take_reader.h"
#include "capture/take/take_verify.h"
#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using namespace test;

void record(const fs::path& folder, const std::vector<TakeCamera>& cameras, std::uint64_t first, std::uint64_t end) {
  TakeWriter writer(options_for(folder, cameras));
  for (std::uint64_t trigger = first; trigger < end; ++trigger) writer.write(frame_set(cameras, trigger));
  writer.finish();
}

TEST(TakeWriter, GivesBackEveryFormatBitForBitWithItsTimes) {
  const TemporaryFolder root;
  for (const auto format : pixel_formats()) {
    const auto folder = root.path() / std::string(to_string(format));
    const auto [across, down] = pixel_group(format);
    const auto cameras = cameras_of(2, across > 1 ? 64 : 65, down > 1 ? 46 : 47, format);
    record(folder, cameras, 0, 4);
    const TakeReader take(folder);
    EXPECT_THAT(take.problems(), testing::IsEmpty());
    ASSERT_EQ(take.frame_set_count(), 4U);
    for (const std::size_t index : {3, 0, 2, 1}) expect_same(take.read(index), frame_set(cameras, index));
  }
}

TEST(TakeWriter, KeepsHowColoursWereCodedAlsoWhenTheTakesOwnFileIsLost) {
  const TemporaryFolder root;
  for (const auto coding :
       {YcbcrCoding::bt601_limited, YcbcrCoding::bt601_full, YcbcrCoding::bt709_limited, YcbcrCoding::bt709_full}) {
    const auto folder = root.path() / std::string(to_string(coding));
    auto cameras = cameras_of(1, 64, 48, PixelFormat::nv12);
    cameras[0].ycbcr = coding;
    record(folder, cameras, 0, 2);
    EXPECT_EQ(TakeReader(folder).read(1).slots[0].frame->image.ycbcr, coding);
    fs::remove(folder / "take.yaml");
    EXPECT_EQ(read_camera_file_header(folder / "cam00.mkv").camera.ycbcr, coding);
  }
}

TEST(TakeWriter, KeepsWhatTheTakeIs) {
  const TemporaryFolder root;
  const auto rig = root.path() / "studio.yaml";
  std::ofstream(rig) << "name: studio\n";
  auto options = options_for(root.path() / "walk 1", cameras_of(3));
  options.note = "second try: \"quick\"\nwith a line more";
  options.rig = "studio";
  options.rig_file = rig;
  options.fps = 29.97;
  {
    TakeWriter writer(options);
    EXPECT_EQ(read_take_info(options.folder).state, TakeState::recording);
    for (std::uint64_t trigger = 5; trigger < 8; ++trigger) writer.write(frame_set(options.cameras, trigger));
    const TakeInfo closed = writer.finish();
    EXPECT_EQ(closed.frame_sets, 3U);
  }
  const TakeInfo info = read_take_info(options.folder);
  EXPECT_EQ(info.name, "walk 1");
  EXPECT_EQ(info.slate, "walk 1");
  EXPECT_EQ(info.note, options.note);
  EXPECT_EQ(info.rig, "studio");
  EXPECT_EQ(info.fps, 29.97);
  EXPECT_EQ(info.state, TakeState::complete);
  EXPECT_EQ(info.start, trigger_time(5));
  EXPECT_EQ(info.first_trigger, 5U);
  EXPECT_EQ(info.complete_sets, 3U);
  ASSERT_EQ(info.cameras.size(), 3U);
  EXPECT_EQ(info.cameras[2].name, "cam02");
  EXPECT_EQ(info.cameras[2].frames, 3U);
  EXPECT_TRUE(fs::exists(options.folder / "rig.yaml"));
}

TEST(TakeWriter, CountsHolesAndGivesThemBack) {
  const TemporaryFolder root;
  const auto folder = root.path() / "holes";
  const auto cameras = cameras_of(2);
  TakeWriter writer(options_for(folder, cameras));
  FrameSet first = frame_set(cameras, 10);
  first.slots[0] = {.frame = std::nullopt, .missing_because = HoleReason::late};
  FrameSet nothing = frame_set(cameras, 13);
  for (auto& slot : nothing.slots) slot = {.frame = std::nullopt, .missing_because = HoleReason::camera_lost};
  writer.write(first);
  writer.write(frame_set(cameras, 12));  // trigger 11 never came
  writer.write(nothing);
  const TakeInfo info = writer.finish();
  EXPECT_EQ(info.frame_sets, 4U);
  EXPECT_EQ(info.complete_sets, 1U);
  EXPECT_EQ(info.cameras[0].missing, 3U);
  EXPECT_EQ(info.cameras[1].missing, 2U);
  using Reasons = std::map<HoleReason, std::size_t>;
  EXPECT_EQ(info.cameras[0].missing_because, (Reasons{{HoleReason::late, 1}, {HoleReason::camera_lost, 1}}));
  EXPECT_EQ(read_take_info(folder).cameras[0].missing_because, info.cameras[0].missing_because);
  const TakeReader take(folder);
  ASSERT_EQ(take.frame_set_count(), 4U);
  expect_same(take.read(0), first);
  expect_same(take.read(2), frame_set(cameras, 12));
  expect_same(take.read(3), nothing);
  EXPECT_FALSE(take.read(1).slots[0].frame);
  EXPECT_EQ(take.read(1).slots[0].missing_because, HoleReason::not_recorded);
  EXPECT_EQ(take.read(1).time, trigger_time(11));
  EXPECT_THROW(take.read(4), InvalidInput);
}

TEST(TakeWriter, KilledItStillKnowsWhyFramesAreMissingAndWhatWasMarked) {
  const TemporaryFolder root;
  const auto folder = root.path() / "cut";
  const auto cameras = cameras_of(2);
  {
    TakeWriter writer(options_for(folder, cameras));
    FrameSet hole = frame_set(cameras, 11);
    hole.slots[1] = {.frame = std::nullopt, .missing_because = HoleReason::trigger_missed};
    for (const auto& set : {frame_set(cameras, 10), hole, frame_set(cameras, 12)}) writer.write(set);
    writer.mark("here");
  }  // without finish()
  const TakeReader take(folder);
  EXPECT_EQ(take.read(1).slots[1].missing_because, HoleReason::trigger_missed);
  EXPECT_EQ(take.info().cameras[1].missing_because.at(HoleReason::trigger_missed), 1U);
  ASSERT_EQ(take.journal().marks.size(), 1U);
  EXPECT_EQ(take.journal().marks[0], (TakeRemark{12, "here"}));
}

TEST(TakeWriter, KeepsTheSlateAndHowWellTheCamerasWereInStep) {
  const TemporaryFolder root;
  auto options = options_for(root.path() / "12B-01", cameras_of(2));
  options.scene = "12";
  options.shot = "B";
  options.take_number = next_take_number(root.path(), "12", "B");
  {
    TakeWriter writer(options);
    for (std::uint64_t trigger = 0; trigger < 10; ++trigger) {
      auto set = frame_set(options.cameras, trigger);
      set.slots[1].frame->exposure_start = set.slots[0].frame->exposure_start + std::chrono::microseconds(30);
      writer.write(set);
    }
    writer.set_circled(true);
    writer.finish();
  }
  const TakeInfo info = read_take_info(options.folder);
  EXPECT_EQ(info.slate, "12 B 1");
  EXPECT_TRUE(info.circled);
  EXPECT_EQ(info.sync.sets, 10U);
  EXPECT_NEAR(static_cast<double>(info.sync.spread_median.count()), 30e3, 1e3);
  ASSERT_EQ(info.sync.cameras.size(), 2U);
  EXPECT_EQ(info.sync.cameras[1].offset - info.sync.cameras[0].offset, std::chrono::microseconds(30));
  EXPECT_EQ(next_take_number(root.path(), "12", "B"), 2);
  EXPECT_EQ(next_take_number(root.path(), "12", "C"), 1);
}

TEST(TakeWriter, RefusesAFolderThatExistsAndLeavesItAlone) {
  const TemporaryFolder root;
  const auto folder = root.path() / "walk";
  const auto cameras = cameras_of(1);
  record(folder, cameras, 0, 2);
  const auto before = fs::last_write_time(folder / "cam00.mkv");
  try {
    TakeWriter again(options_for(folder, cameras));
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("exists already"));
  }
  EXPECT_EQ(fs::last_write_time(folder / "cam00.mkv"), before);
  EXPECT_EQ(TakeReader(folder).frame_set_count(), 2U);
}

TEST(TakeWriter, RefusesNamesThatLeaveTheFolder) {
  const TemporaryFolder root;
  auto bad_camera = cameras_of(1);
  for (const char* name : {"../cam", "/etc/cam", "a/b", "", ".", "..", "a\nb"}) {
    EXPECT_FALSE(valid_take_name(name)) << name;
    bad_camera[0].name = name;
    EXPECT_THROW(TakeWriter(options_for(root.path() / "walk", bad_camera)), InvalidInput) << name;
  }
  EXPECT_THROW(TakeWriter(options_for(root.path() / "..", cameras_of(1))), InvalidInput);
  EXPECT_THROW(TakeWriter(options_for(root.path() / "-rf", cameras_of(1))), InvalidInput);
  EXPECT_THROW(TakeWriter(options_for(root.path() / "walk", {})), InvalidInput);
  EXPECT_TRUE(fs::is_empty(root.path()));
  for (const char* name : {"walk", "walk 1", "Größe-2_b.3"}) EXPECT_TRUE(valid_take_name(name)) << name;
}

TEST(TakeWriter, RefusesFramesThatAreNotTheTakes) {
  const TemporaryFolder root;
  const auto cameras = cameras_of(2);
  TakeWriter writer(options_for(root.path() / "walk", cameras));
  writer.write(frame_set(cameras, 3));
  EXPECT_THROW(writer.write(frame_set(cameras_of(3), 4)), InvalidInput);
  EXPECT_THROW(writer.write(frame_set(cameras_of(2, 32, 32), 4)), InvalidInput);
  EXPECT_THROW(writer.write(frame_set(cameras, 3)), InvalidInput);
  writer.write(frame_set(cameras, 4));
  EXPECT_EQ(writer.finish().complete_sets, 2U);
}

TEST(TakeWriter, TellsHowMuchRoomIsMissingBeforeItBegins) {
  const TemporaryFolder root;
  auto options = options_for(root.path() / "takes" / "walk", cameras_of(1));
  options.reserve_bytes = std::uint64_t{1} << 62;
  try {
    TakeWriter writer(options);
    FAIL();
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code(), std::errc::no_space_on_device);
    EXPECT_THAT(error.what(), HasSubstr("4611686018427387904 are needed"));
    EXPECT_THAT(error.what(), HasSubstr(root.path().string()));
  }
  EXPECT_TRUE(fs::is_empty(root.path()));
}

TEST(TakeWriter, LeavesNothingIfAFileToCopyIsMissing) {
  const TemporaryFolder root;
  auto options = options_for(root.path() / "walk", cameras_of(1));
  options.calibration_file = root.path() / "nowhere.yaml";
  EXPECT_THROW(TakeWriter{options}, std::system_error);
  EXPECT_TRUE(fs::is_empty(root.path()));
}

TEST(TakeWriter, KilledLosesNoFrameItHadWritten) {
  const TemporaryFolder root;
  const auto folder = root.path() / "killed";
  const auto cameras = cameras_of(3, 200, 100);
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    TakeWriter writer(options_for(folder, cameras));
    for (std::uint64_t trigger = 0;; ++trigger) {
      writer.write(frame_set(cameras, trigger));
      if (::write(ends[1], &trigger, sizeof trigger) != sizeof trigger) ::_exit(1);
    }
  }
  std::uint64_t written = 0;
  while (written < 20) ASSERT_EQ(::read(ends[0], &written, sizeof written), static_cast<ssize_t>(sizeof written));
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  ::close(ends[1]);
  while (::read(ends[0], &written, sizeof written) > 0) {
  }
  ::close(ends[0]);

  const TakeReader take(folder);
  EXPECT_EQ(take.info().state, TakeState::recording);
  ASSERT_GE(take.frame_set_count(), written + 1);
  for (std::uint64_t trigger = 0; trigger <= written; ++trigger)
    expect_same(take.read(trigger), frame_set(cameras, trigger));
}

TEST(TakeWriter, DroppedWithoutFinishLeavesItsFramesReadable) {
  const TemporaryFolder root;
  const auto folder = root.path() / "dropped";
  const auto cameras = cameras_of(1);
  {
    TakeWriter writer(options_for(folder, cameras));
    writer.write(frame_set(cameras, 0));
  }
  const TakeReader take(folder);
  EXPECT_EQ(take.info().state, TakeState::recording);
  ASSERT_EQ(take.frame_set_count(), 1U);
  expect_same(take.read(0), frame_set(cameras, 0));
}

// Writes until the disk refuses; what had been written must be there, bit for bit, and the take must close.
void fill_disk_and_check(const fs::path& folder) {
  const auto cameras = cameras_of(2, 400, 300);
  TakeWriter writer(options_for(folder, cameras));
  std::uint64_t trigger = 0;
  try {
    for (; trigger < 1000; ++trigger) writer.write(frame_set(cameras, trigger));
    FAIL() << "the disk took everything";
  } catch (const std::system_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(folder.string()));
  }
  EXPECT_GT(trigger, 2U);
  const TakeInfo info = writer.finish();
  EXPECT_EQ(info.complete_sets, trigger);
  const TakeReport report = verify_take(folder);
  EXPECT_EQ(report.state, TakeState::complete);
  EXPECT_EQ(report.complete, trigger);
  for (const auto& camera : report.cameras) EXPECT_EQ(camera.corrupt, 0U);
  expect_same(TakeReader(folder).read(trigger - 1), frame_set(cameras, trigger - 1));
}

TEST(TakeWriter, ClosesAValidTakeWhenTheDiskIsFull) {
  const TemporaryFolder root;
  if (::mount("none", root.path().c_str(), "tmpfs", 0, "size=6m") != 0)
    GTEST_SKIP() << "needs the right to mount a tmpfs";
  fill_disk_and_check(root.path() / "full");
  ::umount2(root.path().c_str(), MNT_DETACH);
}

TEST(TakeWriter, ClosesAValidTakeWhenAFileMayNotGrow) {
  const TemporaryFolder root;
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{.rlim_cur = 1'000'000, .rlim_max = 1'000'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    fill_disk_and_check(root.path() / "limited");
    std::fflush(nullptr);
    ::_exit(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "see the failures above";
}

std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
  std::string text;
  char buffer[4096];
  while (const std::size_t got = std::fread(buffer, 1, sizeof buffer, pipe.get())) text.append(buffer, got);
  return text;
}

TEST(TakeWriter, WritesFilesThatFfprobeOpens) {
  const TemporaryFolder root;
  if (std::system("command -v ffprobe >/dev/null") != 0) GTEST_SKIP() << "needs ffprobe (package ffmpeg)";
  const auto folder = root.path() / "probe";
  const auto cameras = cameras_of(1, 720, 576);
  record(folder, cameras, 0, 5);
  const std::string text = output_of("ffprobe -v error -count_frames -show_streams -show_format " +
                                     (folder / "cam00.mkv").string() + " 2>&1");
  for (const char* line : {"codec_name=rawvideo", "codec_tag_string=Y800", "width=720", "height=576", "pix_fmt=gray",
                           "r_frame_rate=25/1", "nb_read_frames=5", "TAG:PIXEL_FORMAT=BayerRG8"})
    EXPECT_THAT(text, HasSubstr(line));
}

}  // namespace
}  // namespace rotunda::capture
