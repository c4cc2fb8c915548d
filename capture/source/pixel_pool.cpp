#include "capture/source/pixel_pool.h"

#include <utility>

namespace rotunda::capture {

std::shared_ptr<std::uint8_t> PixelPool::take() {
  Piece piece;
  {
    const std::lock_guard lock(mutex_);
    if (free_.empty() && made_ >= at_most_) return nullptr;
    if (free_.empty()) {
      ++made_;
      free_.reserve(made_);  // so that giving back never has to allocate
    } else {
      piece = std::move(free_.back());
      free_.pop_back();
    }
  }
  if (!piece) piece.reset(new std::uint8_t[bytes_]);  // not set to zero: an image fills it
  return {piece.release(), [self = shared_from_this()](std::uint8_t* bytes) { self->give_back(bytes); }};
}

void PixelPool::give_back(std::uint8_t* piece) {
  const std::lock_guard lock(mutex_);
  free_.emplace_back(piece);
}

}  // namespace rotunda::capture
