#pragma once
// A motion graph as `rotunda character` tells it.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "recon/motion/motion_graph.h"

namespace rotunda::rig {

nlohmann::json graph_report(const recon::MotionGraph& graph);
void print_graph(const recon::MotionGraph& graph);

struct CommandLine;

struct ShownCharacter {
  std::filesystem::path folder;
  std::filesystem::path picture;     // of the graph; empty: none
  std::filesystem::path similarity;  // of its frames; empty: none
};
int show_character(const CommandLine& line, const ShownCharacter& shown);

}  // namespace rotunda::rig
