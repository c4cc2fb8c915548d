#include "playback/character_player.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <numbers>
#include <numeric>
#include <opencv2/core.hpp>
#include <random>

#include "config/errors.h"
#include "playback/character_film.h"
#include "playback/display/headless.h"
#include "playback/render/character_renderer.h"
#include "playback/render/geometry_image_renderer.h"
#include "tests/support/walking_ball.h"

namespace rotunda::playback {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double kFrame = 1.0 / 25.0;  // seconds

CharacterPlayer ball() {
  const auto graph = tests::ball_graph();
  return CharacterPlayer(graph, tests::ball_roots(graph));
}

double total_weight(const Appearance& seen) {
  return std::accumulate(seen.layers.begin(), seen.layers.end(), 0.0,
                         [](double sum, const Layer& layer) { return sum + layer.weight; });
}

TEST(CharacterPlayer, GoesRoundItsCycleAndStaysInPlace) {
  auto player = ball();
  for (int i = 0; i < 200; ++i) {
    const auto seen = player.appearance();
    EXPECT_NEAR(total_weight(seen), 1.0, 1e-12);
    EXPECT_NEAR(seen.place.norm(), 0.0, 1e-9);
    EXPECT_LE(seen.layers.back().frame, 35.0);  // past the seam only while it fades out
    player.advance(kFrame);
  }
  EXPECT_EQ(player.doing(), "rest");
}

TEST(CharacterPlayer, BlendsLinearlyOverFiveFrames) {
  auto player = ball();
  for (int i = 0; i < 25; ++i) player.advance(kFrame);  // frame 30: the cycle's seam
  for (int k = 0; k < 5; ++k, player.advance(kFrame)) {
    const auto seen = player.appearance();
    ASSERT_EQ(seen.layers.size(), 2U);
    EXPECT_NEAR(seen.layers[1].weight, (k + 1) / 6.0, 1e-9);
    EXPECT_NEAR(seen.layers[1].frame, 5.0 + k, 1e-9);
    EXPECT_NEAR(seen.layers[0].frame, 30.0 + k, 1e-9);
  }
  EXPECT_EQ(player.appearance().layers.size(), 1U);
}

TEST(CharacterPlayer, AnswersAtTheEarliestSeamAndTravelsWithoutAJump) {
  auto player = ball();
  player.advance(7 * kFrame);  // frame 12: the leave at 10 is gone, that at 20 is next
  player.command({.state = "roll"});
  double before = player.appearance().place.x(), fastest = 0.0;
  int answered = -1;
  for (int i = 0; i < 200; ++i) {
    player.advance(kFrame);
    if (answered < 0 && player.doing() == "rest-roll") answered = i + 1;
    const double x = player.appearance().place.x();
    fastest = std::max(fastest, x - before);
    EXPECT_GE(x, before - 1e-9);
    before = x;
  }
  EXPECT_EQ(answered, 8);
  EXPECT_EQ(player.doing(), "roll");
  // While rolling is blended in, its way and its share grow together: 5 frames' way less 5/6 of 4 frames'.
  EXPECT_LE(fastest, 1.7 * tests::kBallSpeed * kFrame);
}

TEST(CharacterPlayer, GoesTheSameWayInSmallStepsAndInLargeOnes) {
  auto fine = ball(), coarse = ball();
  fine.command({.state = "roll"});
  coarse.command({.state = "roll"});
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 4; ++j) fine.advance(kFrame / 4);
    coarse.advance(kFrame);
    ASSERT_NEAR((fine.appearance().place - coarse.appearance().place).norm(), 0.0, 1e-9);
    ASSERT_EQ(fine.doing(), coarse.doing());
  }
}

TEST(CharacterPlayer, DoesAnActionOnceAndComesBack) {
  auto player = ball();
  player.command({.state = "hop"});
  std::vector<std::string> done;
  for (int i = 0; i < 100; ++i) {
    if (done.empty() || done.back() != player.doing()) done.push_back(player.doing());
    player.advance(kFrame);
  }
  EXPECT_EQ(done, (std::vector<std::string>{"rest", "hop", "rest"}));
}

