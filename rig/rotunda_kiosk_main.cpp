// The kiosk: the daemon's live surfaces full screen, on a desktop or without one, with pictures of four cameras and
// their mattes beside them. A process of its own: what happens to it costs no frame.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <string>

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
  using rotunda::playback::DisplayKind;
  request.display = DisplayKind::automatic;
  bool windowed = false;
  app.add_option("--daemon", request.socket, "the daemon's socket (else ROTUNDA_SOCKET, the runtime folder)");
  auto* window = app.add_flag("--windowed", windowed, "in a window instead of the whole screen");
  const std::map<std::string, DisplayKind> displays = {
      {"auto", DisplayKind::automatic}, {"window", DisplayKind::window}, {"kms", DisplayKind::screen}};
  app.add_option("--display", request.display,
                 "auto: the desktop where there is one (DISPLAY, WAYLAND_DISPLAY), else kms, the bare screen; window")
      ->transform(CLI::CheckedTransformer(displays).description("auto|window|kms"))
      ->excludes(window);
  app.add_option("--device", request.device, "of the bare screen, as /dev/dri/card1 (the first with a display)");
  app.add_option("--connector", request.connector, "of the bare screen, as HDMI-A-1 (the first with a display)");
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
      "Without a desktop it has the screen for itself, from a text console or as a service (groups video and input);\n"
      "a display that is unplugged is waited for, the console comes back at the end.\n"
      "Examples:\n  rotunda-kiosk --display kms --device /dev/dri/card1\n  rotunda-kiosk --picture kiosk.png");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? rotunda::kDone : rotunda::kUsage;
  }
  request.fullscreen = !windowed;
  if (windowed) request.display = DisplayKind::window;
  return run(std::move(request));
}
