#pragma once
// A ColorChecker Classic (24 patches, 6 x 4) held in the volume: found by OpenCV's mcc module, its patches' light as
// samples for colour_match.h.
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/calibration/colour_match.h"

namespace rotunda::capture {

constexpr std::size_t kCardPatches = 24;  // row by row from dark skin to black

// The patches as made, linear sRGB under D65 (from X-Rite's 8-bit sRGB values).
const std::array<Eigen::Vector3d, kCardPatches>& card_colours();

// The patches' light in one picture (CV_8UC3, RGB): a mean over the middle of each; none where it is clipped or too
// dark to tell. Nothing if there is no card.
using CardColours = std::array<std::optional<Eigen::Vector3d>, kCardPatches>;
std::optional<CardColours> find_card(const cv::Mat& rgb);

struct CardSamples {
  std::vector<ColourSample> samples;  // place: moment * 24 + patch
  std::vector<KnownColour> known;
  std::vector<std::size_t> cards;  // found, by camera
  std::size_t pictures = 0;
  std::vector<std::string> problems;  // pictures that cannot be read
};

// DIR/<camera>/*.png|jpg; files of one name (without the ending) are one moment. Cameras are numbered by `names`; a
// camera without a folder has no pictures. Throws InvalidInput if DIR is no folder.
CardSamples card_samples(const std::filesystem::path& folder, std::span<const std::string> names);

}  // namespace rotunda::capture
