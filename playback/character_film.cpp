#include "playback/character_film.h"

#include <numbers>

#include "config/errors.h"
#include "playback/character_player.h"
#include "playback/character_view.h"
#include "playback/render/orbit_film.h"

namespace rotunda::playback {

double first_cycle_seconds(const recon::MotionGraph& graph) {
  return graph.state(graph.start).period() / graph.fps;
}

int picture_count(const PerformanceScript& script, double fps) {
  return std::max(1, static_cast<int>(std::lround(script.seconds * fps)));
}

int render_character(const std::filesystem::path& character, const recon::MotionGraph& graph,
                     const CharacterFilmOptions& options, FilmWriter& film) {
  if (options.supersample < 1 || options.supersample > 4 || options.width < 1 || options.height < 1)
    throw InvalidInput("a film needs a size, and is drawn 1 to 4 times as large");
  const int all = picture_count(options.script, graph.fps);
  const int width = options.width * options.supersample, height = options.height * options.supersample;
  const RenderTarget target(width, height);
  CharacterView view(character, graph);
  CharacterPlayer player(graph, view.renderer().roots());
  Orbit& orbit = view.orbit();
  orbit = view.orbit_for(static_cast<double>(options.width) / options.height);
  if (options.distance) orbit.distance = *options.distance;
  orbit.azimuth = options.azimuth;
  orbit.elevation = options.elevation;
  std::size_t next = 0;
  for (int picture = 0; picture < all; ++picture) {
    if (options.stop.stop_requested()) return picture;
    const double seconds = picture / graph.fps;
    for (; next < options.script.commands.size() && options.script.commands[next].at <= seconds + 1e-9; ++next)
      player.command(options.script.commands[next].command);
    if (picture > 0) player.advance(1.0 / graph.fps);
    view.follow(player.appearance(), picture == 0 ? 1e9 : 1.0 / graph.fps);
    target.bind();
    view.draw(player.appearance(), width, height, {options.background, options.floor, options.draw});
    film.write(reduce(target.read_rgba(), options.supersample));
    orbit.turn(2.0 * std::numbers::pi * options.turns / all, 0.0);
    if (options.progress) options.progress(picture + 1, all);
  }
  film.finish();
  return all;
}

}  // namespace rotunda::playback
