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

  // The longest part without a jump within the surfaces, which correspond: a frame whose step is three times those
  // beside it and more than people can do. `shape` is cut alike.
  void cut_jumps(ClipShape& shape);
  GeometryImage read(int frame);  // from 0
  ClipShape shape();              // at level 7 or the video's

 private:
  CharacterTake take_;
  GeometryVideoReader video_;
  int first_ = 0, end_ = 0;
};

// Throw InvalidInput for takes of different people, and for takes whose lattices do not correspond.
void check_people(const std::vector<ClipSource>& sources, const std::vector<ClipShape>& shapes);
void check_lattices(const std::vector<ClipSource>& sources, const std::vector<ClipShape>& shapes);

}  // namespace rotunda::recon
