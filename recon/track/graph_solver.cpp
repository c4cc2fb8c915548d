#include "recon/track/graph_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <set>

namespace rotunda::recon {
namespace {

using Row = Eigen::Matrix<double, 3, 6>;  // how a point moves with its node's turn and shift

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0;
  return m;
}

Row row_of(const Eigen::Vector3d& arm, double weight) {
  Row row;
  row << -weight * cross_matrix(arm), weight * Eigen::Matrix3d::Identity();
  return row;
}

}  // namespace

GraphSolver::GraphSolver(const DeformationGraph& graph, const std::vector<Eigen::Vector3d>& rest)
    : graph_(graph), rest_(rest) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs(graph.edges.begin(), graph.edges.end());
  for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) pairs.emplace(n, n);
  for (const auto& binding : graph.bindings)
    for (const auto a : binding.node)
      for (const auto b : binding.node)
        if (a < b) pairs.emplace(a, b);
  for (const auto& [a, b] : pairs) {
    while (first_.size() <= a) first_.push_back(column_.size());
    column_.push_back(b);
  }
  first_.push_back(column_.size());
  blocks_.resize(column_.size());
  right_.resize(graph.nodes.size());
}

std::size_t GraphSolver::block(std::uint32_t a, std::uint32_t b) const {
  const auto begin = column_.begin() + static_cast<long>(first_[a]),
             end = column_.begin() + static_cast<long>(first_[a + 1]);
  return static_cast<std::size_t>(std::lower_bound(begin, end, b) - column_.begin());
}

void GraphSolver::add_pull(const Pull& pull, const std::vector<NodeMotion>& motion) {
  const auto& binding = graph_.bindings[pull.vertex];
  std::array<Row, DeformationGraph::kNearest> rows;
  std::array<Row, DeformationGraph::kNearest> pulled;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto n = binding.node[k];
    rows[k] = row_of(motion[n].rotation * (rest_[pull.vertex] - graph_.nodes[n]), binding.weight[k]);
    pulled[k] = pull.stiffness * rows[k];
    right_[n] += rows[k].transpose() * pull.force;
  }
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t l = 0; l < rows.size(); ++l)
      if (binding.node[k] < binding.node[l] || k == l)
        blocks_[block(binding.node[k], binding.node[l])] += rows[k].transpose() * pulled[l];
}

void GraphSolver::add_edge(std::uint32_t a, std::uint32_t b, const std::vector<NodeMotion>& motion,
                           const GraphStepOptions& options) {
  const Eigen::Vector3d arm = motion[a].rotation * (graph_.nodes[b] - graph_.nodes[a]);
  const Eigen::Vector3d gap = arm + graph_.nodes[a] + motion[a].shift - graph_.nodes[b] - motion[b].shift;
  const double weight = options.rigidity / (1.0 + gap.squaredNorm() / (options.give * options.give));
  const Row of_a = row_of(arm, 1.0);
  Row of_b = Row::Zero();
  of_b.rightCols<3>() = -Eigen::Matrix3d::Identity();
  right_[a] -= weight * of_a.transpose() * gap;
  right_[b] -= weight * of_b.transpose() * gap;
  blocks_[block(a, a)] += weight * of_a.transpose() * of_a;
  blocks_[block(b, b)] += weight * of_b.transpose() * of_b;
  if (a < b)
    blocks_[block(a, b)] += weight * of_a.transpose() * of_b;
  else
    blocks_[block(b, a)] += weight * of_b.transpose() * of_a;
}

void GraphSolver::multiply(const std::vector<Vector6>& x, std::vector<Vector6>& y) const {
  for (auto& value : y) value.setZero();
  for (std::uint32_t a = 0; a < x.size(); ++a)
    for (auto i = first_[a]; i < first_[a + 1]; ++i) {
      const auto b = column_[i];
      y[a].noalias() += blocks_[i] * x[b];
      if (a != b) y[b].noalias() += blocks_[i].transpose() * x[a];
    }
}

std::vector<GraphSolver::Vector6> GraphSolver::solve(const GraphStepOptions& options) const {
  const auto count = right_.size();
  std::vector<Vector6> x(count, Vector6::Zero()), residual = right_, direction(count), product(count), eased(count);
  std::vector<Block> inverse(count);
  for (std::uint32_t n = 0; n < count; ++n) inverse[n] = blocks_[block(n, n)].ldlt().solve(Block::Identity());
  const auto dot = [](const std::vector<Vector6>& a, const std::vector<Vector6>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
    return sum;
  };
  double before = 0.0, begun = 0.0;
  for (int step = 0; step < options.solver_steps; ++step) {
    for (std::size_t n = 0; n < count; ++n) eased[n] = inverse[n] * residual[n];
    const double now = dot(residual, eased);
    if (step == 0) begun = now;
    if (!(now > 1e-8 * begun)) break;
    for (std::size_t n = 0; n < count; ++n)
      direction[n] = step == 0 ? eased[n] : Vector6(eased[n] + now / before * direction[n]);
    multiply(direction, product);
    const double length = now / dot(direction, product);
    for (std::size_t n = 0; n < count; ++n) {
      x[n] += length * direction[n];
      residual[n] -= length * product[n];
    }
    before = now;
  }
  return x;
}

void GraphSolver::step(std::vector<NodeMotion>& motion, const std::vector<Pull>& pulls,
                       const GraphStepOptions& options) {
  for (auto& block : blocks_) block.setZero();
  for (auto& value : right_) value.setZero();
  for (const auto& pull : pulls) add_pull(pull, motion);
  for (const auto& [a, b] : graph_.edges) {
    add_edge(a, b, motion, options);
    add_edge(b, a, motion, options);
  }
  for (std::uint32_t n = 0; n < motion.size(); ++n) {
    auto& own = blocks_[block(n, n)];
    own.diagonal() *= 1.0 + options.damping;
    own.diagonal().array() += 1e-9;
  }
  const auto change = solve(options);
  for (std::size_t n = 0; n < motion.size(); ++n) {
    const Eigen::Vector3d turn = change[n].head<3>();
    const double angle = turn.norm();
    if (!change[n].allFinite()) continue;
    if (angle > 0.0)
      motion[n].rotation = Eigen::AngleAxisd(std::min(angle, options.largest_turn), turn / angle) * motion[n].rotation;
    motion[n].shift += change[n].tail<3>();
  }
}

}  // namespace rotunda::recon
