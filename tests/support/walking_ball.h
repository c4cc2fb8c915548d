#pragma once
// A character in closed form: a ball that rests, or rolls along +x at 1 m/s, with a seam a second. For tests of what
// plays and draws characters.
#include <filesystem>
#include <vector>

#include "recon/motion/character.h"
#include "recon/motion/graph_file.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::tests {

inline constexpr double kBallSpeed = 1.0;  // m/s

// States rest and roll, the transition rest-roll captured, roll-rest synthesised, the action hop out of rest.
inline recon::MotionGraph ball_graph() {
  using recon::Join;
  constexpr double kStep = kBallSpeed / 25.0;
  recon::MotionGraph graph{.name = "ball", .fps = 25.0, .start = "rest"};
  graph.clips = {
      {.name = "rest", .frames = 40},
      {.name = "roll", .frames = 40, .speed = kBallSpeed, .contacts = {{0, 40, recon::Side::left, {0.8, 0.1}}}},
      {.name = "rest-roll", .frames = 30, .speed = kBallSpeed},
      {.name = "hop", .frames = 30}};
  graph.states = {{"rest", "rest", Join{.leave = 30, .enter = 5}},
                  {"roll", "roll", Join{.leave = 30, .enter = 5, .pose = {25 * kStep, 0.0, 0.0}}}};
  graph.transitions = {{.name = "rest-roll",
                        .from = "rest",
                        .to = "roll",
                        .clip = "rest-roll",
                        .leaves = {Join{.leave = 10, .enter = 0}, Join{.leave = 20, .enter = 0}},
                        .arrive = Join{.leave = 20, .enter = 5, .pose = {15 * kStep, 0.0, 0.0}}},
                       {.name = "roll-rest",
                        .from = "roll",
                        .to = "rest",
                        .leaves = {Join{.leave = 15, .enter = 8, .pose = {15 * kStep, 0.0, 0.0}}}},
                       {.name = "hop",
                        .from = "rest",
                        .to = "rest",
                        .clip = "hop",
                        .leaves = {Join{.leave = 12, .enter = 0}},
                        .arrive = Join{.leave = 20, .enter = 6}}};
  return graph;
}

// Where the ball is in each clip's frames: what rolls moves on, what rests or hops does not.
inline Eigen::Vector2d ball_place(const recon::MotionClip& clip, int frame) {
  return {clip.speed > 0.0 ? frame * kBallSpeed / 25.0 : 0.0, 0.0};
}

inline std::vector<std::vector<Eigen::Vector2d>> ball_roots(const recon::MotionGraph& graph) {
  std::vector<std::vector<Eigen::Vector2d>> roots;
  for (const auto& clip : graph.clips) {
    roots.emplace_back();
    for (int frame = 0; frame < clip.frames; ++frame) roots.back().push_back(ball_place(clip, frame));
  }
  return roots;
}

inline void write_ball(const std::filesystem::path& folder) {
  const auto graph = ball_graph();
  std::filesystem::create_directories(folder);
  for (const auto& clip : graph.clips) {
    std::vector<recon::GeometryImage> images;
    for (int frame = 0; frame < clip.frames; ++frame) {
      const auto place = ball_place(clip, frame);
      images.push_back(test::round_geometry_image(
          {.level = 4, .colour_level = 4, .centre = {static_cast<float>(place.x()), 0.0F, 1.0F}}));
    }
    recon::write_geometry_video(recon::clip_video_of(folder, clip.name), images);
  }
  recon::write_graph(recon::graph_of(folder), graph);
}

}  // namespace rotunda::tests
