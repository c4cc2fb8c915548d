#pragma once
// A count of exposures that never wraps, from the block ids of a GigE Vision stream: 1 to 65535 and round again, or 64
// bits wide (GigE Vision 2.0, 10.4: 0 is no block's id).
#include <cstdint>
#include <optional>

namespace rotunda::capture {

class ExposureCounter {
 public:
  // Ids may come a little out of order. Nothing for id 0.
  std::optional<std::uint64_t> count(std::uint64_t block_id);

 private:
  std::uint64_t latest_ = 0;  // unwrapped
};

}  // namespace rotunda::capture
