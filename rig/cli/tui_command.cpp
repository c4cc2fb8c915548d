// rotunda tui: the operator's page.
#include <fmt/format.h>

#include "config/exit_code.h"
#include "rig/cli/command_line.h"
#include "rig/client.h"
#include "rig/tui/operator_page.h"

namespace rotunda::rig {
namespace {

int run_page(const CommandLine& line, std::stop_token stop) {
  const auto recording = run_operator_page(daemon_socket(line.daemon), std::move(stop));
  if (!recording.empty())
    fmt::print("take {} is still recording; stop it with: rotunda take stop, or in: rotunda tui\n", recording);
  return kDone;
}

}  // namespace

void add_tui_command(CommandLine& line) {
  auto* tui = line.app.add_subcommand("tui", "the operator's page: cameras, disk, slate, takes; single keys");
  tui->footer(
      "Needs a terminal, 80 x 24 or larger. Keys: a arm, r record, s stop, m mark, n note, l slate, c circle, t "
      "takes,\n"
      "? help, q quit. Quitting never stops a recording. It waits for a daemon that is not there, and finds it again.\n"
      "Example:\n  rotunda tui\n  rotunda tui --daemon /run/user/1000/rotunda.sock");
  tui->callback([&line] { line.run = [&line](std::stop_token stop) { return run_page(line, std::move(stop)); }; });
}

}  // namespace rotunda::rig
