#pragma once
// Colours that agree between cameras: from colours of the same places seen by several cameras, a 3x3 matrix for each
// that takes its linear light to the rig's. Places are whatever several cameras saw at one moment. Light that falls on
// a place is the same for all, so only cameras differ.
//
// Least squares over all cameras at once: sum over places p and cameras i of |C_i x_ip - mean_j C_j x_jp|^2, relative
// to the place's brightness, robust; the mean of all C_i is kept at the identity (the rig's colours are the mean
// camera's). C_i is pulled towards a mere gain a channel (exposure and white balance) as strongly as the colours seen
// leave it open: grey places alone give gains, colourful ones whole matrices.
#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace rotunda::capture {

struct ColourSample {
  std::size_t camera = 0, place = 0;
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();  // 0 to 1; neither clipped nor lost in noise
};

struct CameraColourMatch {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  // linear light of the rig from that of the camera
  std::size_t samples = 0;                               // at places that other cameras saw too
  // Root mean square distance to the mean of the other cameras at the same places, of 8-bit sRGB levels (all three
  // channels together, per channel), robust: a tenth of the farthest left out.
  double before = 0.0, after = 0.0;
  bool gains_only = false;  // the places were too grey for a matrix
};

struct ColourMatch {
  std::vector<CameraColourMatch> cameras;
  double before = 0.0, after = 0.0;  // over all cameras
  std::vector<std::string> advice;   // cameras that could not be matched, by number in `names`
};

// Throws InvalidInput if no place was seen by two cameras, or a sample names a camera that is not there. A camera that
// shares no place with the others (told in `advice`) keeps the identity.
ColourMatch match_colours(std::span<const std::string> names, std::span<const ColourSample> samples);

}  // namespace rotunda::capture
