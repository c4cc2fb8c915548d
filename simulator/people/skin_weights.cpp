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
    rows[v][index(shape.place_of(mesh.positions[v].cast<double>()).joint)] = 1.0F;
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
  std::array<Eigen::Matrix<float, 3, 4>, kJoints> transforms;
  for (std::size_t j = 0; j < kJoints; ++j) transforms[j] = world_from_bind[j].matrix().topRows<3>().cast<float>();
  recon::TriangleMesh mesh = bind;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    Eigen::Matrix<float, 3, 4> blend = Eigen::Matrix<float, 3, 4>::Zero();
    for (std::size_t i = 0; i < 4; ++i) blend += weights[v].weight[i] * transforms[weights[v].joint[i]];
    mesh.positions[v] = blend * bind.positions[v].homogeneous();
  }
  recon::compute_normals(mesh);
  return mesh;
}

}  // namespace rotunda::simulator
