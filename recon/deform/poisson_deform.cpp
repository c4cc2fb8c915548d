#include "recon/deform/poisson_deform.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <ctime>
#include <numeric>
#include <optional>

#include "config/errors.h"
#include "recon/deform/lane_rows.h"
#include "recon/deform/volume_keeping.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3f;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// A share below this turns nothing a pixel could tell: 1e-4 of half a turn at a limb's reach is 0.1 mm.
constexpr float kLeastShare = 1e-4F;

struct Fragments {
  std::vector<FragmentTriangle> triangles;
  std::vector<HandleShare> shares;
};

void append_shares(const Eigen::RowVectorXf& mean, std::vector<HandleShare>& shares) {
  float sum = 0.0F;
  const std::size_t begin = shares.size();
  for (Eigen::Index h = 0; h < mean.size(); ++h) {
    if (mean[h] < kLeastShare) continue;
    shares.push_back({static_cast<std::uint32_t>(h), mean[h]});
    sum += mean[h];
  }
  for (std::size_t i = begin; i < shares.size(); ++i) shares[i].weight /= sum;
}

// Share of the Laplacian at corner k: what its two edges weigh.
Vector3f laplacian_share(const TriangleMesh& mesh, const CornerWeights& weights, std::size_t t, std::size_t k) {
  const auto& corners = mesh.triangles[t];
  const std::size_t next = (k + 1) % 3, last = (k + 2) % 3;
  const Vector3f& at = mesh.positions[corners[k]];
  return weights[last] * (at - mesh.positions[corners[next]]) + weights[next] * (at - mesh.positions[corners[last]]);
}

Fragments make_fragments(const TriangleMesh& mesh, const std::vector<CornerWeights>& weights,
                         const HeldLaplacian& system, const HandleShares& shares) {
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto first_row = [&](std::uint32_t t) {
    const auto& c = mesh.triangles[t];
    return std::min({system.place[c[0]], system.place[c[1]], system.place[c[2]]});
  };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return first_row(a) < first_row(b); });
  Fragments fragments;
  fragments.triangles.reserve(order.size());
  for (const auto t : order) {
    const auto& c = mesh.triangles[t];
    FragmentTriangle triangle{.row = {system.place[c[0]], system.place[c[1]], system.place[c[2]]},
                              .first = {},
                              .second = {},
                              .shares_begin = static_cast<std::uint32_t>(fragments.shares.size()),
                              .shares_end = 0};
    Vector3f::Map(triangle.first) = laplacian_share(mesh, weights[t], t, 0);
    Vector3f::Map(triangle.second) = laplacian_share(mesh, weights[t], t, 1);
    append_shares((shares.row(c[0]) + shares.row(c[1]) + shares.row(c[2])) / 3.0F, fragments.shares);
    triangle.shares_end = static_cast<std::uint32_t>(fragments.shares.size());
    fragments.triangles.push_back(triangle);
  }
  return fragments;
}

std::vector<RowLink> make_links(const TriangleMesh& mesh, const std::vector<CornerWeights>& weights,
                                const HeldLaplacian& system) {
  std::vector<RowLink> links;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = system.place[mesh.triangles[t][(k + 1) % 3]], b = system.place[mesh.triangles[t][(k + 2) % 3]];
      if (a < system.free && b >= system.free) links.push_back({a, b, weights[t][k]});
      if (b < system.free && a >= system.free) links.push_back({b, a, weights[t][k]});
    }
  return links;
}

// The cones over the surface about each joint, and what may move there.
struct Cones {
  std::vector<ConeTriangle> triangles;
  std::vector<BulgeVertex> vertices;
  std::size_t gradients = 0;
  std::vector<double> at_rest;  // m^3
};

// How much a vertex belongs to a joint: 1 where both its handles turn it alike, 0 where one of them holds it.
float belonging(const HandleShares& shares, std::uint32_t vertex, const HandleJoint& joint) {
  return 4.0F * shares(vertex, joint.a) * shares(vertex, joint.b);
}

// The joint a triangle or vertex belongs to most; none of them where the surface is all but rigid.
std::optional<std::uint32_t> joint_of(const HandleShares& shares, std::span<const std::uint32_t> vertices,
                                      const std::vector<HandleJoint>& joints) {
  float most = 1e-3F;
  std::optional<std::uint32_t> found;
  for (std::uint32_t j = 0; j < joints.size(); ++j) {
    float sum = 0.0F;
    for (const auto v : vertices) sum += belonging(shares, v, joints[j]) / static_cast<float>(vertices.size());
    if (sum <= most) continue;
    most = sum;
    found = j;
  }
  return found;
}

std::vector<float> vertex_areas(const TriangleMesh& mesh) {
  std::vector<float> areas(mesh.positions.size(), 0.0F);
  for (const auto& t : mesh.triangles) {
    const Vector3f& a = mesh.positions[t[0]];
    const float area = 0.5F * (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a).norm();
    for (const auto v : t) areas[v] += area / 3.0F;
  }
  return areas;
}

