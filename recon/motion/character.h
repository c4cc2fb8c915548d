#pragma once
// A character: a folder with graph.yaml and one geometry video a clip, CLIP.mkv, that needs nothing else. Clips are in
// one lattice, sample by sample, and travel over a floor that stands. docs/character-format.md.
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "recon/motion/motion_graph.h"
#include "recon/video/geometry_video.h"

namespace rotunda::recon {

struct CharacterTake {
  std::string name;  // of the clip: "walk"; "walk-jog" leads from state walk to state jog
  std::string take;  // where it comes from, for people
  std::filesystem::path video;
  std::string rig;  // empty: not known
};

struct CharacterOptions {
  std::string name = "character";
  int blend = kBlendFrames;
  std::function<void(const std::string& what, std::size_t done, std::size_t total)> progress;
  std::stop_token stop;
};

struct CharacterReport {
  MotionGraph graph;
  std::vector<std::string> told;  // takes cut at a jump, transitions synthesised, what could not be joined
};

// Takes become states (they repeat), transitions (named A-B after two states) or actions (they begin and end like a
// state). The folder takes its name when it is whole. Throws InvalidInput, with what to do: takes of different people,
// frame rates or levels, a take without a cycle or too short, no common pose between states, no state at all.
CharacterReport build_character(const std::vector<CharacterTake>& takes, const std::filesystem::path& folder,
                                const CharacterOptions& options = {});

std::filesystem::path graph_of(const std::filesystem::path& character);
std::filesystem::path clip_video_of(const std::filesystem::path& character, const std::string& clip);
bool is_character(const std::filesystem::path& folder);

// Checks the graph file against the clips. Throws what read_graph throws, and CorruptData or InvalidInput with the
// clip's file: absent, damaged, other frames, rate or lattice than the graph says.
MotionGraph open_character(const std::filesystem::path& folder);

// After graph.yaml was changed by hand: poses and prices of all seams anew; the file is written again.
MotionGraph mend_character(const std::filesystem::path& folder);

}  // namespace rotunda::recon
