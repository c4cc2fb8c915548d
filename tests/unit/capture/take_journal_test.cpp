#include "capture/take/take_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class TakeJournalTest : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path file() const { return folder_ / "events.jsonl"; }
  std::string text() const {
    std::ifstream stream(file());
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void write_all() const {
    TakeJournalWriter writer(folder_);
    writer.missing(17, {{"cam03", HoleReason::late}, {"cam07", HoleReason::trigger_missed}});
    writer.mark({20, "slipped \"here\"\n\xff"});
    writer.incident({21, "the clock stepped by 2 s"});
    writer.missing(22, {{"cam03", HoleReason::disk_too_slow}});
  }

  const fs::path folder_ = fs::temp_directory_path() / ("rotunda-journal-" + std::to_string(getpid()));
};

TEST_F(TakeJournalTest, GivesBackWhatHappened) {
  write_all();
  const auto journal = read_take_journal(folder_);
  EXPECT_THAT(journal.problems, IsEmpty());
  ASSERT_EQ(journal.missing.size(), 2u);
  EXPECT_EQ(journal.missing.at(17).at("cam07"), HoleReason::trigger_missed);
  EXPECT_EQ(journal.missing.at(22).at("cam03"), HoleReason::disk_too_slow);
  EXPECT_THAT(journal.marks, ElementsAre(TakeRemark{20, "slipped \"here\"\n\xEF\xBF\xBD"})) << "UTF-8 for others' sake";
  EXPECT_THAT(journal.incidents, ElementsAre(TakeRemark{21, "the clock stepped by 2 s"}));
}

TEST_F(TakeJournalTest, CutAtAnyLengthItKeepsWhatIsWholeAndCallsItNoProblem) {
  write_all();
  const std::string whole = text();
  std::size_t events_before = 0;
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    fs::resize_file(file(), 0);
    std::ofstream(file(), std::ios::binary) << whole.substr(0, length);
    const auto journal = read_take_journal(folder_);
    EXPECT_THAT(journal.problems, IsEmpty()) << length;
    const auto events = journal.missing.size() + journal.marks.size() + journal.incidents.size();
    EXPECT_GE(events, events_before);
    events_before = events;
  }
  EXPECT_EQ(events_before, 4u);
}

TEST_F(TakeJournalTest, ADamagedLineIsToldAndTheOthersStand) {
  write_all();
  std::string damaged = text();
  damaged[3] = '\0';
  std::ofstream(file(), std::ios::binary) << damaged;
  const auto journal = read_take_journal(folder_);
  EXPECT_THAT(journal.problems, ElementsAre(HasSubstr("line 1")));
  EXPECT_EQ(journal.marks.size(), 1u);
}

TEST_F(TakeJournalTest, EveryFlippedByteIsReadWithoutACrash) {
  write_all();
  const std::string whole = text();
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const unsigned flip : {0x01u, 0x20u, 0x80u}) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ flip);
      std::ofstream(file(), std::ios::binary) << damaged;
      const auto journal = read_take_journal(folder_);
      EXPECT_LE(journal.missing.size() + journal.marks.size() + journal.incidents.size(), 5u);
    }
}

TEST_F(TakeJournalTest, ATakeWithoutOneHasNone) {
  EXPECT_THAT(read_take_journal(folder_).missing, testing::IsEmpty());
}

}  // namespace
}  // namespace rotunda::capture
