#pragma once
// One Gauss-Newton step of an embedded deformation: nodes are turned and shifted so that pulled vertices come nearer to
// where they are pulled while neighbouring nodes move as one rigid body as far as they can,
//     sum_v (x_v - p_v)' A_v (x_v - p_v) + k sum_edges rho(|R_a (g_b - g_a) + g_a + t_a - g_b - t_b|) ,
// rho(r) with the weight 1 / (1 + r^2 / s^2): where skin bends it may stretch, and only there. Solved by conjugate
// gradients with the 6 x 6 blocks of the diagonal as preconditioner. Metres. Deterministic.
#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "recon/track/deformation_graph.h"

namespace rotunda::recon {

struct Pull {
  std::uint32_t vertex = 0;
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  // A
  Eigen::Vector3d force = Eigen::Vector3d::Zero();      // A (p - x), x where the vertex is now
};

struct GraphStepOptions {
  double rigidity = 5.0;      // k, against pulls whose A has an eigenvalue of about 1
  double give = 0.010;        // s, metres
  double damping = 1e-3;      // of the diagonal
  int solver_steps = 60;      // of conjugate gradients, at most
  double largest_turn = 0.6;  // radians a step
};

class GraphSolver {
 public:
  // Keeps a reference. rest: of the vertices that may be pulled, by their number in the graph's bindings.
  GraphSolver(const DeformationGraph& graph, const std::vector<Eigen::Vector3d>& rest);

  void step(std::vector<NodeMotion>& motion, const std::vector<Pull>& pulls, const GraphStepOptions& options);

 private:
  using Block = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  std::size_t block(std::uint32_t a, std::uint32_t b) const;
  void add_pull(const Pull& pull, const std::vector<NodeMotion>& motion);
  void add_edge(std::uint32_t a, std::uint32_t b, const std::vector<NodeMotion>& motion,
                const GraphStepOptions& options);
  void multiply(const std::vector<Vector6>& x, std::vector<Vector6>& y) const;
  std::vector<Vector6> solve(const GraphStepOptions& options) const;

  const DeformationGraph& graph_;
  const std::vector<Eigen::Vector3d>& rest_;
  std::vector<std::size_t> first_;     // of each row's blocks
  std::vector<std::uint32_t> column_;  // >= row, ascending
  std::vector<Block> blocks_;          // upper half
  std::vector<Vector6> right_;
};

}  // namespace rotunda::recon
