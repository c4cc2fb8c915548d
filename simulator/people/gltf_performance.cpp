#include "simulator/people/gltf_performance.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "config/errors.h"
#include "recon/body/length_unit.h"
#include "simulator/people/fingerprint.h"
#include "simulator/people/footfall.h"
#include "simulator/people/gltf_surface.h"

namespace rotunda::simulator {
namespace {

using Eigen::Affine3d;
using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using recon::BodySegment;
using recon::NamedJoint;

// glTF: y up, facing +z; ours: z up, facing +x.
Affine3d standard_axes() {
  Affine3d axes = Affine3d::Identity();
  axes.linear() << Vector3d::UnitY(), Vector3d::UnitZ(), Vector3d::UnitX();
  return axes;
}

std::vector<Vector3f> transformed(const Affine3d& transform, std::vector<Vector3f> points) {
  for (auto& p : points) p = (transform * p.cast<double>()).cast<float>();
  return points;
}

AlignedBox3d box_of(const std::vector<Vector3f>& points) {
  AlignedBox3d box;
  for (const auto& p : points) box.extend(p.cast<double>());
  return box;
}

Eigen::Quaterniond turn_of(const Eigen::Matrix4d& to, const Eigen::Matrix4d& from) {
  const Matrix3d map = to.topLeftCorner<3, 3>() * from.topLeftCorner<3, 3>().inverse();
  if (!map.allFinite()) return Eigen::Quaterniond::Identity();  // a joint scaled to nothing has no frame
  // The nearest rotation: joints may be scaled.
  const Eigen::JacobiSVD<Matrix3d> svd(map, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  if (nearest.determinant() < 0.0)
    nearest = svd.matrixU() * Vector3d(1, 1, -1).asDiagonal() * svd.matrixV().transpose();
  return Eigen::Quaterniond(nearest);
}

template <class T>
void add_all(Fingerprint& print, const std::vector<T>& values) {
  print.add(values.size());
  print.add_bytes(values.data(), values.size() * sizeof(T));
}

void add_nodes(Fingerprint& print, const recon::GltfCharacter& character) {
  for (const auto& node : character.nodes) {
    print.add(node.parent);
    print.add_bytes(node.translation.data(), sizeof(double) * 3);
    print.add_bytes(node.rotation.coeffs().data(), sizeof(double) * 4);
    print.add_bytes(node.scale.data(), sizeof(double) * 3);
    if (node.matrix) print.add_bytes(node.matrix->data(), sizeof(double) * 16);
    add_all(print, node.morph_weights);
  }
}

void add_parts(Fingerprint& print, const recon::GltfCharacter& character) {
  for (const auto& skin : character.skins) {
    add_all(print, skin.joints);
    for (const auto& matrix : skin.inverse_bind) print.add_bytes(matrix.data(), sizeof(double) * 16);
  }
  for (const auto& part : character.parts) {
    print.add(part.node);
    print.add(part.skin);
    add_all(print, part.positions);
    add_all(print, part.influences);
    for (const auto& morph : part.morphs) add_all(print, morph);
  }
}

}  // namespace

GltfPerformance::GltfPerformance(const std::filesystem::path& file, const std::string& act)
    : person_(file.string()), act_(act), character_(recon::read_gltf_character(file)), notes_(character_.notes) {
  if (!character_.clips.empty() && !act.empty()) clip_ = &character_.clip(act);
  if (character_.clips.empty() && !act.empty()) notes_.emplace_back("has no clips: shown as it is at rest");
  if (clip_) act_ = clip_->name;
  time_clip();
  collect_joints();
  world_from_file_ = standard_axes();
  orient();
  scale();
  place();
  auto surface =
      assemble_surface(character_, transformed(world_from_file_, in_file(recon::state_at(character_, nullptr, 0.0))));
  recon::compute_normals(surface.figure.bind);
  source_ = std::move(surface.source);
  figures_.push_back(std::move(surface.figure));
}

// How many act frames the clip has. Between the last of them and the first again lies one more if the clip does not
// close.
void GltfPerformance::time_clip() {
  if (!clip_) return;
  const double duration = clip_->end - clip_->begin;
  const auto first = in_file(recon::state_at(character_, clip_, clip_->begin));
  const auto last = in_file(recon::state_at(character_, clip_, clip_->end));
  double apart = 0.0;
  for (std::size_t v = 0; v < first.size(); ++v) apart = std::max<double>(apart, (first[v] - last[v]).norm());
  is_cyclic_ = apart < 1e-3 * box_of(first).diagonal().norm();  // 2 mm of a person
  const double steps = duration / kActStep;
  frames_ = std::max(1, static_cast<int>(is_cyclic_ ? std::round(steps) : std::floor(steps + 1e-6) + 1));
}

double GltfPerformance::clip_seconds(double seconds) const {
  if (!clip_) return 0.0;
  const double round = frames_ * kActStep, duration = clip_->end - clip_->begin;
  const double own = seconds - round * std::floor(seconds / round);
  return clip_->begin + (is_cyclic_ ? own * duration / round : std::min(own, duration));
}

recon::CharacterState GltfPerformance::state_at(double seconds) const {
  return recon::state_at(character_, clip_, clip_seconds(seconds));
}

std::vector<Vector3f> GltfPerformance::in_file(const recon::CharacterState& state) const {
  std::vector<Vector3f> all;
  for (const auto& part : character_.parts) {
    const auto posed = recon::posed_positions(character_, part, state);
    all.insert(all.end(), posed.begin(), posed.end());
  }
  if (!std::all_of(all.begin(), all.end(), [](const Vector3f& p) { return p.allFinite(); }))
    throw CorruptData(character_.file.string() + ": its nodes carry the surface into infinity");
  return all;
}

// The nodes that any skin names; without a skin those that carry a surface.
void GltfPerformance::collect_joints() {
  std::vector<bool> is_joint(character_.nodes.size(), false);
  for (const auto& skin : character_.skins)
    for (const auto node : skin.joints) is_joint[node] = true;
  if (character_.skins.empty())
    for (const auto& part : character_.parts) is_joint[part.node] = true;
  std::vector<int> place(character_.nodes.size(), -1);
  for (std::size_t node = 0; node < is_joint.size(); ++node) {
    if (!is_joint[node]) continue;
    int above = character_.nodes[node].parent;
    while (above >= 0 && !is_joint[static_cast<std::size_t>(above)])
      above = character_.nodes[static_cast<std::size_t>(above)].parent;
    place[node] = static_cast<int>(joints_.size());
    joints_.push_back({character_.nodes[node].name, above < 0 ? -1 : place[static_cast<std::size_t>(above)]});
    joint_nodes_.push_back(node);
  }
}

std::vector<std::optional<NamedJoint>> GltfPerformance::named_joints() const {
  std::vector<std::string> names;
  std::vector<int> parents;
  for (const auto& joint : joints_) {
    names.push_back(joint.name);
    parents.push_back(joint.parent);
  }
  return recon::name_joints(names, parents);
}

// Up runs from the feet to the head, left from the right thigh or shoulder to the left one: if both can be told and lie
// off their axes by 45 degrees and more, the character is turned by as many quarter turns as bring them there.
void GltfPerformance::orient() {
  const auto named = named_joints();
  const auto rest = recon::state_at(character_, nullptr, 0.0);
  using recon::Side;
  const auto where = [&](BodySegment segment, std::optional<Side> side) -> std::optional<Vector3d> {
    for (std::size_t j = named.size(); j-- > 0;)  // of a neck or spine of several joints the uppermost
      if (named[j] && named[j]->segment == segment && named[j]->side == side)
        return world_from_file_ * Vector3d(rest.file_from_node[joint_nodes_[j]].topRightCorner<3, 1>());
    return std::nullopt;
  };
  std::optional<Vector3d> head;
  for (const auto top : {BodySegment::head, BodySegment::neck, BodySegment::spine})
    if (!head) head = where(top, std::nullopt);
  const auto left_foot = where(BodySegment::foot, Side::left), right_foot = where(BodySegment::foot, Side::right);
  const auto left = where(BodySegment::thigh, Side::left), right = where(BodySegment::thigh, Side::right);
  if (!head || !left_foot || !right_foot || !left || !right) return;
  const auto nearest_axis = [](const Vector3d& v) {
    Eigen::Index axis = 0;
    v.cwiseAbs().maxCoeff(&axis);
    return Vector3d(Vector3d::Unit(axis) * (v[axis] < 0.0 ? -1.0 : 1.0));
  };
  const Vector3d up = nearest_axis(*head - 0.5 * (*left_foot + *right_foot)), to_left = nearest_axis(*left - *right);
  if (std::abs(up.dot(to_left)) > 0.5 || (up == Vector3d::UnitZ() && to_left == Vector3d::UnitY())) return;
  Matrix3d turn;
  turn << to_left.cross(up), to_left, up;
  world_from_file_ = Affine3d(turn.transpose()) * world_from_file_;
  notes_.emplace_back("its joints say that it does not stand upright and face +z: turned so that it does");
}

void GltfPerformance::scale() {
  constexpr recon::Plausible kPerson{0.5, 2.6};
  const double height = box_of(transformed(world_from_file_, in_file(state_at(0.0)))).sizes().maxCoeff();
  if (const auto unit = recon::unit_of(height, kPerson, recon::FileOf::surface)) {
    world_from_file_ = Eigen::Scaling(unit->metres) * world_from_file_;
    if (unit->metres != 1.0) notes_.push_back(fmt::format("{:.3g} units high: taken as {}", height, unit->name));
    return;
  }
  if (!(height > 1e-6 && height < 1e6)) throw InvalidInput(fmt::format("{}: {:.3g} units high", person_, height));
  notes_.push_back(fmt::format("{:.3g} units high, which no person is in any unit: scaled to 1.75 m", height));
  world_from_file_ = Eigen::Scaling(1.75 / height) * world_from_file_;
}

// The lowest point of the whole clip touches the floor, the middle of the ground it covers is the stage's.
void GltfPerformance::place() {
  constexpr int kMoments = 24;
  AlignedBox3d box;
  for (int i = 0; i < std::min(frames_, kMoments); ++i)
    box.extend(
        box_of(transformed(world_from_file_, in_file(state_at(i * frames_ * kActStep / std::min(frames_, kMoments))))));
  const Vector3d foot(box.center().x(), box.center().y(), box.min().z());
  world_from_file_ = Eigen::Translation3d(-foot) * world_from_file_;
}

std::vector<recon::TriangleMesh> GltfPerformance::surfaces_at(double seconds) const {
  const auto all = in_file(state_at(seconds));
  recon::TriangleMesh mesh = figures_.front().bind;
  for (std::size_t v = 0; v < source_.size(); ++v)
    mesh.positions[v] = (world_from_file_ * all[source_[v]].cast<double>()).cast<float>();
  recon::compute_normals(mesh);
  return {std::move(mesh)};
}

std::vector<JointState> GltfPerformance::joints_at(double seconds) const {
  const auto now = state_at(seconds), rest = recon::state_at(character_, nullptr, 0.0);
  const Matrix3d axes = world_from_file_.rotation();
  std::vector<JointState> states;
  std::vector<Eigen::Quaterniond> from_bind;  // in world
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const auto& transform = now.file_from_node[joint_nodes_[j]];
    const Eigen::Quaterniond turn(axes * turn_of(transform, rest.file_from_node[joint_nodes_[j]]).toRotationMatrix() *
                                  axes.transpose());
    from_bind.push_back(turn);
    const int parent = joints_[j].parent;
    const auto own = parent < 0 ? turn : from_bind[static_cast<std::size_t>(parent)].conjugate() * turn;
    states.push_back({world_from_file_ * Vector3d(transform.topRightCorner<3, 1>()), own.normalized()});
  }
  return states;
}

// Where a foot's joint has its heel: in the file's rest under it and a little behind, where the surface stands.
Vector3d GltfPerformance::heel_in_foot(std::size_t joint) const {
  const auto rest = recon::state_at(character_, nullptr, 0.0);
  const AlignedBox3d box = box_of(transformed(world_from_file_, in_file(rest)));
  const Affine3d world_from_foot = world_from_file_ * Affine3d(rest.file_from_node[joint_nodes_[joint]]);
  const Vector3d ankle = world_from_foot.translation();
  return world_from_foot.inverse() * Vector3d(ankle.x() - 0.03 * box.sizes().z(), ankle.y(), box.min().z());
}

std::vector<HeelStrike> GltfPerformance::heel_strikes() const {
  const auto named = named_joints();
  std::array<std::size_t, 2> foot{};
  std::array<Vector3d, 2> heel;
  for (const Side side : {Side::left, Side::right}) {
    const auto named_side = side == Side::left ? recon::Side::left : recon::Side::right;
    const auto found = std::find_if(named.begin(), named.end(), [&](const auto& joint) {
      return joint && joint->segment == BodySegment::foot && joint->side == named_side;
    });
    if (found == named.end()) return {};
    foot[at(side)] = static_cast<std::size_t>(found - named.begin());
    heel[at(side)] = heel_in_foot(foot[at(side)]);
    if (!heel[at(side)].allFinite()) return {};  // a joint scaled to nothing
  }
  const auto heights_at = [&](double seconds) {
    const auto state = state_at(seconds);
    std::array<double, 2> heights{};
    for (std::size_t i = 0; i < 2; ++i)
      heights[i] = (world_from_file_ * Affine3d(state.file_from_node[joint_nodes_[foot[i]]]) * heel[i]).z();
    return heights;
  };
  const double height = box_of(transformed(world_from_file_, in_file(state_at(0.0)))).sizes().z();
  return find_heel_strikes(heights_at, {frames_ * kActStep, is_cyclic_, height});
}

std::string GltfPerformance::fingerprint() const {
  Fingerprint print;
  add_to(print, figures_);
  add_nodes(print, character_);
  add_parts(print, character_);
  print.add_bytes(world_from_file_.data(), sizeof(double) * 16);
  if (clip_)
    for (const auto& track : clip_->tracks) {
      print.add(track.node);
      print.add(static_cast<int>(track.path));
      print.add(static_cast<int>(track.interpolation));
      add_all(print, track.times);
      add_all(print, track.values);
    }
  return print.text();
}

}  // namespace rotunda::simulator
