#pragma once
// Faults as people write them: a YAML file for rotunda-sim --faults, or one line for its control socket.
// docs/simulator-faults.md has the grammar. Mistakes are told all at once, as ConfigError: line, column, key, what
// was expected.
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "simulator/gige/fault_schedule.h"

namespace rotunda::simulator {

struct CameraFault {
  std::vector<std::size_t> cameras;  // by their place in the studio
  Fault fault;
};

struct FaultScript {
  std::optional<std::uint64_t> seed;
  std::vector<CameraFault> faults;
};

// `cameras` are the studio's, in its order. Throws ConfigError; std::system_error if the file cannot be read.
FaultScript load_fault_script(const std::filesystem::path& file, std::span<const std::string> cameras);
// The same from text; `name` stands for the file in messages.
FaultScript parse_fault_script(const std::string& text, const std::string& name, std::span<const std::string> cameras);

struct FaultRequest {
  enum class What { add, clear, status, help };
  What what = What::add;
  FaultScript script;                // what to add
  std::vector<std::size_t> cameras;  // whose faults to clear
};

// One line: "status", "help", "clear", "clear: cam03", "seed: 7", "cam03: { silence: 2s }" or
// "{ camera: cam03, silence: 2s }". JSON is understood, YAML's anchors and aliases are not. Throws ConfigError.
FaultRequest parse_fault_request(const std::string& line, std::span<const std::string> cameras);

}  // namespace rotunda::simulator
