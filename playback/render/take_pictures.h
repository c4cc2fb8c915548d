#pragma once
// The pictures of a take, keyed and ready to be seen from elsewhere (source_view.h), frame by frame. The last frame's
// are kept, so that several painters of one moment key it once.
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "capture/take/take_reader.h"
#include "playback/render/source_view.h"
#include "recon/take_studio.h"

namespace rotunda::playback {

class TakePictures {
 public:
  // `calibration`: instead of the take's own. Throws what reading and keying a take throws (take_studio.h,
  // take_plates.h).
  TakePictures(const std::filesystem::path& take, const std::optional<std::filesystem::path>& calibration);
  // Of a frame by its number in the take; empty if not a single picture shows anybody. Lent until the next call.
  std::span<const SourceView> of(std::size_t frame);
  std::size_t bytes_a_frame() const;  // of all views, at most

 private:
  capture::TakeReader take_;
  recon::TakeStudio studio_;
  std::optional<std::size_t> shown_;
  std::vector<SourceView> views_;
};

}  // namespace rotunda::playback
