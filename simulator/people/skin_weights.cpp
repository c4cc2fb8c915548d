#include "simulator/people/skin_weights.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "simulator/people/body_mesh.h"

namespace rotunda::simulator {
namespace {

using Row = std::array<float, kJoints>;
constexpr int kDiffusionSteps = 24;  // spreads by about sqrt(24) edges of 1 cm

std::vector<Row> hard_weights(const recon::TriangleMesh& mesh, const BodyShape& shape) {
  std::vector<Row> rows(mesh.positions.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t v) {
    rows[v].fill(0.0F);
    const BodyPlace place = shape.place_of(mesh.positions[v].cast<double>());
    const auto left = static_cast<float>(place.worn.left_thigh), right = static_cast<float>(place.worn.right_thigh);
    const bool hangs = left + right > 0.0F;
    rows[v][index(hangs ? Joint::pelvis : place.joint)] = 1.0F - left - right;
    rows[v][index(Joint::thigh_left)] += left;
    rows[v][index(Joint::thigh_right)] += right;
  });
  return rows;
}

void diffuse(std::vector<Row>& rows, const std::vector<std::vector<std::uint32_t>>& neighbours) {
  const auto before = rows;
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t v) {
    const auto count = static_cast<float>(neighbours[v].size());
    for (std::size_t j = 0; j < kJoints; ++j) {
      float sum = 0.0F;
      for (const auto n : neighbours[v]) sum += before[n][j];
      rows[v][j] = 0.5F * before[v][j] + 0.5F * sum / count;
    }
  });
}

SkinWeights strongest_four(const Row& row) {
  std::array<std::uint8_t, kJoints> order{};
  std::iota(order.begin(), order.end(), std::uint8_t{0});
  std::partial_sort(order.begin(), order.begin() + 4, order.end(),
                    [&](auto a, auto b) { return row[a] != row[b] ? row[a] > row[b] : a < b; });
  SkinWeights weights;
  float sum = 0.0F;
  for (std::size_t i = 0; i < 4; ++i) sum += row[order[i]];
  for (std::size_t i = 0; i < 4; ++i) {
    weights.joint[i] = order[i];
    weights.weight[i] = row[order[i]] / sum;
  }
  return weights;
}

// A rigid motion; blends of them stay rigid once normalised (Kavan, Collins, Zara, O'Sullivan 2008, eq. 2 to 4).
struct DualQuaternion {
  Eigen::Quaternionf real{0.0F, 0.0F, 0.0F, 0.0F}, dual{0.0F, 0.0F, 0.0F, 0.0F};

  DualQuaternion() = default;
  explicit DualQuaternion(const Eigen::Isometry3d& motion) {
    const Eigen::Quaterniond turn(motion.linear());
    const Eigen::Vector3d t = 0.5 * motion.translation();
    real = turn.cast<float>();
    dual = (Eigen::Quaterniond(0.0, t.x(), t.y(), t.z()) * turn).cast<float>();
  }
  void add(const DualQuaternion& other, float weight) {
    real.coeffs() += weight * other.real.coeffs();
    dual.coeffs() += weight * other.dual.coeffs();
  }
  Eigen::Vector3f carry(const Eigen::Vector3f& p) const {
    const float length = real.norm();
    const Eigen::Quaternionf turn(real.coeffs() / length), shift(dual.coeffs() / length);
    const Eigen::Vector3f t = 2.0F * (turn.w() * shift.vec() - shift.w() * turn.vec() + turn.vec().cross(shift.vec()));
    return turn._transformVector(p) + t;
  }
};

}  // namespace

std::vector<SkinWeights> skin_weights(const recon::TriangleMesh& mesh, const BodyShape& shape) {
  auto rows = hard_weights(mesh, shape);
  const auto neighbours = neighbours_of(mesh);
  for (int step = 0; step < kDiffusionSteps; ++step) diffuse(rows, neighbours);
  std::vector<SkinWeights> weights(rows.size());
  std::transform(rows.begin(), rows.end(), weights.begin(), strongest_four);
  return weights;
}

recon::TriangleMesh skinned(const recon::TriangleMesh& bind, const std::vector<SkinWeights>& weights,
                            const JointTransforms& world_from_bind) {
  std::array<DualQuaternion, kJoints> joints;
  for (std::size_t j = 0; j < kJoints; ++j) joints[j] = DualQuaternion(world_from_bind[j]);
  recon::TriangleMesh mesh = bind;
  tbb::parallel_for(std::size_t{0}, mesh.positions.size(), [&](std::size_t v) {
    const auto& [joint, weight] = weights[v];
    const DualQuaternion& first = joints[joint[0]];
    DualQuaternion blend;
    for (std::size_t i = 0; i < 4; ++i) {
      const DualQuaternion& other = joints[joint[i]];
      blend.add(other, first.real.dot(other.real) < 0.0F ? -weight[i] : weight[i]);
    }
    mesh.positions[v] = blend.carry(bind.positions[v]);
  });
  recon::compute_normals(mesh);
  return mesh;
}

}  // namespace rotunda::simulator
