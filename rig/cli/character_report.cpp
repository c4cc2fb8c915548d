#include "rig/cli/character_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/picture.h"
#include "config/exit_code.h"
#include "playback/graph_picture.h"
#include "recon/motion/character.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;

json join_report(const recon::Join& join) {
  return {{"leave", join.leave},
          {"enter", join.enter},
          {"blend", join.blend},
          {"error_mm", join.price.error_mm},
          {"largest_mm", join.price.largest_mm},
          {"step_ratio", join.price.step_ratio},
          {"colour", join.price.colour},
          {"slide_mm", join.price.slide_mm}};
}

const recon::Join& best_of(const std::vector<recon::Join>& joins) {
  return *std::min_element(joins.begin(), joins.end(),
                           [](const auto& a, const auto& b) { return a.price.error_mm < b.price.error_mm; });
}

void print_seam(const std::string& what, const std::string& where, const recon::Join& join) {
  fmt::print("{:<24} {:<18} {:>5} {:>6} {:>9.1f} {:>10.1f} {:>6.2f} {:>7.1f} {:>9.1f}\n", what, where, join.leave,
             join.enter, join.price.error_mm, join.price.largest_mm, join.price.step_ratio, join.price.colour,
             join.price.slide_mm);
}

}  // namespace

json graph_report(const recon::MotionGraph& graph) {
  json report{{"name", graph.name},           {"fps", graph.fps},
              {"start", graph.start},         {"states", json::array()},
              {"transitions", json::array()}, {"clips", json::array()}};
  for (const auto& state : graph.states)
    report["states"].push_back({{"name", state.name},
                                {"clip", state.clip},
                                {"frames", state.period()},
                                {"speed", graph.clip(state.clip).speed},
                                {"loop", join_report(state.loop)}});
  for (const auto& transition : graph.transitions) {
    json leaves = json::array();
    for (const auto& join : transition.leaves) leaves.push_back(join_report(join));
    json entry{{"name", transition.name},
               {"from", transition.from},
               {"to", transition.to},
               {"synthesised", transition.synthesised()},
               {"leaves", leaves}};
    if (!transition.synthesised()) entry["arrive"] = join_report(transition.arrive);
    report["transitions"].push_back(std::move(entry));
  }
  for (const auto& clip : graph.clips) {
    json strikes = json::array();
    for (const auto& strike : clip.strikes)
      strikes.push_back({{"frame", strike.frame}, {"foot", strike.side == recon::Side::left ? "left" : "right"}});
    report["clips"].push_back({{"name", clip.name},
                               {"take", clip.take},
                               {"frames", clip.frames},
                               {"speed", clip.speed},
                               {"heel_strikes", strikes}});
  }
  return report;
}

void print_graph(const recon::MotionGraph& graph) {
  fmt::print("{}: {} states, {} transitions, {} frames a second, begins in {}\n", graph.name, graph.states.size(),
             graph.transitions.size(), graph.fps, graph.start);
  fmt::print("{:<24} {:<18} {:>5} {:>6} {:>9} {:>10} {:>6} {:>7} {:>9}\n", "", "seam", "leave", "enter", "error mm",
             "largest mm", "step", "colour", "slide mm");
  for (const auto& state : graph.states) {
    const double speed = graph.clip(state.clip).speed;
    print_seam(fmt::format("{}, {} frames{}", state.name, state.period(),
                           speed > 0.0 ? fmt::format(", {:.2f} m/s", speed) : ""),
               "cycle", state.loop);
  }
  for (const auto& transition : graph.transitions) {
    print_seam(transition.name + (transition.synthesised() ? ", synthesised" : ""),
               fmt::format("out of {}, {}", transition.from, transition.leaves.size()), best_of(transition.leaves));
    if (!transition.synthesised()) print_seam("", "into " + transition.to, transition.arrive);
  }
  fmt::print("step: a seam's largest step of a sample against the median of that in its clips\n");
}

int show_character(const CommandLine& line, const ShownCharacter& shown) {
  const auto graph = recon::open_character(shown.folder);
  if (!shown.picture.empty()) capture::write_png(shown.picture, playback::graph_picture(shown.folder, graph));
  if (!shown.similarity.empty()) capture::write_png(shown.similarity, playback::similarity_sheet(shown.folder, graph));
  if (line.json)
    fmt::print("{}\n", graph_report(graph).dump(2));
  else
    print_graph(graph);
  return kDone;
}

}  // namespace rotunda::rig
