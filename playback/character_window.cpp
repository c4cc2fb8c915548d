#include "playback/character_window.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "playback/character_desk.h"
#include "playback/character_view.h"
#include "playback/clip_loader.h"
#include "playback/display/window.h"
#include "playback/graph_map.h"
#include "playback/picture_clock.h"
#include "playback/render/overlay.h"
#include "playback/render/stage.h"

namespace rotunda::playback {

CharacterPlayReport play_character(const std::filesystem::path& character, const recon::MotionGraph& graph,
                                   const PlayOptions& options) {
  const auto called = std::chrono::steady_clock::now();
  Window window(
      {.title = "rotunda", .width = options.width, .height = options.height, .fullscreen = options.fullscreen});
  CharacterView view(character, graph);
  CharacterPlayer player(graph, view.renderer().roots());
  ClipLoader loader(character, graph);
  Overlay overlay;
  cv::Mat map;
  std::string mapped;  // what the map shows
  Orbit front = view.orbit_for(static_cast<double>(options.width) / options.height);
  front.azimuth = -0.6;
  view.orbit() = front;
  CharacterDesk desk(graph, front);
  CharacterPlayReport report{.load_seconds =
                                 std::chrono::duration<double>(std::chrono::steady_clock::now() - called).count()};
  PictureClock clock;
  while (window.is_open() && !desk.ended() && !options.stop.stop_requested() &&
         (options.picture_limit == 0 || report.pictures < options.picture_limit)) {
    const double passed = clock.begin();
    for (const auto& loaded : loader.take()) view.renderer().adopt(loaded.clip, loaded.frame, loaded.image);
    const auto& seen = desk.go_on(player, std::min(passed, 0.1));
    if (desk.follows()) view.follow(seen, report.pictures == 0 ? 1e9 : passed);
    if (const auto doing = player.doing() + " " + player.wanted(); doing != mapped) {
      map = graph_map(graph, player.doing(), player.wanted());
      mapped = doing;
    }
    if (window.width() > 0 && window.height() > 0) {
      window.bind();
      view.draw(seen, window.width(), window.height(), {kDarkRoom, true, desk.draw(), clock.coarser()});
      overlay.draw(text_card(desk.lines(player, clock.told())), 12, 12, window.width(), window.height());
      if (desk.shows_map()) overlay.draw(map, window.width() - map.cols - 12, 12, window.width(), window.height());
    }
    window.present();
    ++report.pictures;
    desk.apply(window.take_input(), player, view.orbit(), passed);
    view.shift(desk.take_shift());
    if (desk.take_home()) view.centre();
    clock.end();
  }
  report.seconds = clock.seconds();
  return report;
}

}  // namespace rotunda::playback
