#pragma once
// Where motion capture starts: a person found in one frame without anything known, whatever the pose, as long as it is
// upright. World, metres, z up.
#include <optional>
#include <string>
#include <vector>

#include "recon/body/pose_fit.h"

namespace rotunda::recon {

// What a coarse visual hull says: how tall, where, how upright.
struct BodyExtent {
  Eigen::Vector3d centre;  // of the hull's volume
  double floor = 0.0;      // its lowest point
  double height = 0.0;     // from there to the highest
  double lean = 0.0;       // of its main axis from the vertical, radians
  bool is_upright() const;
};
// Nothing if fewer than two views see anybody or their silhouettes have nothing in common.
std::optional<BodyExtent> body_extent(const FrameOutlines& frame);

// A frame's person, from eight ways of standing and two of holding the arms; the best by both contours. The template's
// measures are solved along unless they are `known`. Nothing if the frame is not upright or nothing fits.
struct BodyStart {
  BodyTemplate body;
  PoseFit fit;
};
std::optional<BodyStart> start_body(const FrameOutlines& frame, const std::optional<BodyTemplate>& known);

bool fits_well(const BodyStart& start);  // most of the outlines is explained

// Which of the starts, found in several frames of one person, to go by. A crouch or a leap makes another body than the
// performer's fit: of those that fit well (if there are any) and agree on the performer's height, the one that fits
// best. Nothing if none fits at all.
std::optional<std::size_t> most_credible(const std::vector<BodyStart>& starts);

// The poses it tries, for a body of known measures; also where tracking starts anew.
std::vector<Pose> standing_poses(const BodyTemplate& body, const BodyExtent& extent);

}  // namespace rotunda::recon
