#pragma once
// A person's skeleton through a take: what motion capture made of it, without what it found out on the way. World,
// metres.
#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "recon/body/captured_motion.h"

namespace rotunda::recon {

struct BodyTrack {
  BodyTemplate body;
  std::size_t first_frame = 0;             // of the take
  std::vector<std::optional<Pose>> poses;  // a frame each; none where the person was lost

  std::optional<Pose> pose(std::size_t frame) const;  // of the take; none beyond the track
};

// Poses without the fit's noise: of every joint and the root, a cubic over seven frames read at each
// (video/temporal_filter.h), as far as that is no further away than noise may be. Gaps of lost frames are bridged
// first, on the shortest way from the last pose to the next; before the first and after the last the nearest one
// stands. Nothing is filtered across a cut, where somebody would have to jump half a metre or turn by 70 degrees within
// a frame. As it was if no frame has a pose.
BodyTrack steadied(const BodyTrack& track);

BodyTrack track_of(const CapturedMotion& motion);

// What write_joints_json wrote (captured_motion.h). Throws std::system_error (no such file), CorruptData.
BodyTrack read_joints_json(const std::filesystem::path& file);

}  // namespace rotunda::recon
