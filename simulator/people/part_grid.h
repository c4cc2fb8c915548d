#pragma once
// Which parts of a body matter in which cell of space, so that a distance is asked of few of them. Metres, person
// frame.
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace rotunda::simulator {

class PartGrid {
 public:
  // The parts, in rising order, that matter in a ball; nothing: far from all of them.
  using PartsIn = std::function<std::vector<std::uint16_t>(const Eigen::Vector3d& middle, double radius)>;

  PartGrid() = default;
  PartGrid(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double cell, const PartsIn& parts_in);
  // Nothing outside the grid and far from all parts.
  std::span<const std::uint16_t> parts_at(const Eigen::Vector3d& p) const;

 private:
  std::optional<std::size_t> cell_at(const Eigen::Vector3d& p) const;

  Eigen::Vector3d low_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i cells_ = Eigen::Vector3i::Zero();
  double cell_ = 1.0;
  std::vector<std::uint32_t> first_;  // of each cell in `parts_`, and one beyond the last
  std::vector<std::uint16_t> parts_;
};

}  // namespace rotunda::simulator
