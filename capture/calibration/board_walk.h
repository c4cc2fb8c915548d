#pragma once
// A walk with the board as it happens: which pictures are worth keeping, what each camera still needs, when it is
// enough. Works on what the detector finds, without a calibration; numbers of cameras are the pictures'.
#include <string>
#include <vector>

#include "capture/calibration/bundle_adjustment.h"
#include "capture/calibration/calibration_result.h"

namespace rotunda::capture {

struct CameraNeed {
  std::string camera;
  int views = 0;
  ImageCoverage coverage;  // distances are not known yet
  int tied_moments = 0;    // boards kept that another camera saw at the same moment
  std::string needs;       // "6 more boards; upper left and right; with cam03 at once"; empty: nothing
};

class BoardWalk {
 public:
  // Name, width and height a camera.
  BoardWalk(std::vector<CameraModel> cameras, std::vector<Board> boards);

  // What was found at the next moment; true if it shows anything new to any camera and is kept (its sightings are
  // numbered so). Boards that were moving are left out.
  bool add(std::vector<Sighting> found);
  const std::vector<Sighting>& sightings() const { return kept_; }
  std::size_t moments() const { return moments_; }

  std::vector<CameraNeed> needs() const;
  bool is_enough() const;

 private:
  bool shows_something_new(const Sighting& sighting) const;

  std::vector<CameraModel> cameras_;
  std::vector<Board> boards_;
  std::vector<Sighting> kept_;
  std::size_t moments_ = 0;
};

}  // namespace rotunda::capture
