#include "recon/track/surface_registration.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kSurfacePoints = 1700;  // of the surface, that look for the model

// The samples of the model where a motion has brought them.
TriangleMesh moved_model(const SurfaceModel& model, const std::vector<NodeMotion>& motion) {
  TriangleMesh mesh;
  const auto& samples = model.samples();
  mesh.positions.resize(samples.size());
  mesh.normals.resize(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    const auto& binding = model.graph().bindings[samples[i]];
    mesh.positions[i] = moved(model.graph(), motion, binding, model.rest_points()[samples[i]]).cast<float>();
    mesh.normals[i] =
        turned(motion, binding, model.rest().normals[samples[i]].cast<double>()).normalized().cast<float>();
  });
  return mesh;
}

void pull_to_plane(Pull& pull, const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& normal,
                   double weight) {
  pull.stiffness += weight * normal * normal.transpose();
  pull.force += weight * normal * normal.dot(to - from);
}

class Registration {
 public:
  Registration(const SurfaceModel& model, const SurfaceTarget& target, const RegistrationOptions& options)
      : model_(model),
        target_(target),
        options_(options),
        solver_(model.graph(), model.rest_points()),
        stride_(std::max<std::size_t>(1, target.mesh().positions.size() / kSurfacePoints)) {}

  void iterate(std::vector<NodeMotion>& motion, std::size_t iteration) {
    const double gate = options_.gates[iteration];
    const auto now = moved_model(model_, motion);
    const SurfaceTarget samples(now);
    std::vector<Pull> pulls(now.positions.size());
    tbb::parallel_for(std::size_t{0}, pulls.size(), [&](std::size_t i) { pull_to_surface(now, i, gate, pulls[i]); });
    pull_from_surface(now, samples, gate, pulls);
    const double steps_left = static_cast<double>(options_.gates.size() - 1 - iteration);
    solver_.step(motion, pulls,
                 {.rigidity = options_.rigidity * std::pow(options_.relief, -steps_left), .give = options_.give});
  }

  double uncovered(const std::vector<NodeMotion>& motion) const {
    constexpr double kAnywhere = 1.0, kUncovered = 0.06;  // metres
    const auto now = moved_model(model_, motion);
    const SurfaceTarget samples(now);
    std::size_t asked = 0, far = 0;
    for (std::size_t v = 0; v < target_.mesh().positions.size(); v += stride_, ++asked) {
      const auto& point = target_.mesh().positions[v];
      const auto near =
          samples.closest_vertex(point.cast<double>(), target_.mesh().normals[v].cast<double>(), kAnywhere);
      far += !near || static_cast<double>((now.positions[*near] - point).norm()) > kUncovered;
    }
    return static_cast<double>(far) / static_cast<double>(std::max<std::size_t>(1, asked));
  }

 private:
  void pull_to_surface(const TriangleMesh& now, std::size_t i, double gate, Pull& pull) const {
    pull.vertex = model_.samples()[i];
    const Eigen::Vector3d at = now.positions[i].cast<double>();
    const auto hit = target_.closest(at, now.normals[i].cast<double>(), gate);
    if (!hit) return;
    const bool inside = hit->normal.dot(at - hit->point) < 0.0;
    pull_to_plane(pull, at, hit->point, hit->normal,
                  model_.sample_weights()[i] * (inside ? options_.inside_trust : 1.0));
  }

  void pull_from_surface(const TriangleMesh& now, const SurfaceTarget& samples, double gate,
                         std::vector<Pull>& pulls) const {
    const auto& mesh = target_.mesh();
    const auto count = (mesh.positions.size() + stride_ - 1) / stride_;
    std::vector<std::optional<std::uint32_t>> nearest(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      const auto v = i * stride_;
      nearest[i] = samples.closest_vertex(mesh.positions[v].cast<double>(), mesh.normals[v].cast<double>(), gate);
    });
    for (std::size_t i = 0; i < count; ++i) {
      if (!nearest[i]) continue;
      const Eigen::Vector3d at = now.positions[*nearest[i]].cast<double>(),
                            to = mesh.positions[i * stride_].cast<double>(),
                            normal = mesh.normals[i * stride_].cast<double>();
      const bool inside = normal.dot(at - to) < 0.0;
      pull_to_plane(pulls[*nearest[i]], at, to, normal, inside ? options_.inside_trust : 1.0);
    }
  }

  const SurfaceModel& model_;
  const SurfaceTarget& target_;
  const RegistrationOptions& options_;
  GraphSolver solver_;
  std::size_t stride_;
};

}  // namespace

std::vector<double> vertex_areas(const TriangleMesh& mesh) {
  std::vector<double> areas(mesh.positions.size(), 0.0);
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f cross =
        (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
    for (const auto corner : t) areas[corner] += static_cast<double>(cross.norm()) / 6.0;
  }
  return areas;
}

SurfaceModel::SurfaceModel(const TriangleMesh& mesh) : rest_(mesh) {
  if (mesh.positions.empty() || mesh.normals.size() != mesh.positions.size())
    throw InvalidInput("a surface to carry along needs vertices and their normals");
  for (const auto& position : rest_.positions) points_.push_back(position.cast<double>());
  graph_ = deformation_graph(rest_, kNodes);
  const auto areas = vertex_areas(rest_);
  const auto stride = std::max<std::size_t>(1, (points_.size() + kSamples - 1) / kSamples);
  double sum = 0.0;
  for (std::uint32_t v = 0; v < points_.size(); v += static_cast<std::uint32_t>(stride)) {
    samples_.push_back(v);
    weights_.push_back(areas[v]);
    sum += areas[v];
  }
  for (auto& weight : weights_) weight *= static_cast<double>(samples_.size()) / std::max(sum, 1e-12);
}

TriangleMesh SurfaceModel::moved(const std::vector<NodeMotion>& motion) const {
  TriangleMesh mesh;
  mesh.triangles = rest_.triangles;
  mesh.positions.resize(points_.size());
  mesh.normals.resize(points_.size());
  tbb::parallel_for(std::size_t{0}, points_.size(), [&](std::size_t v) {
    const auto& binding = graph_.bindings[v];
    mesh.positions[v] = recon::moved(graph_, motion, binding, points_[v]).cast<float>();
    mesh.normals[v] = turned(motion, binding, rest_.normals[v].cast<double>()).normalized().cast<float>();
  });
  return mesh;
}

double register_surface(const SurfaceModel& model, const SurfaceTarget& target, std::vector<NodeMotion>& motion,
                        const RegistrationOptions& options) {
  Registration registration(model, target, options);
  for (std::size_t i = 0; i < options.gates.size(); ++i) registration.iterate(motion, i);
  return registration.uncovered(motion);
}

}  // namespace rotunda::recon
