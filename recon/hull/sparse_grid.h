#pragma once
// A signed field (world units, positive inside the body) on a block-sparse regular grid: samples at
// origin + cell_size * (x, y, z), stored in blocks of 8^3 where the field is near or above zero. What is not stored
// is outside, with the value `outside()`. A sample is named by VoxelId = 512 * block + x + 8 y + 64 z within the block.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace rotunda::recon {

using VoxelId = std::uint32_t;
inline constexpr VoxelId kNoVoxel = 0xFFFFFFFFU;

class SignedGrid {
 public:
  static constexpr int kSide = 8;  // samples along a block's edge
  static constexpr int kBlockSize = kSide * kSide * kSide;
  static constexpr std::size_t kMaxBlocks = 1U << 20;  // 2 GiB of samples
  using Block = std::array<float, kBlockSize>;

  SignedGrid() = default;
  // `blocks` in units of whole blocks, each once; all samples start at `outside`, which must be negative.
  // Throws InvalidInput for more than kMaxBlocks or a cell size that is not positive.
  SignedGrid(const Eigen::Vector3d& origin, double cell_size, float outside, std::vector<Eigen::Vector3i> blocks);

  const Eigen::Vector3d& origin() const { return origin_; }
  double cell_size() const { return cell_size_; }
  float outside() const { return outside_; }
  std::size_t block_count() const { return blocks_.size(); }
  std::size_t voxel_count() const { return blocks_.size() * kBlockSize; }
  const Eigen::Vector3i& block(std::size_t index) const { return blocks_[index]; }
  Block& values(std::size_t block) { return values_[block]; }
  const Block& values(std::size_t block) const { return values_[block]; }

  float value(VoxelId id) const { return id == kNoVoxel ? outside_ : values_[id / kBlockSize][id % kBlockSize]; }
  void set_value(VoxelId id, float value) { values_[id / kBlockSize][id % kBlockSize] = value; }
  Eigen::Vector3i coordinates(VoxelId id) const;
  Eigen::Vector3d position(VoxelId id) const { return origin_ + cell_size_ * coordinates(id).cast<double>(); }
  VoxelId find(const Eigen::Vector3i& coordinates) const;  // kNoVoxel where nothing is stored
  // The sample one step away, each of dx, dy, dz in -1, 0, 1; kNoVoxel where nothing is stored.
  VoxelId neighbour(VoxelId id, int dx, int dy, int dz) const;
  // The 26 samples around, kNoVoxel where nothing is stored.
  template <class Visit>
  void for_each_neighbour(VoxelId id, const Visit& visit) const {
    for (int i = 0; i < 27; ++i)
      if (i != 13) visit(neighbour(id, i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
  }
  float sample(const Eigen::Vector3d& point_in_world) const;  // trilinear

 private:
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double cell_size_ = 1.0;
  float outside_ = -1.0F;
  std::vector<Eigen::Vector3i> blocks_;
  std::vector<Block> values_;
  std::vector<std::array<std::uint32_t, 27>> neighbours_;  // blocks around each block; kNoVoxel where none
  std::unordered_map<std::uint64_t, std::uint32_t> index_;
};

}  // namespace rotunda::recon
