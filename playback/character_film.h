#pragma once
// A character's performance as a film: the commands of a script, an eye that follows and may go round. Deterministic:
// the same pictures every time. Needs a current GLES 3 context.
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

#include "playback/performance_script.h"
#include "playback/render/film_writer.h"
#include "playback/render/view_program.h"

namespace rotunda::playback {

struct CharacterFilmOptions {
  int width = 1280, height = 720;           // pixels
  PerformanceScript script;                 // no commands: the first state for script.seconds
  double turns = 0.0;                       // round the performer in the whole film
  double azimuth = -0.9, elevation = 0.2;   // where the film begins, radians
  std::optional<double> distance;           // of the eye, metres; not given: all of the performer is in the picture
  std::optional<recon::Colour> background;  // not given: alpha 0 where nothing is
  bool floor = true;                        // a floor with the performer's shadow
  DrawOptions draw;
  int supersample = 2;
  std::function<void(int done, int all)> progress;
  std::stop_token stop;
};

// The pictures drawn; fewer than all if it was asked to stop, then the film is not finished.
int render_character(const std::filesystem::path& character, const recon::MotionGraph& graph,
                     const CharacterFilmOptions& options, FilmWriter& film);

int picture_count(const PerformanceScript& script, double fps);

// How long the cycle of the graph's first state takes, seconds.
double first_cycle_seconds(const recon::MotionGraph& graph);

}  // namespace rotunda::playback
