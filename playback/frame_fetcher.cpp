#include "playback/frame_fetcher.h"

#include <algorithm>

namespace rotunda::playback {
namespace {

// How many frames fit, a few at the least.
int frames_that_fit(std::size_t bytes_a_frame, std::size_t memory, int frames) {
  constexpr int kFewest = 4;
  const auto fit = std::min<std::size_t>(memory / std::max<std::size_t>(1, bytes_a_frame), std::size_t{1} << 30);
  return std::min(frames, std::max(kFewest, static_cast<int>(fit)));
}

std::size_t bytes_of(const recon::GeometryVideoHeader& header, int level) {
  const auto texels = [](int of) { return (std::size_t{1} << (2 * of)) + (std::size_t{2} << of) + 1; };
  return texels(level) * sizeof(Eigen::Vector3f) + texels(header.colour_level) * sizeof(recon::Colour);
}

int level_of(const recon::GeometryVideoReader& video, const FrameFetcherOptions& options) {
  return options.level > 0 ? options.level : video.header().level;
}

}  // namespace

FrameFetcher::FrameFetcher(recon::GeometryVideoReader& video, const FrameFetcherOptions& options)
    : ReadAhead(
          "decode", video.frame_count(),
          frames_that_fit(bytes_of(video.header(), level_of(video, options)), options.memory, video.frame_count()),
          [&video, level = level_of(video, options)](int frame) {
            return video.read(frame, {.level = level, .drawn = true});
          }) {}

PictureFetcher::PictureFetcher(std::shared_ptr<TakePictures> pictures, std::size_t first_frame, int frames,
                               std::size_t memory)
    : ReadAhead("key", frames, frames_that_fit(pictures->bytes_a_frame(), memory, frames),
                [pictures, first_frame](int frame) {
                  const auto views = pictures->of(first_frame + static_cast<std::size_t>(frame));
                  return std::vector<SourceView>(views.begin(), views.end());
                }) {}

}  // namespace rotunda::playback
