#include "recon/hull/sparse_grid.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

std::uint64_t key_of(const Eigen::Vector3i& block) {
  constexpr std::int64_t kBias = 1 << 20;
  const auto part = [](int c) { return static_cast<std::uint64_t>(c + kBias) & 0x1FFFFFU; };
  return part(block.x()) | (part(block.y()) << 21) | (part(block.z()) << 42);
}

int local_index(int x, int y, int z) {
  return (x & 7) | ((y & 7) << 3) | ((z & 7) << 6);
}

}  // namespace

SignedGrid::SignedGrid(const Eigen::Vector3d& origin, double cell_size, float outside,
                       std::vector<Eigen::Vector3i> blocks)
    : origin_(origin), cell_size_(cell_size), outside_(outside), blocks_(std::move(blocks)) {
  if (!(cell_size > 0.0) || !(outside < 0.0F)) throw InvalidInput("a grid needs a positive cell size");
  if (blocks_.size() > kMaxBlocks)
    throw InvalidInput(fmt::format("the surface takes more than {} blocks of 8^3 cells: use larger cells", kMaxBlocks));
  Block empty;
  empty.fill(outside);
  values_.assign(blocks_.size(), empty);
  index_.reserve(blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) index_[key_of(blocks_[b])] = static_cast<std::uint32_t>(b);
  neighbours_.resize(blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    for (int i = 0; i < 27; ++i) {
      const auto found = index_.find(key_of(blocks_[b] + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
      neighbours_[b][static_cast<std::size_t>(i)] = found == index_.end() ? kNoVoxel : found->second;
    }
}

Eigen::Vector3i SignedGrid::coordinates(VoxelId id) const {
  const int local = static_cast<int>(id % kBlockSize);
  return blocks_[id / kBlockSize] * kSide + Eigen::Vector3i(local & 7, (local >> 3) & 7, local >> 6);
}

VoxelId SignedGrid::find(const Eigen::Vector3i& c) const {
  const auto found = index_.find(key_of({c.x() >> 3, c.y() >> 3, c.z() >> 3}));
  if (found == index_.end()) return kNoVoxel;
  return found->second * kBlockSize + static_cast<VoxelId>(local_index(c.x(), c.y(), c.z()));
}

VoxelId SignedGrid::neighbour(VoxelId id, int dx, int dy, int dz) const {
  const int local = static_cast<int>(id % kBlockSize);
  const int x = (local & 7) + dx, y = ((local >> 3) & 7) + dy, z = (local >> 6) + dz;
  auto block = id / kBlockSize;
  if (((x | y | z) & ~7) != 0) {
    block = neighbours_[block][static_cast<std::size_t>((x >> 3) + 1 + 3 * ((y >> 3) + 1) + 9 * ((z >> 3) + 1))];
    if (block == kNoVoxel) return kNoVoxel;
  }
  return block * kBlockSize + static_cast<VoxelId>(local_index(x, y, z));
}

float SignedGrid::sample(const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d p = (point_in_world - origin_) / cell_size_;
  const Eigen::Vector3i base = p.array().floor().cast<int>();
  const Eigen::Vector3d f = p - base.cast<double>();
  double sum = 0.0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3i corner(i & 1, (i >> 1) & 1, i >> 2);
    double weight = 1.0;
    for (int k = 0; k < 3; ++k) weight *= corner[k] == 1 ? f[k] : 1.0 - f[k];
    sum += weight * static_cast<double>(value(find(base + corner)));
  }
  return static_cast<float>(sum);
}

}  // namespace rotunda::recon