TEST(CharacterPlayer, TurnsAboutTheFootThatStandsAndOnlyWhileItGoes) {
  auto player = ball();
  player.command({.turn = std::numbers::pi / 2});
  player.advance(0.2);
  EXPECT_NEAR(player.appearance().heading, 0.0, 1e-12);  // it rests
  player.command({.state = "roll"});
  while (player.doing() != "roll" || player.appearance().layers.size() > 1) player.advance(kFrame);
  const auto& foot = player.graph().clip("roll").contacts[0].place;
  const auto place_of_foot = [&] { return Eigen::Vector2d(player.appearance().layers.back().world_from_clip * foot); };
  player.command({.turn = 0.3});
  const Eigen::Vector2d stood = place_of_foot();
  player.advance(kFrame);
  EXPECT_LT((place_of_foot() - stood).norm(), 1e-9);
  for (int i = 0; i < 60; ++i) player.advance(kFrame);
  EXPECT_NEAR(player.appearance().heading, std::numbers::pi / 2 + 0.3, 1e-6);
}

TEST(CharacterPlayer, GoesTheWayAskedForByTheShorterTurn) {
  auto player = ball();
  player.command({.heading = 1.5 * std::numbers::pi});  // a quarter to the right
  EXPECT_NEAR(player.aim(), -0.5 * std::numbers::pi, 1e-9);
  player.command({.heading = 0.5, .speed = 1.0});  // the last word counts
  for (int i = 0; i < 100; ++i) player.advance(kFrame);
  EXPECT_NEAR(player.appearance().heading, 0.5, 1e-9);
}

TEST(CharacterPlayer, PlaysFasterAndChangesStateForASpeed) {
  auto player = ball();
  player.command({.speed = 1.2});
  for (int i = 0; i < 100; ++i) player.advance(kFrame);
  EXPECT_EQ(player.doing(), "roll");
  EXPECT_NEAR(player.rate(), 1.2, 1e-9);
  player.command({.speed = 0.0});
  for (int i = 0; i < 100; ++i) player.advance(kFrame);
  EXPECT_EQ(player.doing(), "rest");
  EXPECT_THROW(player.command({.state = "fly"}), InvalidInput);
}

TEST(CharacterPlayer, StandsATenMinuteWalkOfRandomCommands) {
  auto player = ball();
  std::mt19937 random(7);
  const std::vector<std::string> words{"rest", "roll", "hop"};
  for (int i = 0; i < 600 * 25; ++i) {
    if (random() % 20 == 0) player.command({.state = words[random() % words.size()]});
    if (random() % 50 == 0) player.command({.turn = static_cast<double>(random() % 7) - 3.0});
    if (random() % 70 == 0) player.command({.speed = 0.1 * static_cast<double>(random() % 20)});
    player.advance(0.25 * kFrame * static_cast<double>(1 + random() % 8));
    const auto seen = player.appearance();
    ASSERT_NEAR(total_weight(seen), 1.0, 1e-9);
    for (const auto& layer : seen.layers) {
      ASSERT_GE(layer.frame, 0.0);
      ASSERT_LE(layer.frame, player.graph().clips[layer.clip].frames - 1);
    }
  }
}

// Two gaits of one person: a stride of 26 frames at 1 m/s, one of 18 at 2 m/s, of other phases.
recon::MotionGraph two_gaits() {
  using recon::Join, recon::Side;
  recon::MotionGraph graph{.name = "gaits", .fps = 25.0, .start = "walk"};
  graph.clips = {{.name = "walk", .frames = 40, .speed = 1.0, .strikes = {{13, Side::right}, {26, Side::left}}},
                 {.name = "jog", .frames = 40, .speed = 2.0, .strikes = {{10, Side::left}, {19, Side::right}}}};
  graph.states = {{"walk", "walk", Join{.leave = 30, .enter = 4, .pose = {1.04, 0.0, 0.0}}},
                  {"jog", "jog", Join{.leave = 24, .enter = 6, .pose = {1.44, 0.0, 0.0}}}};
  graph.transitions = {{.name = "walk-jog",
                        .from = "walk",
                        .to = "jog",
                        .leaves = {Join{.leave = 14, .enter = 20, .pose = {-1.04, 0.0, 0.0}}}}};
  return graph;
}
CharacterPlayer goer() {
  const auto graph = two_gaits();
  RootPaths roots;
  for (const auto& clip : graph.clips) {
    roots.emplace_back();
    for (int frame = 0; frame < clip.frames; ++frame) roots.back().emplace_back(frame * clip.speed / 25.0, 0.0);
  }
  return CharacterPlayer(graph, roots);
}

