#include "playback/display/headless.h"
#include "rig/cli/command_line.h"

int main(int argc, char** argv) {
  rotunda::playback::keep_scene_memory();
  return rotunda::rig::run_rotunda(argc, argv);
}
