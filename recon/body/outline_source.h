#pragma once
// Frames in whose silhouettes motion capture finds a person: a take's (recon/take_outlines.h), or those that a sequence
// of surfaces casts (recon/video/surface_outlines.h).
#include <cstddef>
#include <string>

#include "recon/body/pose_equations.h"
#include "recon/stage_clock.h"

namespace rotunda::recon {

class OutlineSource {
 public:
  OutlineSource() = default;
  virtual ~OutlineSource() = default;
  OutlineSource(const OutlineSource&) = delete;
  OutlineSource& operator=(const OutlineSource&) = delete;

  virtual std::string name() const = 0;           // "take walk": what messages begin with
  virtual std::string where_to_look() const = 0;  // if nobody is found: a way to see the silhouettes
  virtual std::size_t frame_count() const = 0;
  virtual double fps() const = 0;
  // Of frame [0, frame_count()), from any thread. Throws as the source's files do.
  virtual FrameOutlines outlines(std::size_t frame) = 0;

  StageClock& clock() { return clock_; }

 protected:
  StageClock clock_;
};

}  // namespace rotunda::recon
