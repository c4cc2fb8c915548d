#pragma once
// A performance written down: what a character is asked to do, and when. A YAML list:
//   - {at: 2.0, state: walk}     seconds from the beginning; go over to a state, or do an action (kick) once
//   - {at: 3.5, turn_deg: 40}    turn to the left by so much, while going
//   - {at: 4.5, heading_deg: 90}  go that way: 0 is where the character begins, 90 to its left
//   - {at: 5.0, speed: 1.6}      metres a second; between two states their motions are blended
//   - {at: 12.0, end: true}      the film ends; else two seconds after the last command
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "recon/motion/motion_graph.h"

namespace rotunda::playback {

struct Command {
  std::optional<std::string> state;  // or the name of an action
  std::optional<double> turn;        // radians, to the left
  std::optional<double> heading;     // radians, about +z from +x: the way to go from now on
  std::optional<double> speed;       // m/s
};

struct TimedCommand {
  double at = 0.0;  // seconds
  Command command;
};

struct PerformanceScript {
  std::vector<TimedCommand> commands;  // in order of time
  double seconds = 0.0;                // of the whole
};

// Throws ConfigError with every mistake, its line and column: a state that the graph has not, times that go back;
// InvalidInput if there is no such file.
PerformanceScript read_script(const std::filesystem::path& file, const recon::MotionGraph& graph);

}  // namespace rotunda::playback
