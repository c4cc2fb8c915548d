#pragma once
// Embedded deformation (Sumner, Schmid, Pauly 2007): a surface moved by the rigid motions of a few nodes spread over
// it. Nodes are farthest points by geodesics on the surface at rest; a vertex follows its four nearest with weights (1
// - d / d5)^2, d5 the distance to its fifth. World frame, metres.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// Of one node g: x goes to rotation (x - g) + g + shift.
struct NodeMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
};

struct DeformationGraph {
  static constexpr std::size_t kNearest = 4;
  struct Binding {
    std::array<std::uint32_t, kNearest> node{};
    std::array<double, kNearest> weight{};  // sum 1
  };
  std::vector<Eigen::Vector3d> nodes;                          // at rest
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;  // first < second; nodes that move some vertex together
  std::vector<Binding> bindings;                               // one a vertex
};

// Of a closed mesh; as many nodes as asked, or as vertices.
DeformationGraph deformation_graph(const TriangleMesh& mesh, std::size_t nodes);

Eigen::Vector3d moved(const DeformationGraph& graph, const std::vector<NodeMotion>& motion,
                      const DeformationGraph::Binding& binding, const Eigen::Vector3d& point);
// Not normalised.
Eigen::Vector3d turned(const std::vector<NodeMotion>& motion, const DeformationGraph::Binding& binding,
                       const Eigen::Vector3d& normal);

// Neighbours and the lengths of the ways to them: along edges, and across each edge to the vertex opposite, unfolded.
// Way lengths on such a graph come nearer to geodesics than along edges alone.
class GeodesicWays {
 public:
  struct Way {
    std::uint32_t to;
    double length;
  };
  explicit GeodesicWays(const TriangleMesh& mesh);
  const std::vector<Way>& from(std::uint32_t vertex) const { return ways_[vertex]; }
  std::size_t size() const { return ways_.size(); }

  // Shortest ways from the sources to every vertex (Dijkstra 1959); `distances` are only ever lowered.
  void spread(const std::vector<std::uint32_t>& sources, std::vector<double>& distances) const;

 private:
  std::vector<std::vector<Way>> ways_;
};

}  // namespace rotunda::recon