Cones make_cones(const TriangleMesh& mesh, const HeldLaplacian& system, const HandleShares& shares,
                 const std::vector<HandleJoint>& joints) {
  Cones cones;
  cones.at_rest.assign(joints.size(), 0.0);
  std::vector<std::int64_t> gradient(mesh.positions.size(), -1);
  for (const auto& t : mesh.triangles) {
    const auto joint = joint_of(shares, t, joints);
    if (!joint) continue;
    ConeTriangle cone{.row = {}, .gradient = {}, .joint = *joint};
    for (std::size_t k = 0; k < 3; ++k) {
      if (gradient[t[k]] < 0) gradient[t[k]] = static_cast<std::int64_t>(cones.gradients++);
      cone.row[k] = system.place[t[k]];
      cone.gradient[k] = static_cast<std::uint32_t>(gradient[t[k]]);
    }
    cones.triangles.push_back(cone);
    const auto from = [&](std::size_t k) {
      return Eigen::Vector3d((mesh.positions[t[k]] - joints[*joint].centre).cast<double>());
    };
    cones.at_rest[*joint] += from(0).dot(from(1).cross(from(2))) / 6.0;
  }
  const auto areas = vertex_areas(mesh);
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const std::uint32_t self[1] = {v};
    const auto joint = joint_of(shares, self, joints);
    if (!joint || gradient[v] < 0 || system.place[v] >= system.free || areas[v] <= 0.0F) continue;
    cones.vertices.push_back({system.place[v], static_cast<std::uint32_t>(gradient[v]), *joint,
                              belonging(shares, v, joints[*joint]) / areas[v]});
  }
  return cones;
}

}  // namespace

struct PoissonDeform::Parts {
  PoissonDeformOptions options;
  HeldLaplacian system;
  HandleShares shares;
  Fragments fragments;
  std::vector<HeldPlace> held;
  std::vector<RowLink> links;
  Cones cones;

  // What a thread works in.
  struct Room {
    LaneRows rows, gradients, quaternions, transforms, centres, volumes, slopes;
    DeformClock clock;
  };
  tbb::enumerable_thread_specific<Room> rooms{[this] { return make_room(); }};

  Room make_room() const {
    const std::size_t joints = options.joints.size();
    return {.rows = LaneRows(system.place.size()),
            .gradients = LaneRows(cones.gradients),
            .quaternions = LaneRows(2 * options.handles),
            .transforms = LaneRows(4 * options.handles),
            .centres = LaneRows(joints),
            .volumes = LaneRows(joints),
            .slopes = LaneRows(joints),
            .clock = {}};
  }

  void take_poses(std::span<const HandlePose> poses, std::size_t lane, Room& room) const;
  void keep_volume(Room& room) const;
  void deform_batch(std::span<const HandlePose> poses, std::span<Vector3f> positions, Room& room) const;
};

void PoissonDeform::Parts::take_poses(std::span<const HandlePose> poses, std::size_t lane, Room& room) const {
  const std::size_t n = lane_count();
  for (std::size_t h = 0; h < options.handles; ++h) {
    const auto& q = poses[h].rotation;
    const float components[4] = {q.w(), q.x(), q.y(), q.z()};
    for (std::size_t i = 0; i < 4; ++i) room.quaternions.data()[(4 * h + i) * n + lane] = components[i];
    Eigen::Matrix<float, 3, 4> transform;
    transform << q.normalized().toRotationMatrix(), poses[h].translation;
    for (std::size_t i = 0; i < 12; ++i)
      room.transforms.data()[(12 * h + i) * n + lane] =
          transform(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4));
  }
  for (std::size_t j = 0; j < options.joints.size(); ++j) {
    const auto& pose = poses[options.joints[j].a];
    const Vector3f centre = pose.rotation.normalized() * options.joints[j].centre + pose.translation;
    for (std::size_t i = 0; i < 3; ++i)
      room.centres.data()[(3 * j + i) * n + lane] = centre[static_cast<Eigen::Index>(i)];
  }
}

void PoissonDeform::Parts::keep_volume(Room& room) const {
  const std::size_t n = lane_count(), joints = options.joints.size();
  std::fill_n(room.volumes.data(), room.volumes.size(), 0.0F);
  std::fill_n(room.gradients.data(), room.gradients.size(), 0.0F);
  float* volumes = room.volumes.data();
  add_cones(cones.triangles, room.centres.data(), room.rows.data(), volumes, room.gradients.data());
  for (std::size_t j = 0; j < joints; ++j)
    for (std::size_t lane = 0; lane < n; ++lane)
      volumes[j * n + lane] = static_cast<float>(cones.at_rest[j]) - volumes[j * n + lane];
  bulge(cones.vertices, joints, volumes, room.gradients.data(), room.slopes.data(), room.rows.data());
}