TEST(StridePhase, IsToldByHeelStrikes) {
  const auto graph = two_gaits();
  const auto walk = stride_phase(graph, graph.states[0]);
  ASSERT_TRUE(walk);
  EXPECT_NEAR(walk->phase_at(26.0), 0.0, 1e-12);
  EXPECT_NEAR(walk->phase_at(13.0), 0.5, 1e-12);
  EXPECT_NEAR(walk->phase_at(13.0 + 26.0), 0.5, 1e-12);  // a stride later
  EXPECT_NEAR(walk->frame_at(0.75), 19.5, 1e-12);
  for (double frame = 4.0; frame < 30.0; frame += 0.7) EXPECT_NEAR(walk->frame_at(walk->phase_at(frame)), frame, 1e-9);
  EXPECT_FALSE(stride_phase(tests::ball_graph(), tests::ball_graph().states[1]));  // a ball has no heels
}

TEST(StridePhase, BlendsLengthAndTimeOfTheStride) {
  const StridePace slow{1.04, 1.0}, fast{0.72, 2.0};
  const double share = share_for(1.4, slow, fast);
  const double length = (1.0 - share) * 1.04 * 1.0 + share * 0.72 * 2.0, time = (1.0 - share) * 1.04 + share * 0.72;
  EXPECT_NEAR(length / time, 1.4, 1e-12);
  EXPECT_EQ(share_for(0.5, slow, fast), 0.0);
  EXPECT_EQ(share_for(3.0, slow, fast), 1.0);
}

TEST(CharacterPlayer, BlendsTwoGaitsToGoAtASpeedBetweenTheirs) {
  auto player = goer();
  player.command({.speed = 1.4});
  const auto jog = stride_phase(player.graph(), player.graph().states[1]);
  const auto walk = stride_phase(player.graph(), player.graph().states[0]);
  double before = player.appearance().place.x(), begun = 0.0;
  for (int i = 0; i < 300; ++i) {
    player.advance(kFrame);
    const auto seen = player.appearance();
    const double x = seen.place.x(), step = x - before;
    EXPECT_GT(step, 0.9 * 1.0 * kFrame);
    EXPECT_LT(step, 1.1 * 1.4 * kFrame);  // no jump, at no seam of either
    EXPECT_NEAR(seen.place.y(), 0.0, 1e-9);
    EXPECT_NEAR(total_weight(seen), 1.0, 1e-9);
    before = x;
    if (i == 49) begun = x;
    if (i < 49) continue;
    const auto& first = seen.layers.front();  // of the other gait
    EXPECT_EQ(first.clip, 1U);
    const double apart = std::abs(jog->phase_at(first.frame) - walk->phase_at(seen.layers.back().frame));
    EXPECT_LT(std::min(apart, 1.0 - apart), 1e-6);
  }
  EXPECT_NEAR((before - begun) / (250 * kFrame), 1.4, 0.01);
  EXPECT_EQ(player.doing(), "walk");
}

TEST(CharacterPlayer, LeavesABlendOfGaitsForAState) {
  auto player = goer();
  player.command({.speed = 1.4});
  for (int i = 0; i < 50; ++i) player.advance(kFrame);
  EXPECT_GT(player.companion_share(), 0.2);
  player.command({.state = "jog"});
  int frames = 0;
  for (; player.doing() != "jog" && frames < 100; ++frames) player.advance(kFrame);
  EXPECT_LT(frames, 50);  // 10 until the other gait is gone, at most a stride to the seam
  EXPECT_EQ(player.companion_share(), 0.0);
}

