#include "simulator/cli/fault_command.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "config/exit_code.h"
#include "simulator/gige/control_socket.h"

namespace rotunda::simulator {
namespace {

struct FaultQuestion {
  std::string socket, request;
};

// Prints the answer; the exit code.
int ask(const FaultQuestion& question) {
  const auto answer = ask_control_socket(question.socket, question.request);
  const auto parsed = nlohmann::json::parse(answer, nullptr, /*allow_exceptions=*/false);
  if (parsed.is_object() && parsed.value("ok", false)) {
    fmt::print("{}\n", answer);
    return kDone;
  }
  fmt::print(stderr, "rotunda-sim: {}\n", parsed.is_object() ? parsed.value("error", answer) : answer);
  return kBadInput;
}

}  // namespace

void add_fault_options(CLI::App& app, FaultControlOptions& options) {
  app.add_option("--faults", options.script, "let go wrong what this file says (config/faults.example.yaml)");
  app.add_option("--control", options.socket, "take faults and questions on this Unix socket (rotunda-sim fault)");
}

void tell_faults(const FaultControlOptions& options, const std::vector<GigeStats>& stats,
                 const std::vector<std::string>& cameras) {
  if (options.script.empty() && options.socket.empty()) return;
  fmt::print("{}\n", fault_summary(stats, cameras));
}

void add_fault_command(CommandLine& line) {
  auto* command = line.app.add_subcommand("fault", "let something go wrong in a running rotunda-sim, or ask what did");
  command->footer("Example:\n  rotunda-sim fault /tmp/sim.sock 'cam03: { silence: 2s }'");
  const auto question = std::make_shared<FaultQuestion>();
  command->add_option("SOCKET", question->socket, "its --control")->required();
  command->add_option("REQUEST", question->request, "a fault, or: status, clear, help")->required();
  command->callback([&line, question] { line.run = [question](const std::stop_token&) { return ask(*question); }; });
}

}  // namespace rotunda::simulator
