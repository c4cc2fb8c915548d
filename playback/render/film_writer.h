#pragma once
// Where drawn pictures go: an MP4 film (H.264, yuv420p, index first, so that a browser starts at once) or a folder of
// numbered PNG pictures with straight alpha. Pictures are CV_8UC4, red first, all of one size. Nothing half-made is
// left: the film takes its name in finish(), each PNG when it is whole.
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::playback {

struct FilmOptions {
  int width = 1280, height = 720;  // pixels; a film's are even
  double fps = 25.0;
  recon::Colour background{24, 26, 30};  // behind what is transparent, in a film only
  int quality = 18;                      // x264's constant rate factor: 0 lossless, 18 looks it, 51 worst
};

class FilmWriter {
 public:
  virtual ~FilmWriter() = default;
  virtual void write(const cv::Mat& rgba) = 0;  // throws InvalidInput for another size, std::system_error
  virtual void finish() = 0;
};

// By the name: "orbit.mp4" is a film, any name without an extension a folder (made if needed) of frame000000.png,
// frame000001.png, ... Throws InvalidInput for another extension or an odd film size, std::system_error if the disk
// refuses.
std::unique_ptr<FilmWriter> make_film_writer(const std::filesystem::path& path, const FilmOptions& options);

// CV_8UC3, RGB: the picture before a background.
cv::Mat over_background(const cv::Mat& rgba, const recon::Colour& background);

}  // namespace rotunda::playback
