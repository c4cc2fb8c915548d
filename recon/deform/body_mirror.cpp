#include "recon/deform/body_mirror.h"

#include <limits>

#include "recon/deform/markers.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;

const Vector3d kMirror(1.0, -1.0, 1.0);  // the left is at +y

Vector3d normal_of(const TriangleMesh& mesh, std::uint32_t triangle) {
  const auto& c = mesh.triangles[triangle];
  const Eigen::Vector3f sum = mesh.normals[c[0]] + mesh.normals[c[1]] + mesh.normals[c[2]];
  return sum.cast<double>().normalized();
}

}  // namespace

std::size_t mirrored_segment(std::size_t segment) {
  const auto joint = mirrored(joint_of_segment(segment));
  std::size_t other = 0;
  while (joint_of_segment(other) != joint) ++other;
  return other;
}

BodyMirror::BodyMirror(const TriangleMesh& scan, const TemplateFit& fit)
    : fit_(fit), at_scan_(joint_transforms(fit.body.skeleton, fit.pose)), scan_(scan) {}

Vector3d BodyMirror::at_rest(std::uint32_t template_triangle) const {
  const auto& vertices = fit_.body.segments[segment_of_triangle(template_triangle)].vertices;
  Vector3d middle = Vector3d::Zero();
  for (const auto v : segment_triangles()[template_triangle % segment_triangles().size()]) middle += vertices[v] / 3.0;
  return middle;
}

double BodyMirror::distance(std::uint32_t template_triangle, std::uint32_t other) const {
  if (segment_of_triangle(template_triangle) != segment_of_triangle(other))
    return std::numeric_limits<double>::infinity();
  return (at_rest(template_triangle) - at_rest(other)).norm();
}

std::uint32_t BodyMirror::on_template(std::uint32_t triangle) const {
  const Vector3d wanted = at_rest(triangle).cwiseProduct(kMirror);
  const auto count = static_cast<std::uint32_t>(segment_triangles().size());
  const auto first = static_cast<std::uint32_t>(mirrored_segment(segment_of_triangle(triangle))) * count;
  std::uint32_t nearest = first;
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t t = first; t < first + count; ++t)
    if (const double away = (at_rest(t) - wanted).squaredNorm(); away < least) {
      least = away;
      nearest = t;
    }
  return nearest;
}

std::optional<std::uint32_t> BodyMirror::on_scan(std::uint32_t triangle, std::size_t segment) const {
  constexpr double kReach = 0.10;
  const auto& mesh = scan_.mesh();
  const auto& from = at_scan_[index(joint_of_segment(segment))];
  const auto& to = at_scan_[index(joint_of_segment(mirrored_segment(segment)))];
  const Vector3d place = middle_of(mesh, triangle).cast<double>();
  const Vector3d mirrored_place = to * (from.inverse() * place).cwiseProduct(kMirror);
  const Vector3d normal = to.linear() * (from.linear().transpose() * normal_of(mesh, triangle)).cwiseProduct(kMirror);
  const auto hit = scan_.closest(mirrored_place, normal, kReach);
  if (!hit) return std::nullopt;
  return static_cast<std::uint32_t>(hit->sample.triangle);
}

}  // namespace rotunda::recon
