#pragma once
// A performer seen by an eye that goes round: the film `rotunda render --orbit` makes of a geometry video. The eye
// follows over the floor. Needs a current GLES 3 context.
#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

#include "playback/performer_place.h"
#include "playback/render/film_writer.h"
#include "playback/render/frame_painter.h"
#include "playback/render/view_program.h"
#include "recon/video/geometry_video.h"

namespace rotunda::playback {

struct OrbitFilmOptions {
  int width = 1280, height = 720;           // pixels
  int pictures = 0;                         // in the film; 0: one for each frame of the video, which else repeats
  int first_frame = 0;                      // of the video, counted from 0
  int last_frame = -1;                      // one past the last; -1: to the end
  double turns = 1.0;                       // round the performer in the whole film; negative: clockwise from above
  double azimuth = 0.0, elevation = 0.15;   // where the film begins, radians
  std::optional<double> distance;           // of the eye, metres; not given: all of the performer is in the picture
  std::optional<recon::Colour> background;  // not given: alpha 0 where nothing is
  DrawOptions draw;
  int supersample = 2;  // each picture is drawn so many times as large, then averaged: 1 to 4
  std::function<void(int done, int all)> progress;  // after each picture
  std::stop_token stop;
};

// The pictures drawn: all of them and the film is finished, or fewer if it was asked to stop; then the film is not
// finished, and closing its writer leaves nothing. Throws InvalidInput for an empty range or a size that cannot be.
int render_orbit(recon::GeometryVideoReader& video, const OrbitFilmOptions& options, FilmWriter& film);
// The same drawn by others, side by side: the film is so many times as wide as `options.width`; `options.draw` goes
// unused.
int render_orbit(const PerformerPath& path, const std::vector<FramePainter*>& painters, const OrbitFilmOptions& options,
                 FilmWriter& film);

// A picture drawn `factor` times too large, averaged; straight alpha stays straight.
cv::Mat reduce(const cv::Mat& rgba, int factor);

}  // namespace rotunda::playback
