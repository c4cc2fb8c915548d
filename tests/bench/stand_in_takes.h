#pragma once
// Stand-ins for aligned takes: a simulated person's acts as geometry videos whose samples correspond perfectly, so that
// motion graphs are measured apart from reconstruction and matching. DIR/ACT.mkv; acts that do not repeat hold one
// round.
#include <filesystem>
#include <string>
#include <vector>

namespace rotunda::bench {

// Reconstructed surfaces are wrong by some millimetres: `noise` moves every sample along a smooth field of its own a
// frame, metres standard deviation.
struct StandInOptions {
  std::string person = "alex";
  std::vector<std::string> acts{"idle", "walk", "jog", "kick", "idle-walk", "walk-idle", "walk-jog", "jog-walk"};
  int level = 8;
  double seconds = 2.4;  // of acts that repeat: two strides of a walk and what is blended
  double noise = 0.0;
};
void write_stand_ins(const std::filesystem::path& folder, const StandInOptions& options);

}  // namespace rotunda::bench
