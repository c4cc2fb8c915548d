#pragma once
// What the frames before and after a frame of a take hold of the performer (capture/matte/chroma_key.h). Each frame is
// keyed once for its two neighbours and kept until they are through.
#include <future>
#include <map>
#include <mutex>
#include <vector>

#include "capture/take/take_reader.h"
#include "recon/frame_reconstruction.h"

namespace rotunda::recon {

// Lives no longer than what it is made of. Safe from many threads; the same result on any number of them.
class NeighbourMattes {
 public:
  // `jobs`: how many frames are worked on at once.
  NeighbourMattes(const capture::TakeReader& take, const StudioViews& studio, StageClock& clock, std::size_t jobs)
      : take_(take), studio_(studio), clock_(clock), most_kept_(jobs + 4) {}

  // A slot per camera of the take; an empty picture where a neighbour is missing. Nothing at all at live quality, and
  // for the take's first and last frame. Throws CorruptData as the reader does.
  std::vector<cv::Mat> held(std::size_t frame);

 private:
  using Mattes = std::vector<capture::Matte>;  // a slot per camera of the take
  std::shared_future<Mattes> mattes_of(std::size_t frame);
  Mattes key(std::size_t frame) const;

  const capture::TakeReader& take_;
  const StudioViews& studio_;
  StageClock& clock_;
  std::size_t most_kept_;
  std::mutex mutex_;
  std::map<std::size_t, std::shared_future<Mattes>> kept_;  // by frame
};

}  // namespace rotunda::recon
