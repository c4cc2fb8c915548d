#pragma once
// A take's frames as a character wants them: the part without jumps, in the common lattice. Private to recon/motion.
#include <string>
#include <vector>

#include "recon/motion/character.h"
#include "recon/motion/clip_shape.h"

namespace rotunda::recon {

class ClipSource {
 public:
  // Finds the longest part in which nobody leaps farther in a frame than people do.
  explicit ClipSource(const CharacterTake& take);

  const CharacterTake& take() const { return take_; }
  const GeometryVideoHeader& header() const { return video_.header(); }
  int first() const { return first_; }
  int end() const { return end_; }  // one past the last, of the video
  int frame_count() const { return end_ - first_; }

  GeometryImage read(int frame);  // from 0
  ClipShape shape();              // at level 7 or the video's

 private:
  CharacterTake take_;
  GeometryVideoReader video_;
  int first_ = 0, end_ = 0;
};

// Throws InvalidInput for takes of different people, and for takes whose lattices do not correspond sample by sample.
void check_lattices(const std::vector<ClipSource>& sources, const std::vector<ClipShape>& shapes);

}  // namespace rotunda::recon
