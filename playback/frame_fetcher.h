#pragma once
// A take's frames made ahead of the window that shows them: its geometry video decoded (thread "decode"), its cameras'
// pictures keyed (thread "key"). Clips that fit the memory allowed are made once and kept; of longer ones a few frames.
#include <cstddef>
#include <memory>
#include <vector>

#include "playback/read_ahead.h"
#include "playback/render/take_pictures.h"
#include "recon/video/geometry_video.h"

namespace rotunda::playback {

struct FrameFetcherOptions {
  int level = 0;                              // of detail; 0: the video's own
  std::size_t memory = std::size_t{1} << 30;  // bytes
};

// The reader is the fetcher's alone until it is destroyed. Throws what the reader throws at the frame asked for.
class FrameFetcher : public ReadAhead<recon::GeometryImage> {
 public:
  explicit FrameFetcher(recon::GeometryVideoReader& video, const FrameFetcherOptions& options = {});
};

// Frame 0 is `first_frame` of the take; so are the video's, of `frames`. `pictures` are the fetcher's alone.
class PictureFetcher : public ReadAhead<std::vector<SourceView>> {
 public:
  PictureFetcher(std::shared_ptr<TakePictures> pictures, std::size_t first_frame, int frames,
                 std::size_t memory = std::size_t{1} << 30);
};

}  // namespace rotunda::playback
