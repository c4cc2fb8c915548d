// The moving half of gltf_character.h: clips sampled as glTF 2.0, appendix C, has it; then nodes, morphs, skins.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "recon/gltf/gltf_character.h"

namespace rotunda::recon {
namespace {

using Eigen::Matrix4d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// A key and how far the moment lies between it and the next one.
struct KeyPlace {
  std::size_t key;
  double share, span;  // span: seconds between the two
};

KeyPlace place_of(const std::vector<float>& times, double seconds) {
  const auto after = std::upper_bound(times.begin(), times.end(), seconds,
                                      [](double s, float time) { return s < static_cast<double>(time); });
  if (after == times.begin()) return {0, 0.0, 0.0};
  const auto key = static_cast<std::size_t>(after - times.begin()) - 1;
  if (after == times.end()) return {key, 0.0, 0.0};
  const double span = static_cast<double>(*after) - static_cast<double>(times[key]);
  return {key, (seconds - static_cast<double>(times[key])) / span, span};
}

Quaterniond quaternion(const Eigen::VectorXd& v) {
  const Quaterniond q(v[3], v[0], v[1], v[2]);
  return q.norm() > 1e-9 ? q.normalized() : Quaterniond::Identity();
}

class Sampled {
 public:
  Sampled(const CharacterTrack& track, double seconds) : track_(track), at_(place_of(track.times, seconds)) {}

  Eigen::VectorXd value() const {
    if (at_.span <= 0.0 || track_.interpolation == TrackInterpolation::step) return key(at_.key);
    if (track_.interpolation == TrackInterpolation::cubic_spline) return spline();
    return (1.0 - at_.share) * key(at_.key) + at_.share * key(at_.key + 1);
  }
  Quaterniond rotation() const {
    if (at_.span <= 0.0 || track_.interpolation != TrackInterpolation::linear) return quaternion(value());
    return quaternion(key(at_.key)).slerp(at_.share, quaternion(key(at_.key + 1)));
  }

 private:
  Eigen::VectorXd row(std::size_t index) const {
    const auto width = static_cast<Eigen::Index>(track_.width);
    return Eigen::Map<const Eigen::VectorXf>(track_.values.data() + index * track_.width, width).cast<double>();
  }
  bool is_cubic() const { return track_.interpolation == TrackInterpolation::cubic_spline; }
  Eigen::VectorXd key(std::size_t k) const { return row(is_cubic() ? 3 * k + 1 : k); }
  Eigen::VectorXd spline() const {
    const double t = at_.share, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * key(at_.key) + at_.span * (t3 - 2 * t2 + t) * row(3 * at_.key + 2) +
           (3 * t2 - 2 * t3) * key(at_.key + 1) + at_.span * (t3 - t2) * row(3 * (at_.key + 1));
  }

  const CharacterTrack& track_;
  KeyPlace at_;
};

void apply(const CharacterTrack& track, double seconds, CharacterNode& node) {
  const Sampled sampled(track, seconds);
  if (track.path != TrackPath::morph_weights) node.matrix.reset();  // an animated node has none by the standard
  if (track.path == TrackPath::rotation) node.rotation = sampled.rotation();
  if (track.path == TrackPath::translation) node.translation = sampled.value();
  if (track.path == TrackPath::scale) node.scale = sampled.value();
  if (track.path != TrackPath::morph_weights) return;
  const Eigen::VectorXf weights = sampled.value().cast<float>();
  node.morph_weights.assign(weights.begin(), weights.end());
}

Matrix4d local(const CharacterNode& node) {
  if (node.matrix) return *node.matrix;
  return (Eigen::Translation3d(node.translation) * node.rotation * Eigen::Scaling(node.scale)).matrix();
}

Eigen::Vector3f morphed(const CharacterPart& part, const std::vector<float>& weights, std::size_t v) {
  Eigen::Vector3f p = part.positions[v];
  for (std::size_t m = 0; m < std::min(weights.size(), part.morphs.size()); ++m)
    if (weights[m] != 0.0F) p += weights[m] * part.morphs[m][v];
  return p;
}

using Transform = Eigen::Matrix<float, 3, 4>;

std::vector<Transform> joint_transforms(const GltfCharacter& character, const CharacterPart& part,
                                        const CharacterState& state) {
  if (part.skin < 0) return {state.file_from_node[part.node].topRows<3>().cast<float>()};
  const auto& skin = character.skins[static_cast<std::size_t>(part.skin)];
  std::vector<Transform> transforms;
  for (std::size_t j = 0; j < skin.joints.size(); ++j)
    transforms.emplace_back((state.file_from_node[skin.joints[j]] * skin.inverse_bind[j]).topRows<3>().cast<float>());
  return transforms;
}

Transform blended(const std::vector<Transform>& transforms, const Influences& influences) {
  Transform sum = Transform::Zero();
  for (const auto& influence : influences)
    if (influence.weight != 0.0F) sum += influence.weight * transforms[influence.joint];
  return sum;
}

}  // namespace

CharacterState state_at(const GltfCharacter& character, const CharacterClip* clip, double seconds) {
  auto nodes = character.nodes;
  if (clip)
    for (const auto& track : clip->tracks) apply(track, seconds, nodes[track.node]);
  CharacterState state;
  for (const auto& node : nodes) {
    state.file_from_node.push_back(
        node.parent < 0 ? local(node) : state.file_from_node[static_cast<std::size_t>(node.parent)] * local(node));
    state.morph_weights.push_back(node.morph_weights);
  }
  return state;
}

std::vector<Eigen::Vector3f> posed_positions(const GltfCharacter& character, const CharacterPart& part,
                                             const CharacterState& state) {
  const auto transforms = joint_transforms(character, part, state);
  const auto& weights = state.morph_weights[part.node];
  std::vector<Eigen::Vector3f> posed(part.positions.size());
  tbb::parallel_for(std::size_t{0}, posed.size(), [&](std::size_t v) {
    const Transform& transform = part.skin < 0 ? transforms.front() : blended(transforms, part.influences[v]);
    posed[v] = transform * morphed(part, weights, v).homogeneous();
  });
  return posed;
}

}  // namespace rotunda::recon
