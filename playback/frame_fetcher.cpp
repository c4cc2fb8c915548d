#include "playback/frame_fetcher.h"

#include <pthread.h>

#include <algorithm>

namespace rotunda::playback {
namespace {

int frames_that_fit(const recon::GeometryVideoHeader& header, const FrameFetcherOptions& options) {
  const auto texels = [](int level) { return (std::size_t{1} << (2 * level)) + (std::size_t{2} << level) + 1; };
  const std::size_t bytes = texels(options.level > 0 ? options.level : header.level) * sizeof(Eigen::Vector3f) +
                            texels(header.colour_level) * sizeof(recon::Colour);
  constexpr std::size_t kFewest = 4;
  return static_cast<int>(std::clamp(options.memory / bytes, kFewest, header.root_path.size() + kFewest));
}

}  // namespace

FrameFetcher::FrameFetcher(recon::GeometryVideoReader& video, const FrameFetcherOptions& options)
    : video_(video),
      level_(options.level > 0 ? options.level : video.header().level),
      frames_(video.frame_count()),
      ahead_(std::min(frames_, frames_that_fit(video.header(), options))),
      thread_([this](const std::stop_token& stop) { decode(stop); }) {
  pthread_setname_np(thread_.native_handle(), "decode");
}

FrameFetcher::Image FrameFetcher::found(int frame) const {
  if (const auto error = errors_.find(frame); error != errors_.end()) std::rethrow_exception(error->second);
  const auto image = images_.find(frame);
  return image != images_.end() ? image->second : nullptr;
}

FrameFetcher::Image FrameFetcher::ready(int frame) {
  const std::lock_guard lock(mutex_);
  wanted_ = frame;
  changed_.notify_all();
  return found(frame);
}

FrameFetcher::Image FrameFetcher::wait_for(int frame) {
  std::unique_lock lock(mutex_);
  wanted_ = frame;
  changed_.notify_all();
  changed_.wait(lock, [&] { return images_.count(frame) > 0 || errors_.count(frame) > 0; });
  return found(frame);
}

int FrameFetcher::next_missing() const {
  for (int i = 0; i < ahead_; ++i) {
    const int frame = (wanted_ + i) % frames_;
    if (images_.count(frame) == 0 && errors_.count(frame) == 0) return frame;
  }
  return -1;
}

void FrameFetcher::decode(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return next_missing() >= 0; })) {
    const int frame = next_missing();
    for (auto image = images_.begin(); image != images_.end();)  // those that lie behind make room
      image = (image->first - wanted_ + frames_) % frames_ < ahead_ ? std::next(image) : images_.erase(image);
    lock.unlock();
    Image image;
    std::exception_ptr error;
    try {
      image = std::make_shared<const recon::GeometryImage>(video_.read(frame, {.level = level_, .drawn = true}));
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    if (error)
      errors_[frame] = error;
    else
      images_[frame] = std::move(image);
    changed_.notify_all();
    if (stop.stop_requested()) return;
  }
}

}  // namespace rotunda::playback
