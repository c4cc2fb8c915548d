#pragma once
// Which triangle each sample of a band of a picture sees: a depth buffer that keeps numbers instead of colours, so that
// only what is seen is shaded (Burns and Hunt, "The visibility buffer", 2013). A band is small enough for the cache.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace rotunda::simulator {

// A corner: samples from the band's upper left edge (the first sample's centre is 0.5, 0.5), and 1 / depth.
struct SampleCorner {
  float x, y, nearness;
};
using SampleTriangle = std::array<SampleCorner, 3>;

// Twice the area; negative if its corners run the other way round. y runs down.
float doubled_area(const SampleTriangle& triangle);

// Weights of the corners at a sample place, true in space: perspective undone.
Eigen::Vector3f weights_at(const SampleTriangle& triangle, float x, float y);

class SampleRaster {
 public:
  SampleRaster(int columns, int rows);
  // `number`: not 0. Either way round.
  void add(const SampleTriangle& triangle, std::uint32_t number);
  std::uint32_t at(int column, int row) const {  // 0: nothing
    return numbers_[static_cast<std::size_t>(row * columns_ + column)];
  }
  // Samples of a row that may be covered: [first, last).
  std::array<int, 2> touched(int row) const { return touched_[static_cast<std::size_t>(row)]; }
  void clear();

 private:
  int columns_, rows_;
  std::vector<float> nearest_;
  std::vector<std::uint32_t> numbers_;
  std::vector<std::array<int, 2>> touched_;
};

}  // namespace rotunda::simulator
