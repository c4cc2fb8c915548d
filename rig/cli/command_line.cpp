#include "rig/cli/command_line.h"

#include <fmt/format.h>

#include <cstdlib>
#include <set>

#include "capture/base/interrupt.h"
#include "capture/take/take.h"
#include "config/checked_yaml.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "rig/client.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;

// CLI11 only says that a subcommand is wanted; people want to know which one they meant.
std::string unknown_command(const CLI::App& app, int argc, const char* const* argv) {
  const CLI::App* at = &app;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--takes" || word == "--daemon") ++i;  // and their value
    if (word.rfind('-', 0) == 0) continue;
    std::set<std::string> known;
    const CLI::App* next = nullptr;
    for (const auto* command : at->get_subcommands(nullptr)) {
      known.insert(command->get_name());
      if (command->get_name() == word) next = command;
    }
    if (known.empty()) return "";
    if (!next) {
      const auto nearest = config::nearest_word(word, known);
      return fmt::format("unknown command \"{}\"; {}", word,
                         nearest.empty() ? fmt::format("known: {}", fmt::join(known, ", "))
                                         : fmt::format("did you mean \"{}\"?", nearest));
    }
    at = next;
  }
  return "";
}

int explain(const CommandLine& line, const CLI::ParseError& error, int argc, const char* const* argv) {
  if (error.get_exit_code() == 0) return line.app.exit(error);  // --help, --version
  const bool about_commands = error.get_name() == "ExtrasError" || error.get_name() == "RequiredError";
  const auto advice = about_commands ? unknown_command(line.app, argc, argv) : "";
  fmt::print(stderr, "rotunda: {}\nSee: rotunda --help, or rotunda COMMAND --help\n",
             advice.empty() ? error.what() : advice);
  return kUsage;
}

fs::path daemons_takes(const CommandLine& line) {
  const auto socket = daemon_socket(line.daemon);
  if (!fs::exists(socket)) return {};
  try {
    return RigClient(socket).status().takes_folder;
  } catch (const DeviceError&) {
    return {};  // a socket that a dead daemon left behind
  }
}

}  // namespace

fs::path takes_folder(const CommandLine& line) {
  if (!line.takes.empty()) return fs::absolute(line.takes);
  if (const char* folder = std::getenv("ROTUNDA_TAKES"); folder && *folder) return fs::absolute(folder);
  if (const auto folder = daemons_takes(line); !folder.empty()) return folder;
  return fs::absolute("takes");
}

fs::path find_take(const CommandLine& line, const std::string& take) {
  return capture::resolve_take(take, takes_folder(line));
}

CLI::AsNumberWithUnit seconds() {
  const std::map<std::string, double> units{{"ms", 0.001}, {"s", 1.0}, {"min", 60.0}, {"h", 3600.0}};
  return CLI::AsNumberWithUnit(units, CLI::AsNumberWithUnit::DEFAULT, "TIME");
}

CLI::AsNumberWithUnit metres() {
  const std::map<std::string, double> units{{"mm", 0.001}, {"cm", 0.01}, {"m", 1.0}};
  return CLI::AsNumberWithUnit(units, CLI::AsNumberWithUnit::DEFAULT, "LENGTH");
}

int run_rotunda(int argc, const char* const* argv) {
  const capture::Interrupt interrupt;
  CommandLine line;
  line.app.set_version_flag("--version", "rotunda 0.1.0");
  line.app.require_subcommand(1);
  line.app.fallthrough();
  line.app.add_flag("--json", line.json, "report as JSON on stdout");
  line.app.add_option("--takes", line.takes, "folder of the takes (else ROTUNDA_TAKES, the daemon's, ./takes)");
  line.app.add_option("--daemon", line.daemon, "the daemon's socket (else ROTUNDA_SOCKET, the runtime folder's)");
  line.app.footer(
      "Example:\n  rotunda take start demo --duration 4s && rotunda recon demo && rotunda render demo --orbit -o "
      "demo.mp4");
  add_doctor_command(line);
  add_rig_commands(line);
  add_tui_command(line);
  add_take_commands(line);
  add_plate_command(line);
  add_board_command(line);
  add_calibrate_command(line);
  add_screen_command(line);
  add_recon_commands(line);
  add_character_commands(line);
  add_mocap_command(line);
  add_render_command(line);
  add_play_commands(line);
  add_export_command(line);
  add_animate_command(line);
  try {
    line.app.parse(argc, argv);
    return line.run ? line.run(interrupt.token()) : static_cast<int>(kUsage);
  } catch (const CLI::ParseError& error) {
    return explain(line, error, argc, argv);
  } catch (...) {
    return report_current_exception("rotunda");
  }
}

}  // namespace rotunda::rig
