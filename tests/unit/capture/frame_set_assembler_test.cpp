#include "capture/sync/frame_set_assembler.h"

#include <gtest/gtest.h>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds period = 40ms;
const TriggerGrid grid{Timestamp(1000s), period};

AssemblerOptions options_for(std::vector<CameraId> cameras, std::optional<std::uint64_t> triggers) {
  return {std::move(cameras), grid, triggers, 100ms, std::nullopt};
}

Frame frame_of(const CameraId& camera, std::uint64_t trigger, nanoseconds off = 0ns) {
  Frame frame;
  frame.camera = camera;
  frame.exposure_start = grid.time_of(trigger) + off;
  return frame;
}

TEST(FrameSetAssembler, EmitsASetAsSoonAsItsLastFrameIsIn) {
  FrameSetAssembler assembler(options_for({"a", "b"}, 3));
  EXPECT_TRUE(assembler.add(frame_of("a", 0), grid.time_of(0)).empty());
  const auto sets = assembler.add(frame_of("b", 0, 3us), grid.time_of(0) + 5ms);
  ASSERT_EQ(sets.size(), 1u);
  EXPECT_TRUE(sets[0].complete());
  EXPECT_EQ(sets[0].time, grid.time_of(0));
  EXPECT_EQ(sets[0].slots[1].frame->camera, "b");
}

TEST(FrameSetAssembler, GroupsByTimeWhateverTheOrderOfArrivalAndNumbersTheFrames) {
  FrameSetAssembler assembler(options_for({"a", "b"}, 2));
  const Timestamp now = grid.time_of(1) + 1ms;
  assembler.add(frame_of("a", 1), now);
  assembler.add(frame_of("b", 0), now);
  EXPECT_TRUE(assembler.add(frame_of("b", 1), now).empty()) << "set 1 is complete but set 0 leaves first";
  const auto sets = assembler.add(frame_of("a", 0), now);
  ASSERT_EQ(sets.size(), 2u);
  for (std::uint64_t k : {0, 1}) {
    EXPECT_EQ(sets[k].trigger, k);
    for (const auto& slot : sets[k].slots) EXPECT_EQ(slot.frame->trigger, k);
  }
  EXPECT_TRUE(assembler.done());
}

TEST(FrameSetAssembler, ClosesAtTheDeadlineWithTheReasonForEveryHole) {
  FrameSetAssembler assembler(options_for({"a", "b", "c", "d"}, 1));
  const Timestamp now = grid.time_of(0) + 1ms;
  assembler.add(frame_of("a", 0), now);
  assembler.add_loss("b", grid.time_of(0), now);
  assembler.set_absent("c", true, now);
  EXPECT_TRUE(assembler.advance(grid.time_of(0) + 100ms - 1ns).empty());
  EXPECT_EQ(assembler.next_deadline(), grid.time_of(0) + 100ms);
  const auto sets = assembler.advance(grid.time_of(0) + 100ms);
  ASSERT_EQ(sets.size(), 1u);
  EXPECT_TRUE(sets[0].slots[0].frame);
  EXPECT_EQ(sets[0].slots[1].missing_because, HoleReason::packets_lost);
  EXPECT_EQ(sets[0].slots[2].missing_because, HoleReason::camera_lost);
  EXPECT_EQ(sets[0].slots[3].missing_because, HoleReason::late);
  EXPECT_EQ(assembler.counts().incomplete, 1u);
}

Frame counted(std::uint64_t trigger, std::uint64_t id) {
  Frame frame = frame_of("a", trigger);
  frame.id = id;
  return frame;
}

// What the sets of triggers 0 .. `triggers` - 1 say of the one camera when these frames came, and nothing else.
std::vector<std::optional<HoleReason>> reasons(const std::vector<Frame>& frames, std::uint64_t triggers,
                                               const std::vector<std::uint64_t>& announced = {}) {
  FrameSetAssembler assembler(options_for({"a"}, triggers));
  std::vector<std::optional<HoleReason>> told;
  const auto keep = [&](const std::vector<FrameSet>& sets) {
    for (const auto& set : sets) told.push_back(set.slots[0].missing_because);
  };
  for (const auto trigger : announced) keep(assembler.add_loss("a", grid.time_of(trigger), grid.time_of(trigger)));
  for (const auto& frame : frames) keep(assembler.add(frame, frame.exposure_start));
  keep(assembler.finish());
  return told;
}

TEST(FrameSetAssembler, ACameraThatCountsItsExposuresTellsAMissedTriggerFromALostFrame) {
  using Reasons = std::vector<std::optional<HoleReason>>;
  const auto lost = HoleReason::packets_lost, missed = HoleReason::trigger_missed, late = HoleReason::late;
  EXPECT_EQ(reasons({counted(0, 7), counted(2, 9)}, 3), (Reasons{{}, lost, {}}));
  EXPECT_EQ(reasons({counted(0, 7), counted(2, 8)}, 3), (Reasons{{}, missed, {}}));
  EXPECT_EQ(reasons({counted(0, 7), counted(3, 9)}, 4), (Reasons{{}, late, late, {}})) << "which of the two was it?";
  EXPECT_EQ(reasons({counted(0, 7), counted(3, 9)}, 4, {1}), (Reasons{{}, lost, missed, {}}));
  EXPECT_EQ(reasons({counted(0, 7), counted(3, 9)}, 4, {2}), (Reasons{{}, missed, lost, {}}));
  EXPECT_EQ(reasons({counted(0, 7), counted(2, 3)}, 3), (Reasons{{}, late, {}})) << "it counts from its start again";
  EXPECT_EQ(reasons({frame_of("a", 0), frame_of("a", 2)}, 3), (Reasons{{}, late, {}})) << "it does not count";
  EXPECT_EQ(reasons({counted(1, 8)}, 3), (Reasons{late, {}, late})) << "nothing to compare with";
}

