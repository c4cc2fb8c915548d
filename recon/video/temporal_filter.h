#pragma once
// Noise of a sequence of surfaces, taken out along time without smearing motion: at each sample a cubic is fitted to
// seven frames (Savitzky, Golay 1964) and read at the frame itself; near the ends of a sequence the same seven frames
// serve. What would move a sample far is no noise but a map that slid between frames: the way w is taken times
// (1 - (w / limit)^2)^2, and not at all from the limit on (Beaton, Tukey 1974). A Gaussian in time would shrink fast
// swings by centimetres.
#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace rotunda::recon {

inline constexpr int kFilterFrames = 7;

// Weights of seven equidistant frames for the value of their cubic at frame `at` (0 to 6); their sum is 1.
std::array<double, kFilterFrames> filter_weights(int at);

// window: seven frames of equally many samples; `at`: which of them comes back filtered. limit: metres.
std::vector<Eigen::Vector3f> filtered(std::span<const std::vector<Eigen::Vector3f>, kFilterFrames> window, int at,
                                      float limit);

}  // namespace rotunda::recon
