#pragma once
// A surface of known connectivity moved onto another one that was reconstructed on its own: an embedded deformation
// fitted to nearest points that face the same way, from the model to the surface and back. What live tracking and cold
// matching share. World frame, metres. Deterministic, the same result on any number of threads.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "recon/track/deformation_graph.h"
#include "recon/track/graph_solver.h"
#include "recon/track/surface_target.h"

namespace rotunda::recon {

// A closed surface as a model, with a graph spread over it.
class SurfaceModel {
 public:
  static constexpr std::size_t kSamples = 4000;  // about so many vertices take part in fits
  static constexpr std::size_t kNodes = 400;

  // Throws InvalidInput if the mesh has no vertex or no normals.
  explicit SurfaceModel(const TriangleMesh& mesh);

  const DeformationGraph& graph() const { return graph_; }
  const TriangleMesh& rest() const { return rest_; }
  const std::vector<Eigen::Vector3d>& rest_points() const { return points_; }
  const std::vector<std::uint32_t>& samples() const { return samples_; }  // vertices that take part
  const std::vector<double>& sample_weights() const { return weights_; }  // of area; mean 1

  std::vector<NodeMotion> still() const { return std::vector<NodeMotion>(graph_.nodes.size()); }
  TriangleMesh moved(const std::vector<NodeMotion>& motion) const;  // with normals, turned along; without colours

 private:
  TriangleMesh rest_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::uint32_t> samples_;
  std::vector<double> weights_;
  DeformationGraph graph_;
};

// Square metres around each vertex; their sum is the mesh's area.
std::vector<double> vertex_areas(const TriangleMesh& mesh);

struct RegistrationOptions {
  std::vector<double> gates = {0.15, 0.09, 0.054,
                               0.05, 0.05, 0.05};  // metres; nearest points farther away do not count; one an iteration
  double rigidity = 5.0;                           // of the last iteration
  double give = 0.010;
  double relief = 0.6;        // rigidity falls by this factor from iteration to iteration
  double inside_trust = 0.5;  // a hull is never smaller than the body: the model may lie inside it
};

// Moves on from `motion`. Returns the share of the surface's points farther than 60 mm from any sample: 0 to 1.
double register_surface(const SurfaceModel& model, const SurfaceTarget& target, std::vector<NodeMotion>& motion,
                        const RegistrationOptions& options);

}  // namespace rotunda::recon
