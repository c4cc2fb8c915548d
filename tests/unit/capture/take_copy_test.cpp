#include "capture/take/take_copy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "capture/take/take_edit.h"
#include "capture/take/take_writer.h"
#include "config/errors.h"
#include "tests/unit/capture/take_fixture.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using namespace test;
using testing::HasSubstr;
using testing::ThrowsMessage;

// Ten frame sets from trigger 100 on; camera 1 lacks trigger 104, 105 was marked.
fs::path record(const fs::path& folder) {
  auto options = options_for(folder, cameras_of(2));
  options.note = "the note";
  TakeWriter writer(options);
  for (std::uint64_t trigger = 100; trigger < 110; ++trigger) {
    auto set = frame_set(options.cameras, trigger);
    if (trigger == 104) set.slots[1] = {.frame = std::nullopt, .missing_because = HoleReason::packets_lost};
    writer.write(set);
    if (trigger == 105) writer.mark("slip");
  }
  writer.set_circled(true);
  writer.finish();
  return folder;
}

TEST(TakeCopy, HasTheFramesBitForBitWithTheirTriggersTimesHolesAndMarks) {
  const TemporaryFolder root;
  const TakeReader whole(record(root.path() / "whole"));
  const auto info = copy_take(whole, {.folder = root.path() / "part", .frame_sets = {3, 7}});
  EXPECT_EQ(info.name, "part");
  EXPECT_EQ(info.frame_sets, 4U);
  EXPECT_EQ(info.complete_sets, 3U);
  EXPECT_EQ(info.first_trigger, 103U);
  EXPECT_EQ(info.note, "the note");
  EXPECT_EQ(info.recorded, whole.info().recorded);
  EXPECT_TRUE(info.circled);
  const TakeReader part(root.path() / "part");
  for (std::size_t i = 0; i < 4; ++i) expect_same(part.read(i), whole.read(i + 3));
  EXPECT_EQ(part.read(1).slots[1].missing_because, HoleReason::packets_lost);
  ASSERT_EQ(part.journal().marks.size(), 1U);
  EXPECT_EQ(part.journal().marks[0], (TakeRemark{105, "slip"}));
  EXPECT_TRUE(verify_take(root.path() / "whole").problems.empty());
}

TEST(TakeCopy, RefusesWhatIsNotThereAndNeverWritesOverATake) {
  const TemporaryFolder root;
  const TakeReader whole(record(root.path() / "whole"));
  EXPECT_THROW(copy_take(whole, {.folder = root.path() / "part", .frame_sets = {10, 20}}), InvalidInput);
  EXPECT_THAT(
      [&] {
        copy_take(whole, {.folder = root.path() / "whole", .frame_sets = {0, 2}});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("exists already")));
  EXPECT_EQ(list_takes(root.path()).size(), 1U);
}

TEST(TakeCopy, StoppedItLeavesNothing) {
  const TemporaryFolder root;
  const TakeReader whole(record(root.path() / "whole"));
  std::stop_source stop;
  const auto stop_soon = [&](std::size_t done, std::size_t) {
    if (done == 2) stop.request_stop();
  };
  EXPECT_THROW(copy_take(whole, {.folder = root.path() / "part", .frame_sets = {0, 10}}, stop_soon, stop.get_token()),
               std::system_error);
  EXPECT_EQ(std::distance(fs::directory_iterator(root.path()), {}), 1);
}

TEST(TakeEdit, ChangesWhatIsSaidAndNothingElse) {
  const TemporaryFolder root;
  const auto folder = record(root.path() / "whole");
  edit_take(folder, {.note = "another note", .slate = {}, .circled = false});
  const auto info = read_take_info(folder);
  EXPECT_EQ(info.note, "another note");
  EXPECT_FALSE(info.circled);
  EXPECT_EQ(info.slate, "whole");
  EXPECT_EQ(info.frame_sets, 10U);
  EXPECT_TRUE(verify_take(folder).problems.empty());
}

TEST(TakeEdit, RenamesButNeverOverAnother) {
  const TemporaryFolder root;
  const auto folder = record(root.path() / "whole");
  record(root.path() / "other");
  EXPECT_THAT([&] { rename_take(folder, "other"); }, ThrowsMessage<InvalidInput>(HasSubstr("exists already")));
  EXPECT_THROW(rename_take(folder, "../away"), InvalidInput);
  const auto renamed = rename_take(folder, "walk 1");
  EXPECT_EQ(read_take_info(renamed).name, "walk 1");
  EXPECT_FALSE(fs::exists(folder));
}

TEST(TakeEdit, LeavesATakeAloneThatIsRecorded) {
  const TemporaryFolder root;
  const auto options = options_for(root.path() / "now", cameras_of(1));
  auto writer = std::make_unique<TakeWriter>(options);
  writer->write(frame_set(options.cameras, 0));
  EXPECT_THROW(edit_take(options.folder, {.note = "x"}), InvalidInput);
  EXPECT_THROW(rename_take(options.folder, "then"), InvalidInput);
  EXPECT_FALSE(is_interrupted(options.folder, read_take_info(options.folder)));
  writer.reset();  // dies without closing
  EXPECT_TRUE(is_interrupted(options.folder, read_take_info(options.folder)));
}

}  // namespace
}  // namespace rotunda::capture
