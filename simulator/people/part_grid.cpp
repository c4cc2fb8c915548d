#include "simulator/people/part_grid.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace rotunda::simulator {

using Eigen::Vector3d;

PartGrid::PartGrid(const Vector3d& low, const Vector3d& high, double cell, const PartsIn& parts_in)
    : low_(low), cells_(((high - low) / cell).array().ceil().cast<int>()), cell_(cell) {
  const auto count = static_cast<std::size_t>(cells_.prod());
  std::vector<std::vector<std::uint16_t>> in_cell(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const auto n = static_cast<int>(i);
    const Vector3d index(n % cells_.x(), n / cells_.x() % cells_.y(), n / cells_.x() / cells_.y());
    in_cell[i] = parts_in(low_ + cell * (index + Vector3d::Constant(0.5)), 0.5 * std::sqrt(3.0) * cell);
  });
  for (const auto& parts : in_cell) {
    first_.push_back(static_cast<std::uint32_t>(parts_.size()));
    parts_.insert(parts_.end(), parts.begin(), parts.end());
  }
  first_.push_back(static_cast<std::uint32_t>(parts_.size()));
}

std::optional<std::size_t> PartGrid::cell_at(const Vector3d& p) const {
  const Eigen::Array3d place = (p - low_).array() / cell_;
  if (!(place >= 0.0).all() || !(place < cells_.cast<double>().array()).all()) return std::nullopt;
  const Eigen::Array3i i = place.cast<int>();
  return static_cast<std::size_t>((i.z() * cells_.y() + i.y()) * cells_.x() + i.x());
}

std::span<const std::uint16_t> PartGrid::parts_at(const Vector3d& p) const {
  const auto cell = cell_at(p);
  if (!cell) return {};
  return std::span(parts_).subspan(first_[*cell], first_[*cell + 1] - first_[*cell]);
}

}  // namespace rotunda::simulator
