// The kiosk: the daemon's live surfaces full screen, with pictures of four cameras and their mattes beside them. A
// process of its own: what happens to it costs no frame.
#include <CLI/CLI.hpp>
#include <filesystem>

#include "capture/base/interrupt.h"
#include "config/exit_code.h"
#include "playback/display/headless.h"
#include "rig/cli/live_view.h"
#include "rig/client.h"

namespace {

int run(rotunda::rig::LiveViewRequest request) {
  const rotunda::capture::Interrupt interrupt;
  try {
    request.socket = rotunda::rig::daemon_socket(request.socket);
    return rotunda::rig::show_live(request, interrupt.token());
  } catch (...) {
    return rotunda::report_current_exception("rotunda-kiosk");
  }
}

}  // namespace

int main(int argc, char** argv) {
  rotunda::playback::keep_scene_memory();
  CLI::App app{"Full-screen live view of the rig: the surface, and four cameras with their mattes", "rotunda-kiosk"};
  rotunda::rig::LiveViewRequest request{
      .socket = {}, .with_pictures = true, .fullscreen = true, .picture = {}, .size = {}};
  bool windowed = false;
  app.add_option("--daemon", request.socket, "the daemon's socket (else ROTUNDA_SOCKET, the runtime folder)");
  app.add_flag("--windowed", windowed, "in a window instead of the whole screen");
  auto* picture = app.add_option("--picture", request.picture, "write what it would show as a PNG; needs no display");
  app.add_option("--surfaces", request.surfaces, "so many come before the picture is written")
      ->needs(picture)
      ->check(CLI::PositiveNumber);
  app.add_option("--size", request.size, "WIDTHxHEIGHT of the window or picture (1280x720)")
      ->delimiter('x')
      ->expected(2)
      ->check(CLI::Range(16, 16384));
  app.add_flag("--json", request.json, "report as JSON");
  app.footer(
      "Keys: arrows and mouse go round, + - zoom, space holds, Home from the front, g grey, q ends.\n"
      "Without a desktop: start it under a kiosk compositor with X, such as: cage rotunda-kiosk\n"
      "Example:\n  rotunda-kiosk --picture kiosk.png");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? rotunda::kDone : rotunda::kUsage;
  }
  request.fullscreen = !windowed;
  return run(std::move(request));
}
