#pragma once
// Boards in many pictures, side by side (oneTBB); the same result on any number of threads.
#include <stop_token>

#include "capture/calibration/calibrate.h"
#include "capture/calibration/missed_boards.h"

namespace rotunda::capture {

struct BoardSearch {
  std::vector<Sighting> sightings;    // by camera, then moment
  std::vector<CameraModel> sizes;     // name, width and height a camera; 0 x 0: no picture
  std::vector<int> pictures;          // a camera
  std::vector<std::string> troubles;  // pictures of another size than the camera's others
};

BoardSearch search_boards(const BoardPictures& pictures, const BoardDetector& detector, const CalibrateOptions& options,
                          const std::stop_token& stop);

// Every board whose pose is known, in every picture of its moment: found corners are fitted anew, missed ones sought.
// `cameras` are the state's, numbered as in the sightings; `source` says which of the pictures' cameras each is.
std::vector<Sighting> search_predicted(const BoardPictures& pictures, const BoardDetector& detector,
                                       const RigState& state, std::span<const Sighting> found,
                                       std::span<const std::size_t> source, double reach_px,
                                       const CalibrateOptions& options, const std::stop_token& stop);

}  // namespace rotunda::capture
