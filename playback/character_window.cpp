#include "playback/character_window.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

#include "playback/character_desk.h"
#include "playback/character_view.h"
#include "playback/clip_loader.h"
#include "playback/display/open_display.h"
#include "playback/graph_map.h"
#include "playback/picture_clock.h"
#include "playback/render/overlay.h"
#include "playback/render/stage.h"

namespace rotunda::playback {

namespace {

// What outlasts a graphics context.
struct Played {
  CharacterPlayer player;
  CharacterDesk desk;
  Orbit orbit;
};

Played begin(CharacterView& view, const recon::MotionGraph& graph, const PlayOptions& options) {
  Orbit front = view.orbit_for(static_cast<double>(options.width) / options.height);
  front.azimuth = -0.6;
  return {CharacterPlayer(graph, view.renderer().roots()), CharacterDesk(graph, front), front};
}

// The graph with what is done and wanted, drawn when that changes.
class StateMap {
 public:
  explicit StateMap(const recon::MotionGraph& graph) : graph_(graph) {}
  const cv::Mat& of(const CharacterPlayer& player) {
    if (const auto doing = player.doing() + " " + player.wanted(); doing != mapped_) {
      map_ = graph_map(graph_, player.doing(), player.wanted());
      mapped_ = doing;
    }
    return map_;
  }

 private:
  const recon::MotionGraph& graph_;
  cv::Mat map_;
  std::string mapped_;  // what the map shows
};

}  // namespace

CharacterPlayReport play_character(const std::filesystem::path& character, const recon::MotionGraph& graph,
                                   const PlayOptions& options) {
  const auto called = std::chrono::steady_clock::now();
  std::optional<Played> played;
  CharacterPlayReport report;
  PictureClock clock;
  StateMap map(graph);
  const auto play_in = [&](Display& window) {
    CharacterView view(character, graph);
    ClipLoader loader(character, graph);
    Overlay overlay;
    if (!played) {
      played.emplace(begin(view, graph, options));
      report.load_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - called).count();
    }
    auto& [player, desk, orbit] = *played;
    view.orbit() = orbit;
    for (double since = 1e9; window.is_open() && !desk.ended() && !options.stop.stop_requested() &&
                             (options.picture_limit == 0 || report.pictures < options.picture_limit);) {
      const double passed = clock.begin();
      for (const auto& loaded : loader.take()) view.renderer().adopt(loaded.clip, loaded.frame, loaded.image);
      const auto& seen = desk.go_on(player, std::min(passed, 0.1));
      if (desk.follows()) view.follow(seen, since);
      since = passed;
      if (window.width() > 0 && window.height() > 0) {
        window.bind();
        view.draw(seen, window.width(), window.height(), {kDarkRoom, true, desk.draw(), clock.coarser()});
        overlay.draw(text_card(desk.lines(player, clock.told())), 12, 12, window.width(), window.height());
        const auto& states = map.of(player);
        if (desk.shows_map())
          overlay.draw(states, window.width() - states.cols - 12, 12, window.width(), window.height());
      }
      orbit = view.orbit();
      window.present();
      ++report.pictures;
      desk.apply(window.take_input(), player, view.orbit(), passed);
      view.shift(desk.take_shift());
      if (desk.take_home()) view.centre();
      clock.end();
    }
  };
  report.lost_contexts = with_display({.window = {.title = "rotunda",
                                                  .width = options.width,
                                                  .height = options.height,
                                                  .fullscreen = options.fullscreen}},
                                      play_in);
  report.seconds = clock.seconds();
  return report;
}

}  // namespace rotunda::playback