TEST(FrameSetAssembler, ADoubledTriggerDoesNotHideAMissedOne) {
  const auto told = reasons({counted(0, 7), counted(0, 8), counted(2, 9)}, 3);
  EXPECT_EQ(told[1], HoleReason::trigger_missed);
}

TEST(FrameSetAssembler, DoesNotWaitForCamerasThatAreAbsentOrLostTheirFrame) {
  FrameSetAssembler assembler(options_for({"a", "b", "c"}, 1));
  const Timestamp now = grid.time_of(0) + 1ms;
  assembler.set_absent("c", true, now);
  assembler.add_loss("b", grid.time_of(0), now);
  EXPECT_EQ(assembler.add(frame_of("a", 0), now).size(), 1u);
}

TEST(FrameSetAssembler, CountsLateDuplicateAndStrayFrames) {
  FrameSetAssembler assembler(options_for({"a", "b"}, 2));
  const Timestamp now = grid.time_of(1) + 1ms;
  assembler.add(frame_of("a", 1), now);
  assembler.add(frame_of("a", 1, 1us), now);
  assembler.advance(grid.time_of(0) + 100ms);  // set 0 leaves empty
  assembler.add(frame_of("b", 0), grid.time_of(0) + 101ms);
  assembler.add(frame_of("b", 2), grid.time_of(2));  // after the take
  assembler.add(frame_of("b", 0, -25ms), now);       // before it
  const auto& counts = assembler.counts();
  EXPECT_EQ(counts.cameras[0].duplicate, 1u);
  EXPECT_EQ(counts.cameras[1].late, 1u);
  EXPECT_EQ(counts.cameras[1].off_grid, 2u);
  EXPECT_EQ(counts.cameras[1].missing_in_a_row, 1u);
}

TEST(FrameSetAssembler, LeavesFramesBetweenTriggersAloneWhenATighterToleranceIsSet) {
  auto options = options_for({"a"}, 2);
  options.tolerance = 2ms;
  FrameSetAssembler assembler(options);
  EXPECT_TRUE(assembler.add(frame_of("a", 0, 3ms), grid.time_of(0) + 5ms).empty());
  EXPECT_EQ(assembler.add(frame_of("a", 0, -2ms), grid.time_of(0) + 5ms).size(), 1u);
  EXPECT_EQ(assembler.counts().cameras[0].off_grid, 1u);
}

TEST(FrameSetAssembler, HolesOfASilentCameraAreOfALostOneUnlessItsNextFrameTellsBetter) {
  FrameSetAssembler assembler(options_for({"a", "b"}, 5));
  const auto framed = [](std::uint64_t trigger, std::uint64_t id) {
    auto frame = frame_of("b", trigger);
    frame.id = id;
    return frame;
  };
  assembler.add(frame_of("a", 0), grid.time_of(0));
  EXPECT_EQ(assembler.add(framed(0, 10), grid.time_of(0)).size(), 1u);
  assembler.set_silent("b", true);
  assembler.add(frame_of("a", 1), grid.time_of(1));
  const auto lost = assembler.advance(grid.time_of(1) + 100ms);
  ASSERT_EQ(lost.size(), 1u) << "it is waited for until the deadline";
  EXPECT_EQ(lost[0].slots[1].missing_because, HoleReason::camera_lost);
  assembler.set_silent("b", false);
  assembler.add(framed(4, 11), grid.time_of(4));
  const auto rest = assembler.advance(grid.time_of(2) + 100ms);
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest[0].slots[1].missing_because, HoleReason::trigger_missed) << "it counted no exposure meanwhile";
}

TEST(FrameSetAssembler, ACameraWhoseClockRunsAheadPilesNothingUp) {
  FrameSetAssembler assembler(options_for({"a"}, std::nullopt));
  for (std::uint64_t k = 0; k < 50; ++k) EXPECT_TRUE(assembler.add(frame_of("a", 1000 + k), grid.time_of(0)).empty());
  EXPECT_EQ(assembler.counts().cameras[0].off_grid, 50u);
  EXPECT_TRUE(assembler.finish().empty());
}

TEST(FrameSetAssembler, FinishClosesEveryTriggerOfTheTake) {
  FrameSetAssembler counted(options_for({"a"}, 4)), open_ended(options_for({"a"}, std::nullopt));
  counted.add(frame_of("a", 0), grid.time_of(0));
  EXPECT_EQ(counted.finish().size(), 3u);
  EXPECT_EQ(counted.next_deadline(), std::nullopt);
  open_ended.add(frame_of("a", 2), grid.time_of(2));
  EXPECT_EQ(open_ended.finish().size(), 3u) << "up to the last trigger that anything came for";
}

TEST(FrameSetAssembler, RefusesWhatCannotWork) {
  EXPECT_THROW(FrameSetAssembler(options_for({}, 1)), InvalidInput);
  EXPECT_THROW(FrameSetAssembler(options_for({"a", "a"}, 1)), InvalidInput);
  auto no_deadline = options_for({"a"}, 1);
  no_deadline.deadline = 0ns;
  EXPECT_THROW(FrameSetAssembler{no_deadline}, InvalidInput);
  FrameSetAssembler assembler(options_for({"a"}, 1));
  EXPECT_THROW(assembler.add(frame_of("z", 0), grid.time_of(0)), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
