#pragma once
// From clips in one lattice to a motion graph: which are states, transitions or actions, and where they join. Private
// to recon/motion.
#include <string>
#include <vector>

#include "recon/motion/motion_graph.h"
#include "recon/motion/motion_seam.h"

namespace rotunda::recon {

struct BuiltGraph {
  MotionGraph graph;
  std::vector<std::string> told;
};

// Throws InvalidInput as build_character does.
BuiltGraph build_graph(const std::vector<MovingClip>& clips, const std::string& name, int blend);

}  // namespace rotunda::recon