class BallFolder : public testing::Test {
 protected:
  BallFolder() : folder_(fs::temp_directory_path() / ("rotunda-ball-" + std::to_string(::getpid()))) {
    tests::write_ball(folder_);
  }
  ~BallFolder() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  std::string problems_of(const std::string& text) {
    const auto file = folder_ / "script.yaml";
    std::ofstream(file) << text;
    try {
      read_script(file, tests::ball_graph());
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  fs::path folder_;
};

TEST_F(BallFolder, ReadsScriptsAndTellsTheirMistakes) {
  EXPECT_EQ(
      problems_of(
          "- {at: 1, state: roll}\n- {at: 2.5, turn_deg: 40}\n- {at: 2.6, heading_deg: 90}\n- {at: 3, speed: 1.6}\n"),
      "");
  EXPECT_THAT(problems_of("- {at: 1, state: rol}\n"), HasSubstr("script.yaml:1:"));
  EXPECT_THAT(problems_of("- {at: 1, state: rol}\n"), HasSubstr("hop, rest, roll"));
  EXPECT_THAT(problems_of("- {at: 2, state: roll}\n- {at: 1, state: rest}\n"), HasSubstr(":2:"));
  EXPECT_THAT(problems_of("- {at: 2, sate: roll}\n"), HasSubstr("state"));
  EXPECT_THAT(problems_of("- {at: 2}\n"), HasSubstr("asks for nothing"));
  EXPECT_THAT(problems_of("state: roll\n"), HasSubstr("a list"));
  EXPECT_THAT(problems_of("- [\n"), HasSubstr("script.yaml"));
  EXPECT_THROW(read_script(folder_ / "none.yaml", tests::ball_graph()), InvalidInput);
}

TEST_F(BallFolder, IsDrawnAsItsGeometryImagesAreAndBlendedBetweenThem) {
  const HeadlessDisplay display;
  const auto graph = recon::open_character(folder_);
  CharacterRenderer renderer(folder_, graph);
  const auto draw = [&](const Appearance& seen, const Viewpoint& eye) {
    const RenderTarget target(eye.width, eye.height);
    target.bind();
    clear(std::nullopt);
    renderer.draw(seen, eye);
    return target.read_rgba();
  };
  const auto eye = Orbit{.target = {0.4, 0.0, 1.0}}.viewpoint(160, 120);
  const auto image = [&](float x) {
    return test::round_geometry_image({.level = 4, .colour_level = 4, .centre = {x, 0.0F, 1.0F}});
  };
  const auto difference = [](const cv::Mat& a, const cv::Mat& b) {
    return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(4 * a.total());
  };
  const Appearance one{{{1, 10.0, 1.0, {}}}, {0.4, 0.0}};
  EXPECT_LT(difference(draw(one, eye), render_geometry_image(image(0.4F), eye)), 0.5);  // sixteen bits against floats
  const Appearance both{{{1, 5.0, 0.5, {}}, {1, 5.0, 0.5, {0.4, 0.0, 0.0}}}, {0.4, 0.0}};
  EXPECT_LT(difference(draw(both, eye), render_geometry_image(image(0.4F), eye)), 0.5);
  EXPECT_GT(difference(draw(one, eye), render_geometry_image(image(0.2F), eye)), 1.0);
  EXPECT_EQ(renderer.texture_bytes(), 2U * 17 * 17 * 9);  // two frames: what is drawn is loaded, no more
}

TEST_F(BallFolder, MakesTheSameFilmTwice) {
  const HeadlessDisplay display;
  const auto graph = recon::open_character(folder_);
  CharacterFilmOptions options{.width = 64, .height = 48, .supersample = 1};
  options.script.commands = {{0.1, {.state = "roll"}}};
  options.script.seconds = 1.2;
  struct Kept final : FilmWriter {
    std::vector<cv::Mat> pictures;
    void write(const cv::Mat& rgba) override { pictures.push_back(rgba.clone()); }
    void finish() override {}
  };
  Kept first, second;
  EXPECT_EQ(render_character(folder_, graph, options, first), 30);
  render_character(folder_, graph, options, second);
  ASSERT_EQ(first.pictures.size(), second.pictures.size());
  for (std::size_t i = 0; i < first.pictures.size(); ++i)
    EXPECT_EQ(cv::norm(first.pictures[i], second.pictures[i], cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace rotunda::playback