void PoissonDeform::Parts::deform_batch(std::span<const HandlePose> poses, std::span<Vector3f> positions,
                                        Room& room) const {
  const std::size_t n = lane_count(), frames = poses.size() / options.handles, vertices = system.place.size();
  const double start = thread_seconds();
  for (std::size_t lane = 0; lane < n; ++lane)
    take_poses(poses.subspan(std::min(lane, frames - 1) * options.handles, options.handles), lane, room);
  std::fill_n(room.rows.data(), room.rows.size(), 0.0F);
  add_fragments(fragments.triangles, fragments.shares, room.quaternions.data(), room.rows.data());
  place_held(held, room.transforms.data(), room.rows.data());
  add_links(links, room.rows.data());
  const double turned = thread_seconds();
  solve_lanes(system.factor, room.rows.data());
  const double solved = thread_seconds();
  if (!options.joints.empty())
    for (int round = 0; round < 2; ++round) keep_volume(room);
  const double kept = thread_seconds();
  for (std::size_t v = 0; v < vertices; ++v) {
    const float* row = room.rows.row(system.place[v]);
    for (std::size_t f = 0; f < frames; ++f) positions[f * vertices + v] = {row[f], row[n + f], row[2 * n + f]};
  }
  room.clock.rotate_s += turned - start;
  room.clock.solve_s += solved - turned;
  room.clock.volume_s += kept - solved;
  room.clock.store_s += thread_seconds() - kept;
}

PoissonDeform::PoissonDeform(const TriangleMesh& rest, std::span<const HeldVertex> held,
                             const PoissonDeformOptions& options)
    : parts_(std::make_unique<Parts>()) {
  for (const auto& one : held)
    if (one.handle >= options.handles)
      throw InvalidInput(fmt::format("vertex {} is held by handle {} of {}", one.vertex, one.handle, options.handles));
  if (held.empty()) throw InvalidInput("nothing holds the surface");
  TriangleMesh tied{.positions = rest.positions, .normals = {}, .colours = {}, .triangles = rest.triangles};
  tied.triangles.insert(tied.triangles.end(), options.bridges.begin(), options.bridges.end());
  const auto weights = cotangent_weights(tied);
  auto& parts = *parts_;
  parts.options = options;
  parts.system = hold(tied, weights, held);
  parts.shares = harmonic_shares(tied, weights, parts.system, options.handles);
  if (!options.hold_positions) parts.system = hold(tied, weights, held.first(1));
  parts.fragments = make_fragments(tied, weights, parts.system, parts.shares);
  parts.links = make_links(tied, weights, parts.system);
  for (const auto& one : parts.system.held) {
    const auto& p = rest.positions[one.vertex];
    parts.held.push_back({parts.system.place[one.vertex], one.handle, {p.x(), p.y(), p.z()}});
  }
  parts.cones = make_cones(rest, parts.system, parts.shares, options.joints);
}

PoissonDeform::~PoissonDeform() = default;
PoissonDeform::PoissonDeform(PoissonDeform&&) noexcept = default;

std::size_t PoissonDeform::vertices() const {
  return parts_->system.place.size();
}

const HandleShares& PoissonDeform::shares() const {
  return parts_->shares;
}

void PoissonDeform::deform(std::span<const HandlePose> poses, std::span<Vector3f> positions) {
  const std::size_t handles = parts_->options.handles, frames = poses.size() / handles, n = lane_count();
  if (frames * handles != poses.size() || positions.size() != frames * vertices())
    throw InvalidInput("poses and positions to deform differ in frames");
  tbb::parallel_for(std::size_t{0}, (frames + n - 1) / n, [&](std::size_t batch) {
    const std::size_t first = batch * n, count = std::min(n, frames - first);
    parts_->deform_batch(poses.subspan(first * handles, count * handles),
                         positions.subspan(first * vertices(), count * vertices()), parts_->rooms.local());
  });
}

DeformClock PoissonDeform::clock() const {
  DeformClock sum;
  for (const auto& room : parts_->rooms) {
    sum.rotate_s += room.clock.rotate_s;
    sum.solve_s += room.clock.solve_s;
    sum.volume_s += room.clock.volume_s;
    sum.store_s += room.clock.store_s;
  }
  return sum;
}

void agree_in_sign(std::span<HandlePose> poses, std::span<const int> parent) {
  const std::size_t handles = parent.size();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int above = parent[i % handles];
    const std::size_t to = i / handles * handles + static_cast<std::size_t>(std::max(above, 0));
    auto& own = poses[i].rotation;
    if (above < 0 && i < handles) continue;
    const auto& other = above >= 0 ? poses[to].rotation : poses[i - handles].rotation;
    if (own.dot(other) < 0.0F) own.coeffs() = -own.coeffs();
  }
}

}  // namespace rotunda::recon
