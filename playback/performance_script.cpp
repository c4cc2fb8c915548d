#include "playback/performance_script.h"

#include <fmt/format.h>

#include <fstream>
#include <numbers>
#include <sstream>

#include "config/checked_yaml.h"
#include "config/errors.h"

namespace rotunda::playback {
namespace {

namespace fs = std::filesystem;
constexpr double kLongest = 3600.0;  // seconds
constexpr double kAfterwards = 2.0;  // seconds after the last command
constexpr std::uintmax_t kLargest = 1U << 20U;

YAML::Node load(const fs::path& file) {
  std::error_code none;
  if (!fs::is_regular_file(file, none)) throw InvalidInput("there is no script " + file.string());
  if (fs::file_size(file) > kLargest) throw ConfigError(file, {{0, 0, "", "is longer than a script can be, 1 MiB"}});
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  try {
    return YAML::Load(text.str());
  } catch (const YAML::Exception& error) {
    throw ConfigError(file, {{error.mark.line + 1, error.mark.column + 1, "", error.msg}});
  }
}

// States and actions: what may stand behind `state`.
config::Words words_of(const recon::MotionGraph& graph) {
  config::Words words;
  for (const auto& state : graph.states) words.insert(state.name);
  for (const auto& transition : graph.transitions)
    if (transition.from == transition.to) words.insert(transition.name);
  return words;
}

class ScriptReader {
 public:
  ScriptReader(const recon::MotionGraph& graph, config::Problems& problems)
      : words_(words_of(graph)), problems_(problems) {}

  PerformanceScript read(const YAML::Node& node) {
    if (!node.IsSequence()) {
      problems_.push_back({1, 1, "", "expected a list of commands such as - {at: 2.0, state: walk}"});
      return script_;
    }
    for (std::size_t i = 0; i < node.size(); ++i) read_entry(node[i], fmt::format("[{}]", i));
    if (script_.seconds == 0.0)
      script_.seconds = (script_.commands.empty() ? 0.0 : script_.commands.back().at) + kAfterwards;
    return script_;
  }

 private:
  void read_entry(const YAML::Node& node, const std::string& path) {
    config::CheckedMap map(node, path, problems_);
    if (!node.IsMap()) return;
    TimedCommand timed;
    map.require("at", "seconds from the beginning");
    map.read<double>("at", timed.at, fmt::format("seconds, 0 to {:g}", kLongest), config::between(0.0, kLongest));
    if (!script_.commands.empty() && timed.at < script_.commands.back().at)
      map.wrong(map.find("at"), "at",
                fmt::format("a time not before {:g}, that of the command above", script_.commands.back().at));
    bool end = false;
    map.read("end", end, "true");
    if (end) script_.seconds = timed.at;
    read_command(map, timed.command);
    const bool says_nothing =
        !end && !map.find("state") && !map.find("turn_deg") && !map.find("heading_deg") && !map.find("speed");
    map.refuse_unknown_keys();
    if (says_nothing)
      problems_.push_back({node.Mark().line + 1, node.Mark().column + 1, path,
                           "asks for nothing; expected state, turn_deg, heading_deg, speed or end"});
    if (!end) script_.commands.push_back(std::move(timed));
  }

  void read_command(config::CheckedMap& map, Command& command) const {
    std::string state;
    map.read<std::string>("state", state, config::one_of(words_), config::in(words_));
    if (!state.empty()) command.state = state;
    double number = 0.0;
    if (map.find("turn_deg")) {
      map.read<double>("turn_deg", number, "degrees to the left, -3600 to 3600", config::between(-3600.0, 3600.0));
      command.turn = number * std::numbers::pi / 180.0;
    }
    if (map.find("heading_deg")) {
      map.read<double>("heading_deg", number, "degrees, -360 to 360", config::between(-360.0, 360.0));
      command.heading = number * std::numbers::pi / 180.0;
    }
    if (map.find("speed")) {
      map.read<double>("speed", number, "m/s, 0 to 10", config::between(0.0, 10.0));
      command.speed = number;
    }
  }

  config::Words words_;
  config::Problems& problems_;
  PerformanceScript script_;
};

}  // namespace

PerformanceScript read_script(const fs::path& file, const recon::MotionGraph& graph) {
  const auto node = load(file);
  config::Problems problems;
  auto script = ScriptReader(graph, problems).read(node);
  if (!problems.empty()) throw ConfigError(file, std::move(problems));
  return script;
}

}  // namespace rotunda::playback
