#include "playback/display/headless.h"
#include "simulator/cli/command_line.h"

int main(int argc, char** argv) {
  rotunda::playback::keep_scene_memory();
  return rotunda::simulator::run_rotunda_sim(argc, argv);
}
