#pragma once
// Decodes a geometry video ahead of whoever shows it, in one thread of its own ("decode"). Clips that fit the memory
// allowed are decoded once and kept; longer ones keep a few frames ahead. Frames follow each other in a ring.
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "recon/video/geometry_video.h"

namespace rotunda::playback {

struct FrameFetcherOptions {
  int level = 0;                              // of detail; 0: the video's own
  std::size_t memory = std::size_t{1} << 30;  // bytes
};

class FrameFetcher {
 public:
  using Image = std::shared_ptr<const recon::GeometryImage>;

  // The reader is the fetcher's alone until it is destroyed.
  explicit FrameFetcher(recon::GeometryVideoReader& video, const FrameFetcherOptions& options = {});

  // Frame `frame` if it is decoded, else nothing; decoding goes on from there.
  Image ready(int frame);
  // Waits for it. Both throw what the reader threw at that frame.
  Image wait_for(int frame);

 private:
  void decode(const std::stop_token& stop);
  int next_missing() const;  // -1: all that is wanted is there
  Image found(int frame) const;

  recon::GeometryVideoReader& video_;
  const int level_, frames_, ahead_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<int, Image> images_;
  std::map<int, std::exception_ptr> errors_;
  int wanted_ = 0;
  std::jthread thread_;  // last: the first to end
};

}  // namespace rotunda::playback
