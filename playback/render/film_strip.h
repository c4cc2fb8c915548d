#pragma once
// A film at one glance: moments at even distances of time side by side in one PNG picture, row by row, opaque.
#include <vector>

#include "playback/render/film_writer.h"

namespace rotunda::playback {

struct FilmStripOptions {
  int width = 240, height = 360;          // of a moment, pixels
  int pictures = 1;                       // of the whole film
  int moments = 10;                       // the first and the last picture are among them, if there is more than one
  recon::Colour background{24, 26, 30};  // behind what is transparent
};

// Where the moments are in the film, ascending; fewer if it has fewer pictures.
std::vector<int> moments_of(int pictures, int moments);

// The picture is there when finish() returns. Throws as make_film_writer does, and InvalidInput for no moment at all.
std::unique_ptr<FilmWriter> make_film_strip(const std::filesystem::path& file, const FilmStripOptions& options);

}  // namespace rotunda::playback
