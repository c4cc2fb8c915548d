#include "recon/motion/motion_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numbers>
#include <random>

#include "config/errors.h"
#include "recon/motion/character.h"
#include "recon/motion/foot_track.h"
#include "recon/motion/graph_builder.h"
#include "recon/motion/graph_file.h"
#include "recon/motion/motion_seam.h"
#include "tests/support/truth_clip.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;

constexpr int kLevel = 6;

// One person's clips whose samples correspond, made once.
const std::vector<GeometryImage>& clip_of(const std::string& act, int frames) {
  static std::optional<tests::TruthLattice> lattice;
  static std::map<std::string, std::vector<GeometryImage>> clips;
  auto& images = clips[act + std::to_string(frames)];
  if (images.empty()) {
    const auto performance = simulator::make_performance({.act = act, .coarseness = 1.4, .texels_per_edge = 2});
    if (!lattice) lattice = tests::truth_lattice(*performance, kLevel);
    images = tests::truth_clip(*performance, *lattice, 0, frames);
  }
  return images;
}

ClipShape shape_of(const std::string& act, int frames) {
  return clip_shape(clip_of(act, frames), act, kLevel, 25.0);
}

class CharacterFolder : public testing::Test {
 protected:
  CharacterFolder() : folder_(fs::temp_directory_path() / fs::path("rotunda-character-" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~CharacterFolder() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  CharacterTake take(const std::string& act, int frames) {
    const auto file = folder_ / (act + ".mkv");
    write_geometry_video(file, clip_of(act, frames));
    return {act, act, file};
  }
  std::string refusal(const std::vector<CharacterTake>& takes) {
    try {
      build_character(takes, folder_ / "character");
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }
  fs::path folder_;
};

TEST(GaitEvents, FindsTheHeelStrikesOfWhoWalksOnTheSpot) {
  const auto events = gait_events(shape_of("walk", 58));
  // The simulator's strikes: left at 0, 26, 52, right at 13, 39; who has begun before the clip is not seen to strike.
  ASSERT_EQ(events.strikes.size(), 4U);
  const int frames[] = {13, 26, 39, 52};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(events.strikes[i].frame, frames[i], 1);
    EXPECT_EQ(events.strikes[i].side, i % 2 == 0 ? Side::right : Side::left);
  }
  EXPECT_NEAR(events.heading, 0.0, 0.05);               // it faces +x
  EXPECT_NEAR(events.floor_velocity.x(), -1.16, 0.05);  // its belt's speed: 1.21 m stride in 1.04 s
}

TEST(GaitEvents, FindsTheHeelStrikesOfARunnerThroughTheFlight) {
  const auto events = gait_events(shape_of("jog", 40));
  // The simulator's strikes: left at 0, 17, 34, right half way between, at 8.5 and 25.5.
  ASSERT_EQ(events.strikes.size(), 4U);
  const double frames[] = {8.5, 17.0, 25.5, 34.0};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(events.strikes[i].frame, frames[i], 1.0);
    EXPECT_EQ(events.strikes[i].side, i % 2 == 0 ? Side::right : Side::left);
  }
}

// A heel's tip is the first that reconstruction loses: shoes are taken off by three centimetres at their hind ends.
TEST(GaitEvents, FindsTheHeelStrikesOfHeelsThatWereWornOff) {
  auto clip = shape_of("walk", 58);
  const auto whole = track_feet(clip);
  for (std::size_t i = 0; i < clip.frames.size(); ++i)
    for (auto& p : clip.frames[i])
      for (const auto& feet : whole.feet) {
        const auto& foot = feet[i];
        const double behind = foot.place.x() - static_cast<double>(p.x());
        const bool of_this_foot =
            std::abs(static_cast<double>(p.y()) - foot.place.y()) < 0.08 && std::abs(behind) < 0.2;
        const double worn = 0.06 * std::clamp(0.5 + behind / 0.2, 0.0, 1.0) + foot.height;
        if (foot.seen && of_this_foot) p.z() = std::max(p.z(), static_cast<float>(whole.floor_height + worn));
      }
  const auto events = gait_events(clip);
  ASSERT_EQ(events.strikes.size(), 4U);
  const int frames[] = {13, 26, 39, 52};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(events.strikes[i].frame, frames[i], 1);
}

// Millimetres by which a surface differs from frame to frame, the same as it is every time.
void tremble(ClipShape& clip, float amplitude) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> along(-amplitude, amplitude);
  for (auto& frame : clip.frames) {
    const Eigen::Vector3f by(along(random), along(random), 0.0F);
    for (auto& p : frame)
      if (p.z() < 0.5F) p += by;
  }
}

TEST(GaitEvents, TakesNoTrembleOfWhoHasStoppedForAStep) {
  auto clip = shape_of("walk-idle", 50);
  tremble(clip, 0.002F);
  const auto events = gait_events(clip);
  ASSERT_EQ(events.strikes.size(), 2U);  // the simulator's: right at 13, left at 26; then both feet stand
  EXPECT_NEAR(events.strikes[0].frame, 13, 1);
  EXPECT_EQ(events.strikes[0].side, Side::right);
  EXPECT_NEAR(events.strikes[1].frame, 26, 1);
  EXPECT_EQ(events.strikes[1].side, Side::left);
}

