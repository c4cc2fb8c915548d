#include "playback/render/take_pictures.h"

#include "recon/take_plates.h"

namespace rotunda::playback {

TakePictures::TakePictures(const std::filesystem::path& take, const std::optional<std::filesystem::path>& calibration)
    : take_(take), studio_(recon::read_take_studio(take_, calibration)) {
  recon::learn_missing_plates(take_, studio_.views);
}

std::span<const SourceView> TakePictures::of(std::size_t frame) {
  if (shown_ == frame) return views_;
  recon::StageClock clock;
  shown_.reset();
  views_ = source_views(recon::key_frame(take_.read(frame), studio_.views, recon::given_mattes(take_, frame), clock));
  shown_ = frame;
  return views_;
}

std::size_t TakePictures::bytes_a_frame() const {
  std::size_t pixels = 0;
  for (const auto& camera : studio_.views.cameras)
    pixels += static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  return sizeof(cv::Vec4b) * pixels;
}

}  // namespace rotunda::playback
