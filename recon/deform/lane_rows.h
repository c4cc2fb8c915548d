#pragma once
// Rows of lanes (lane_kernels.h): 3 x lane_count() floats a vertex, aligned as the vector registers want it.
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

#include "recon/deform/lane_kernels.h"

namespace rotunda::recon {

class LaneRows {
 public:
  LaneRows() = default;
  explicit LaneRows(std::size_t rows) : size_(rows * stride()), values_(allocate(size_)) {}
  static std::size_t stride() { return 3 * lane_count(); }
  float* data() { return values_.get(); }
  float* row(std::size_t i) { return values_.get() + i * stride(); }
  std::size_t size() const { return size_; }

 private:
  static constexpr std::size_t kAlignment = 64;
  struct Free {
    void operator()(float* values) const { ::operator delete (values, std::align_val_t{kAlignment}); }
  };
  static float* allocate(std::size_t size) {
    return static_cast<float*>(::operator new (size * sizeof(float), std::align_val_t{kAlignment}));
  }

  std::size_t size_ = 0;
  std::unique_ptr<float, Free> values_;
};

}  // namespace rotunda::recon