TEST(GaitEvents, FindsWhereAKickingFootIsSetDown) {
  const auto events = gait_events(shape_of("kick", 80));
  ASSERT_EQ(events.strikes.size(), 1U);
  EXPECT_NEAR(events.strikes[0].frame, 50, 2);
  EXPECT_EQ(events.strikes[0].side, Side::right);
}

TEST(GaitEvents, LeavesWhoStandsStanding) {
  const auto events = gait_events(shape_of("idle", 30));
  EXPECT_TRUE(events.strikes.empty());
  EXPECT_EQ(events.floor_velocity.norm(), 0.0);
  EXPECT_EQ(events.speed, 0.0);
  EXPECT_NEAR(events.heading, 0.0, 0.2);  // by the feet, which point a little outwards
  ASSERT_EQ(events.contacts.size(), 2U);  // both feet, all the time
  EXPECT_EQ(events.contacts[0].end - events.contacts[0].begin, 30);
}

TEST(FrameSimilarity, SeesThroughATurnAndAShiftOnTheFloor) {
  const auto clip = shape_of("walk", 58);
  ClipShape moved = clip;
  const FloorPose pose{0.4, -0.7, 0.9};
  for (auto& frame : moved.frames)
    for (auto& p : frame) p = (pose * Eigen::Vector3d(p.cast<double>())).cast<float>();
  const PairTable table(moved, clip);
  const auto same = table.window(10, 10, 5);
  EXPECT_LT(same.distance, 1e-4);  // what floats leave of nothing
  EXPECT_NEAR(same.pose.x, pose.x, 1e-4);
  EXPECT_NEAR(same.pose.y, pose.y, 1e-4);
  EXPECT_NEAR(same.pose.yaw, pose.yaw, 1e-4);
  EXPECT_GT(table.window(10, 20, 5).distance, 0.05);  // another phase of the stride
}

TEST(FloorPose, UndoesItself) {
  const FloorPose pose{0.3, -1.1, 2.0};
  const Eigen::Vector2d p(0.7, 0.2);
  EXPECT_LT((pose.inverse() * (pose * p) - p).norm(), 1e-12);
  const auto about = FloorPose::turn_about(p, 1.3);
  EXPECT_LT((about * p - p).norm(), 1e-12);
}

TEST(MotionSeam, ClosesAWalksCycleAfterOneStrideWithTheStandingFootHeld) {
  const auto clip = moving_clip(shape_of("walk", 58));
  const auto found = find_cycle(clip, kBlendFrames);
  ASSERT_TRUE(found.loop) << found.failure;
  EXPECT_EQ(found.loop->leave - found.loop->enter, 26);
  EXPECT_NEAR(found.loop->pose.x, 1.04 * clip.events.speed, 0.02);  // the way of a stride
  EXPECT_LE(found.loop->price.step_ratio, 1.5);                     // closed where the stride itself is slow
  EXPECT_LE(found.loop->price.slide_mm, 10.0);
}

TEST(MotionSeam, TellsWhoHasNoCycle) {
  const auto clip = moving_clip(shape_of("walk-idle", 50));
  const auto found = find_cycle(clip, kBlendFrames);
  EXPECT_FALSE(found.loop);
  EXPECT_THAT(found.failure, HasSubstr("walk-idle"));
  EXPECT_THAT(found.failure, HasSubstr("record"));
}

TEST(GraphBuilder, JoinsStatesByCapturedTransitionsAndSynthesisesWhatIsMissing) {
  std::vector<MovingClip> clips;
  clips.push_back(moving_clip(shape_of("walk", 58)));
  clips.push_back(moving_clip(shape_of("idle", 40)));
  clips.push_back(moving_clip(shape_of("idle-walk", 50)));
  const auto built = build_graph(clips, "alex", kBlendFrames);
  ASSERT_EQ(built.graph.states.size(), 2U);
  EXPECT_EQ(built.graph.start, "idle");
  ASSERT_EQ(built.graph.transitions.size(), 2U);
  const auto& captured = built.graph.transitions[0];
  EXPECT_FALSE(captured.synthesised());
  EXPECT_LT(captured.arrive.price.error_mm, 15.0);  // the simulator leads it into the very cycle
  EXPECT_TRUE(built.graph.transitions[1].synthesised());
  EXPECT_EQ(built.graph.transitions[1].from, "walk");
  ASSERT_EQ(built.told.size(), 1U);
}

