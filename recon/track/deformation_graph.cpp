#include "recon/track/deformation_graph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <tuple>

namespace rotunda::recon {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

std::vector<std::uint32_t> farthest_points(const GeodesicWays& ways, std::size_t count) {
  std::vector<double> distances(ways.size(), kFar);
  std::vector<std::uint32_t> points{0};
  ways.spread(points, distances);
  points = {static_cast<std::uint32_t>(std::max_element(distances.begin(), distances.end()) - distances.begin())};
  std::fill(distances.begin(), distances.end(), kFar);
  while (true) {
    ways.spread({points.back()}, distances);
    if (points.size() >= std::min(count, ways.size())) return points;
    points.push_back(
        static_cast<std::uint32_t>(std::max_element(distances.begin(), distances.end()) - distances.begin()));
  }
}

struct NearNode {
  double distance;
  std::uint32_t node;
};

// The nearest nodes of every vertex, nearest first, from one front that all nodes spread together.
std::vector<std::vector<NearNode>> nearest_nodes(const GeodesicWays& ways, const std::vector<std::uint32_t>& sources,
                                                 std::size_t count) {
  using Front = std::tuple<double, std::uint32_t, std::uint32_t>;  // distance, node, vertex
  std::priority_queue<Front, std::vector<Front>, std::greater<>> front;
  for (std::uint32_t n = 0; n < sources.size(); ++n) front.emplace(0.0, n, sources[n]);
  std::vector<std::vector<NearNode>> nearest(ways.size());
  while (!front.empty()) {
    const auto [distance, node, vertex] = front.top();
    front.pop();
    auto& here = nearest[vertex];
    const auto same = [node = node](const NearNode& near) { return near.node == node; };
    if (here.size() == count || std::any_of(here.begin(), here.end(), same)) continue;
    here.push_back({distance, node});
    for (const auto& way : ways.from(vertex))
      if (nearest[way.to].size() < count) front.emplace(distance + way.length, node, way.to);
  }
  return nearest;
}

DeformationGraph::Binding binding_of(const std::vector<NearNode>& nearest) {
  DeformationGraph::Binding binding;
  const double reach = nearest.back().distance * (1.0 + 1e-6) + 1e-9;
  double sum = 0.0;
  for (std::size_t k = 0; k < DeformationGraph::kNearest; ++k) {
    const auto& near = nearest[std::min(k, nearest.size() - 1)];
    const double closeness = k < nearest.size() ? 1.0 - near.distance / reach : 0.0;
    binding.node[k] = near.node;
    binding.weight[k] = closeness * closeness;
    sum += binding.weight[k];
  }
  for (auto& weight : binding.weight) weight /= sum;
  return binding;
}

// How far it is from the vertex opposite an edge on one side to the one on the other, both triangles laid flat.
double unfolded(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& left,
                const Eigen::Vector3d& right) {
  const Eigen::Vector3d along = (b - a).normalized();
  const double x0 = along.dot(left - a), x1 = along.dot(right - a);
  const double y0 = (left - a - x0 * along).norm(), y1 = (right - a - x1 * along).norm();
  const double crossing = x0 + (x1 - x0) * y0 / std::max(y0 + y1, 1e-12);  // outside of the edge: not a straight way
  if (crossing < 0.0 || crossing > (b - a).norm()) return kFar;
  return std::hypot(x1 - x0, y0 + y1);
}

}  // namespace

GeodesicWays::GeodesicWays(const TriangleMesh& mesh) : ways_(mesh.positions.size()) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> opposite;  // of the half-edge a -> b
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) opposite[{t[i], t[(i + 1) % 3]}] = t[(i + 2) % 3];
  const auto at = [&](std::uint32_t v) -> Eigen::Vector3d { return mesh.positions[v].cast<double>(); };
  for (const auto& [edge, left] : opposite) {
    const auto [a, b] = edge;
    ways_[a].push_back({b, (at(b) - at(a)).norm()});
    const auto back = opposite.find({b, a});
    if (back == opposite.end()) continue;
    const double length = unfolded(at(a), at(b), at(left), at(back->second));
    if (length < kFar) ways_[left].push_back({back->second, length});
  }
}

void GeodesicWays::spread(const std::vector<std::uint32_t>& sources, std::vector<double>& distances) const {
  using Front = std::pair<double, std::uint32_t>;
  std::priority_queue<Front, std::vector<Front>, std::greater<>> front;
  for (const auto source : sources) {
    distances[source] = 0.0;
    front.emplace(0.0, source);
  }
  while (!front.empty()) {
    const auto [distance, vertex] = front.top();
    front.pop();
    if (distance > distances[vertex]) continue;
    for (const auto& way : ways_[vertex]) {
      const double there = distance + way.length;
      if (there >= distances[way.to]) continue;
      distances[way.to] = there;
      front.emplace(there, way.to);
    }
  }
}

DeformationGraph deformation_graph(const TriangleMesh& mesh, std::size_t nodes) {
  const GeodesicWays ways(mesh);
  const auto sources = farthest_points(ways, nodes);
  DeformationGraph graph;
  for (const auto source : sources) graph.nodes.push_back(mesh.positions[source].cast<double>());
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  constexpr std::size_t kJoined = 3;  // a vertex joins its nearest nodes: about six edges a node
  for (const auto& nearest : nearest_nodes(ways, sources, DeformationGraph::kNearest + 1)) {
    graph.bindings.push_back(nearest.empty() ? DeformationGraph::Binding{{}, {1.0}} : binding_of(nearest));
    for (std::size_t i = 0; i < std::min(kJoined, nearest.size()); ++i)
      for (std::size_t j = 0; j < i; ++j) edges.insert(std::minmax(nearest[i].node, nearest[j].node));
  }
  graph.edges.assign(edges.begin(), edges.end());
  return graph;
}

Eigen::Vector3d moved(const DeformationGraph& graph, const std::vector<NodeMotion>& motion,
                      const DeformationGraph::Binding& binding, const Eigen::Vector3d& point) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < DeformationGraph::kNearest; ++k) {
    const auto n = binding.node[k];
    sum += binding.weight[k] * (motion[n].rotation * (point - graph.nodes[n]) + graph.nodes[n] + motion[n].shift);
  }
  return sum;
}

Eigen::Vector3d turned(const std::vector<NodeMotion>& motion, const DeformationGraph::Binding& binding,
                       const Eigen::Vector3d& normal) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < DeformationGraph::kNearest; ++k)
    sum += binding.weight[k] * (motion[binding.node[k]].rotation * normal);
  return sum;
}

}  // namespace rotunda::recon
