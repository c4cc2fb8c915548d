#include "recon/deform/upright_stance.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct Patch {
  Vector3d at;  // a triangle's middle
  double area;
  std::array<Vector3d, 3> corners;
};

std::vector<Patch> patches_of(const TriangleMesh& mesh) {
  std::vector<Patch> patches;
  patches.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                   c = mesh.positions[t[2]].cast<double>();
    patches.push_back({(a + b + c) / 3.0, 0.5 * (b - a).cross(c - a).norm(), {a, b, c}});
  }
  return patches;
}

Matrix3d with_z(const Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ()).toRotationMatrix();
}

// The surface with some direction up: middle, extent and principal axis of what lies between two levels, 0 the soles, 1
// the crown.
class Standing {
 public:
  Standing(const std::vector<Patch>& patches, const Matrix3d& rotation) : patches_(patches), rotation_(rotation) {
    for (const auto& patch : patches) box_.extend(rotation * patch.at);
  }
  double height() const { return box_.sizes().z(); }
  const Eigen::AlignedBox3d& box() const { return box_; }

  struct Slice {
    double area = 0.0;
    Vector2d middle = Vector2d::Zero(), lateral = Vector2d::UnitY();
    double least = 0.0, most = 0.0;  // along the lateral axis, from the middle
    double gap = 0.0;                // the widest stretch along it without surface
  };
  Slice slice(double low, double high) const {
    Slice slice;
    Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
    std::vector<const Patch*> inside;
    for (const auto& patch : patches_) {
      const Vector3d p = rotation_ * patch.at;
      const double level = (p.z() - box_.min().z()) / height();
      if (level < low || level >= high) continue;
      inside.push_back(&patch);
      slice.area += patch.area;
      slice.middle += patch.area * p.head<2>();
    }
    if (inside.empty() || !(slice.area > 0.0)) return slice;
    slice.middle /= slice.area;
    for (const auto* patch : inside) {
      const Vector2d off = (rotation_ * patch->at).head<2>() - slice.middle;
      moments += patch->area * off * off.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(moments);
    slice.lateral = axes.eigenvectors().col(1);
    measure(inside, slice);
    return slice;
  }

 private:
  // Where triangles lie along the lateral axis: what none of them covers is air.
  void measure(const std::vector<const Patch*>& inside, Slice& slice) const {
    std::vector<std::pair<double, double>> covered;
    for (const auto* patch : inside) {
      std::array<double, 3> along;
      for (std::size_t k = 0; k < 3; ++k)
        along[k] = ((rotation_ * patch->corners[k]).head<2>() - slice.middle).dot(slice.lateral);
      covered.emplace_back(*std::min_element(along.begin(), along.end()),
                           *std::max_element(along.begin(), along.end()));
    }
    std::sort(covered.begin(), covered.end());
    slice.least = covered.front().first;
    slice.most = covered.front().second;
    for (const auto& [from, to] : covered) {
      slice.gap = std::max(slice.gap, from - slice.most);
      slice.most = std::max(slice.most, to);
    }
  }

  const std::vector<Patch>& patches_;
  Matrix3d rotation_;
  Eigen::AlignedBox3d box_;
};

// Between knee and ankle there are two legs with air between them; crown and face are one and small. Fractions of the
// height: Drillis and Contini (1966) have the knee at 0.285, the chin at 0.870; a head is 0.13 long.
bool is_standing(const Standing& standing) {
  int legs = 0;
  for (const double level : {0.10, 0.14, 0.18, 0.22}) {
    const auto slice = standing.slice(level, level + 0.02);
    if (slice.area > 0.0 && slice.gap > 0.005 * standing.height() &&
        slice.most - slice.least < 0.75 * standing.height())
      ++legs;
  }
  const auto head = standing.slice(0.92, 0.96);
  const bool has_head =
      head.area > 0.0 && head.most - head.least < 0.25 * standing.height() && head.gap < 0.03 * standing.height();
  return legs >= 3 && has_head;
}

// Feet reach farther forward of the shanks than back.
Vector3d forward_of(const Standing& standing) {
  const auto arms = standing.slice(0.35, 0.85);
  const Vector2d across(arms.lateral.y(), -arms.lateral.x());
  const auto feet = standing.slice(0.0, 0.035), shanks = standing.slice(0.08, 0.16);
  const double toes = (feet.middle - shanks.middle).dot(across);
  const Vector2d forward = toes < 0.0 ? Vector2d(-across) : across;
  return {forward.x(), forward.y(), 0.0};
}

// Fingertips are a good part of the height away from the middle, on both sides.
void require_arms(const Standing& standing, const Vector3d& forward) {
  const Vector2d left(-forward.y(), forward.x());
  const auto arms = standing.slice(0.30, 0.90);
  const bool along = arms.lateral.dot(left) > 0.0;
  const double reach = std::min(along ? arms.most : -arms.least, along ? -arms.least : arms.most);
  if (reach < 0.20 * standing.height())
    throw InvalidInput(
        fmt::format("the scan's arms lie at its body (its hands are {:.0f} % of the height from its middle): scan the "
                    "person in an A- or T-pose, or part the arms from the body",
                    100.0 * reach / standing.height()));
}

}  // namespace

UprightStance find_stance(const TriangleMesh& mesh) {
  const auto patches = patches_of(mesh);
  constexpr std::array<const char*, 6> kNames = {"z", "y", "x", "-y", "-x", "-z"};
  const std::array<Vector3d, 6> ups = {Vector3d::UnitZ(),  Vector3d::UnitY(),  Vector3d::UnitX(),
                                       -Vector3d::UnitY(), -Vector3d::UnitX(), -Vector3d::UnitZ()};
  for (std::size_t i = 0; i < ups.size(); ++i) {
    const Matrix3d turned = with_z(ups[i]);
    const Standing standing(patches, turned);
    if (!(standing.height() > 0.0) || !is_standing(standing)) continue;
    const Vector3d forward = forward_of(standing);
    require_arms(standing, forward);
    UprightStance stance{.upright_from_scan = Eigen::Isometry3d::Identity(), .height = standing.height(), .told = ""};
    Matrix3d heading;
    heading << forward.transpose(), Vector3d::UnitZ().cross(forward).transpose(), Vector3d::UnitZ().transpose();
    const auto feet = standing.slice(0.0, 0.1);
    const Vector3d origin(feet.middle.x(), feet.middle.y(), standing.box().min().z());
    stance.upright_from_scan.linear() = heading * turned;
    stance.upright_from_scan.translation() = -(heading * origin);
    if (i > 0) stance.told = fmt::format("its {} is up: stood upright", kNames[i]);
    return stance;
  }
  throw InvalidInput(
      "nobody stands in the scan along any of its axes (two legs below, one head above): turn it upright, or scan the "
      "person in an A- or T-pose with parted legs");
}

}  // namespace rotunda::recon