TEST(MotionSeam, IsNoneThatIsSeenWhereAnotherComesSoon) {
  const auto walk = moving_clip(shape_of("walk", 58)), idle = moving_clip(shape_of("idle", 40));
  const auto loop = find_cycle(walk, kBlendFrames).loop;
  ASSERT_TRUE(loop);
  const auto joins = nearest_joins(walk, idle, {loop->enter, loop->leave, 0, 30}, kBlendFrames);
  const auto is_seen = [](const Join& join) { return join.price.step_ratio > 1.5 || join.price.slide_mm > 10.0; };
  constexpr int kPatience = 10;  // 0.4 s
  int unseen = 0;
  for (const auto& join : joins) {
    unseen += is_seen(join) ? 0 : 1;
    for (const auto& other : joins)
      EXPECT_FALSE(is_seen(join) && !is_seen(other) && std::abs(join.leave - other.leave) <= kPatience)
          << join.leave << " slides by " << join.price.slide_mm << " mm, " << other.leave << " does not";
  }
  EXPECT_GT(unseen, 0);
}

TEST_F(CharacterFolder, BuildsOpensAndMendsACharacter) {
  const auto report =
      build_character({take("walk", 58), take("idle", 40), take("idle-walk", 50)}, folder_ / "character");
  const auto opened = open_character(folder_ / "character");
  ASSERT_EQ(opened.states.size(), report.graph.states.size());
  EXPECT_EQ(opened.states[0].loop.leave, report.graph.states[0].loop.leave);
  EXPECT_NEAR(opened.states[0].loop.pose.x, report.graph.states[0].loop.pose.x, 1e-5);
  // Moved by hand, the seam lies elsewhere and costs something else.
  auto changed = opened;
  changed.states[0].loop.leave -= 2;
  write_graph(graph_of(folder_ / "character"), changed);
  const auto mended = mend_character(folder_ / "character");
  EXPECT_GT(mended.states[0].loop.price.error_mm, opened.states[0].loop.price.error_mm);
}

// The simulator plays an act again and again: a take goes on behind its end with a jump back to the beginning.
TEST_F(CharacterFolder, CutsATakeWhereItJumps) {
  const auto report =
      build_character({take("walk", 58), take("idle", 40), take("idle-walk", 62)}, folder_ / "character");
  EXPECT_EQ(report.graph.clip("idle-walk").frames, 50);
  EXPECT_THAT(report.told, Contains(HasSubstr("0:50")));
}

TEST_F(CharacterFolder, RefusesWhatCannotBecomeACharacter) {
  EXPECT_THAT(refusal({}), HasSubstr("name at least one"));
  EXPECT_THAT(refusal({take("walk", 10)}), HasSubstr("too short"));
  EXPECT_THAT(refusal({take("walk-idle", 50)}), HasSubstr("no cycle"));
  auto ours = take("walk", 58), theirs = take("idle", 40);
  ours.rig = "studio 1";
  theirs.rig = "studio 2";
  EXPECT_THAT(refusal({ours, theirs}), HasSubstr("studio 2"));
  // A kick is nothing that a walk's transition begins or ends with.
  auto wrong = take("kick", 60);
  wrong.name = "walk-idle";
  EXPECT_THAT(refusal({take("walk", 58), take("idle", 40), wrong}), HasSubstr("no pose in common"));
  EXPECT_FALSE(fs::exists(folder_ / "character"));
}

class GraphText : public CharacterFolder {
 protected:
  std::string problems_of(const std::string& text) {
    const auto file = folder_ / "graph.yaml";
    std::ofstream(file) << text;
    try {
      read_graph(file);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
};

constexpr const char* kGood = R"(version: 1
name: alex
fps: 25
start: idle
states:
  idle:
    clip: idle
    loop: {leave: 30, enter: 2}
transitions: {}
clips:
  idle: {frames: 40}
)";

TEST_F(GraphText, TellsEveryMistakeWithItsPlace) {
  EXPECT_EQ(problems_of(kGood), "");
  const auto with = [](std::string from, std::string to) {
    std::string text = kGood;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_THAT(problems_of(with("start: idle", "start: idel")), HasSubstr(":4:8"));
  EXPECT_THAT(problems_of(with("clip: idle", "clip: gone")), HasSubstr("states.idle.clip"));
  EXPECT_THAT(problems_of(with("leave: 30", "leave: 39")), HasSubstr("blended frames of clip idle"));
  EXPECT_THAT(problems_of(with("enter: 2", "enter: 33")), HasSubstr("goes back"));
  EXPECT_THAT(problems_of(with("transitions: {}", "transitions: {kick: {from: idle, to: stance, clip: idle}}")),
              HasSubstr("transitions.kick.to"));
  EXPECT_THAT(problems_of("- 1\n"), HasSubstr("graph.yaml"));
  EXPECT_THAT(problems_of("a: [\n"), HasSubstr("graph.yaml"));
}

TEST_F(CharacterFolder, TellsADamagedOrMissingClip) {
  build_character({take("idle", 40)}, folder_ / "character");
  const auto clip = clip_video_of(folder_ / "character", "idle");
  fs::resize_file(clip, fs::file_size(clip) / 2);
  EXPECT_ANY_THROW(open_character(folder_ / "character"));
  fs::remove(clip);
  EXPECT_THROW(open_character(folder_ / "character"), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
