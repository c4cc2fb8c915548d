#pragma once
// Memory for images copied out of a driver's buffers: lent to whoever reads the pixels, used again when the last reader
// lets go. Safe from several threads.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace rotunda::capture {

class PixelPool : public std::enable_shared_from_this<PixelPool> {
 public:
  // Pieces of `bytes` each, `at_most` of them. Made as shared_ptr: what is lent keeps the pool.
  PixelPool(std::size_t bytes, std::size_t at_most) : bytes_(bytes), at_most_(at_most) {}

  std::shared_ptr<std::uint8_t> take();  // null when all are lent
  std::size_t piece_bytes() const { return bytes_; }

 private:
  using Piece = std::unique_ptr<std::uint8_t[]>;
  void give_back(std::uint8_t* piece);

  const std::size_t bytes_;
  const std::size_t at_most_;
  std::mutex mutex_;
  std::vector<Piece> free_;
  std::size_t made_ = 0;
};

}  // namespace rotunda::capture
