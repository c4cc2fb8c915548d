#include "simulator/people/cloth_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rotunda::simulator {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kSteps = 10;           // a frame
constexpr double kSlowest = 4.4;     // radians a second with which cloth that hangs free swings: a pendulum of 0.5 m
constexpr double kGravity = 9.81;    // m/s^2
constexpr double kDrag = 2.5;        // 1/s, of light cloth in still air
constexpr double kRubbing = 3.0;     // 1/s, of cloth on itself: takes its motion against the body away
constexpr double kOwnWeight = 0.15;  // share of its weight the bind pose does not show yet
constexpr double kShear = 2e-6;      // compliance of a bond when it is pressed, m/N at a kilogram a particle
constexpr double kBend = 2e-4;       // and over a neighbour
constexpr double kFarthest = 0.17;   // metres from its skinned place
constexpr double kFastest = 6.0;     // m/s
constexpr double kOffLimb = 0.008;   // metres cloth keeps off a leg's surface
constexpr double kOffArm = 0.006;    // and off an arm's
constexpr double kOffFloor = 0.015;
constexpr double kSettle = 5.0;     // seconds of warm-up
constexpr double kClosed = 0.0005;  // metres a round may differ from the one before

struct PosedLimb {
  Vector3d a, b;
  double radius_a, radius_b;
};

std::vector<PosedLimb> posed_limbs(const std::vector<LimbCapsule>& limbs, const JointTransforms& world_from_bind) {
  std::vector<PosedLimb> posed;
  for (const auto& limb : limbs) {
    const auto& carried = world_from_bind[index(limb.joint)];
    posed.push_back({carried * limb.a, carried * limb.b, limb.radius_a, limb.radius_b});
  }
  return posed;
}

Vector3d out_of_limbs(const std::vector<PosedLimb>& limbs, double off, Vector3d p) {
  for (const auto& limb : limbs) {
    const Depth depth = depth_in(limb.a, limb.b, limb.radius_a + off, limb.radius_b + off, p);
    if (depth.metres > 0.0) p += depth.metres * depth.out;
  }
  return p;
}

// An arm presses the cloth inwards, down to the body, which lies `room` below it; where the arm is deeper in than that
// the cloth stays, as cloth that lies over the arm would.
Vector3d under_arms(const std::vector<PosedLimb>& arms, double off, double room, const Vector3d& normal, Vector3d p) {
  for (const auto& arm : arms) {
    const Depth depth = depth_in(arm.a, arm.b, arm.radius_a + off, arm.radius_b + off, p);
    const double inwards = -depth.out.dot(normal);
    if (depth.metres <= 0.0 || inwards < 0.2) continue;
    const double way = std::min(depth.metres / inwards, room);
    p -= way * normal;
    room -= way;
  }
  return p;
}

// Where the skeleton alone would put a particle.
struct SkinnedPlace {
  Vector3d position, normal;
  Matrix3d turn;  // from the bind pose
};

class Simulation {
 public:
  Simulation(const Person& person, const std::function<Pose(double)>& pose_at)
      : person_(person), cloth_(person.cloth), pose_at_(pose_at) {
    for (const auto& particle : cloth_.particles) {
      const double stiffness = kSlowest / std::pow(std::max(particle.looseness, 0.03), 1.3);
      pull_.push_back(stiffness * stiffness);
    }
    place_all(0.0);
    for (const auto& place : places_) position_.push_back(place.position);
    velocity_.assign(position_.size(), Vector3d::Zero());
  }

  // From `seconds` to a frame later.
  void run_frame(double seconds, double frame_seconds) {
    const double h = frame_seconds / kSteps;
    for (int step = 1; step <= kSteps; ++step) run_step(seconds + step * h, h);
  }

  // Stands in the pose of the start until it is at rest.
  void settle(double frame_seconds) {
    const double h = frame_seconds / kSteps;
    for (double time = 0.0; time < kSettle; time += h) run_step(0.0, h);
  }

  std::vector<Vector3f> offsets() const {
    std::vector<Vector3f> offsets(position_.size());
    for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = (position_[i] - places_[i].position).cast<float>();
    return offsets;
  }

 private:
  void place_all(double seconds) {
    const auto transforms = joint_transforms(person_.skeleton, pose_at_(seconds));
    places_.resize(cloth_.particles.size());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const auto vertex = cloth_.particles[i].vertex;
      const auto& weights = person_.weights[vertex];
      Eigen::Matrix<double, 3, 4> blend = Eigen::Matrix<double, 3, 4>::Zero();
      for (std::size_t k = 0; k < weights.joint.size(); ++k)
        blend += static_cast<double>(weights.weight[k]) * transforms[weights.joint[k]].matrix().topRows<3>();
      const Matrix3d turn = blend.leftCols<3>();
      places_[i].position = blend * person_.bind.positions[vertex].cast<double>().homogeneous();
      places_[i].normal = (turn * person_.bind.normals[vertex].cast<double>()).normalized();
      places_[i].turn = turn;
    }
    limbs_ = posed_limbs(cloth_.limbs, transforms);
    arms_ = posed_limbs(cloth_.arms, transforms);
  }

  void run_step(double seconds, double h) {
    before_ = position_;
    const auto places_before = places_;
    place_all(seconds);
    const double kept = std::exp(-kDrag * h), rubbed = 1.0 - std::exp(-kRubbing * h);
    for (std::size_t i = 0; i < position_.size(); ++i) {
      // The bind pose hangs in its own weight already: what holds it there turns with the body.
      const Vector3d force = kGravity * ((1.0 - kOwnWeight) * places_[i].turn.col(2) - Vector3d::UnitZ());
      velocity_[i] = kept * (velocity_[i] + h * force);
      velocity_[i] += rubbed * ((places_[i].position - places_before[i].position) / h - velocity_[i]);
      const double speed = velocity_[i].norm();
      if (speed > kFastest) velocity_[i] *= kFastest / speed;
      position_[i] += h * velocity_[i];
      const double pull = pull_[i] * h * h;
      position_[i] += (places_[i].position - position_[i]) * (pull / (1.0 + pull));
    }
    for (const auto& bond : cloth_.bonds) keep_length(bond, h);
    for (std::size_t i = 0; i < position_.size(); ++i) {
      keep_outside(i);
      velocity_[i] = (position_[i] - before_[i]) / h;
    }
  }

  // Macklin et al. 2016, eq. (18), one iteration a step. A bond is as long as in the bind pose where cloth is loose, as
  // on the skinned surface where it is close; it resists being drawn out, and folds when pressed.
  void keep_length(const ClothBond& bond, double h) {
    const double loose =
        std::min(1.0, 0.5 * (cloth_.particles[bond.a].looseness + cloth_.particles[bond.b].looseness) * 2.0);
    const double skinned = (places_[bond.a].position - places_[bond.b].position).norm();
    const double length = skinned + loose * (bond.length - skinned);
    const Vector3d apart = position_[bond.a] - position_[bond.b];
    const double now = std::max(apart.norm(), 1e-6);
    const double compliance = bond.bends ? kBend : (now < length ? kShear : 0.0);
    const double weight_a = inverse_mass(bond.a), weight_b = inverse_mass(bond.b);
    const double shift = (now - length) / (weight_a + weight_b + compliance / (h * h));
    position_[bond.a] -= weight_a * shift / now * apart;
    position_[bond.b] += weight_b * shift / now * apart;
  }

  // Cloth that sits close is held by the body: as if heavy.
  double inverse_mass(std::size_t particle) const { return 0.05 + 0.95 * cloth_.particles[particle].looseness; }

  void keep_outside(std::size_t i) {
    const auto& particle = cloth_.particles[i];
    Vector3d offset = position_[i] - places_[i].position;
    const double farthest = kFarthest * (0.15 + 0.85 * particle.looseness) * std::min(1.0, 4.0 * particle.looseness);
    const double distance = offset.norm();
    if (distance > farthest) offset *= farthest / distance;
    const double inwards = -offset.dot(places_[i].normal) - particle.clearance;
    if (!particle.off_body && inwards > 0.0) offset += inwards * places_[i].normal;
    Vector3d p = places_[i].position + offset;
    if (particle.meets_arms) {
      const double room =
          particle.hangs ? kFarthest : std::max(0.0, particle.clearance + offset.dot(places_[i].normal));
      p = under_arms(arms_, kOffArm, room, places_[i].normal, p);
    }
    if (particle.hangs) p = out_of_limbs(limbs_, kOffLimb, p);
    if (particle.off_body) p = out_of_body(i, p);
    p.z() = std::max(p.z(), std::min(kOffFloor, places_[i].position.z()));
    position_[i] = p;
  }

  // About a particle's own place the body is as in the bind pose, turned along.
  Vector3d out_of_body(std::size_t i, const Vector3d& p) const {
    const auto& particle = cloth_.particles[i];
    const Vector3d at_rest = person_.bind.positions[particle.vertex].cast<double>();
    const Matrix3d back = places_[i].turn.inverse();  // blended: not quite a rotation
    const Vector3d in_bind = at_rest + back * (p - places_[i].position);
    const Vector3d out = cloth_.body.pushed_out(in_bind, *particle.off_body);
    return p + places_[i].turn * (out - in_bind);
  }

  const Person& person_;
  const Cloth& cloth_;
  const std::function<Pose(double)>& pose_at_;
  std::vector<double> pull_;
  std::vector<SkinnedPlace> places_;
  std::vector<PosedLimb> limbs_, arms_;
  std::vector<Vector3d> position_, velocity_, before_;
};

double largest_difference(const std::vector<Vector3f>& a, const std::vector<Vector3f>& b) {
  float largest = 0.0F;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return static_cast<double>(largest);
}

// Spreads what the last frame differs from the first over the round, then drops it.
void close_round(std::vector<std::vector<Vector3f>>& offsets) {
  const auto last = offsets.back();
  const auto first = offsets.front();
  offsets.pop_back();
  for (std::size_t f = 0; f < offsets.size(); ++f) {
    const float share = static_cast<float>(f) / static_cast<float>(offsets.size());
    for (std::size_t i = 0; i < first.size(); ++i) offsets[f][i] -= share * (last[i] - first[i]);
  }
}

Vector3f follow(const ClothFollower& follower, const std::vector<Vector3f>& offsets) {
  Vector3f sum = Vector3f::Zero();
  for (std::size_t k = 0; k < follower.particle.size(); ++k) sum += follower.share[k] * offsets[follower.particle[k]];
  return sum;
}

}  // namespace

ClothMotion::ClothMotion(const Person& person, const std::function<Pose(double)>& pose_at,
                         const ClothMotionOptions& options)
    : options_(options) {
  Simulation simulation(person, pose_at);
  if (person.cloth.particles.empty()) return;
  simulation.settle(options.frame_seconds);
  const double round = options.frames * options.frame_seconds;
  const int rounds = options.is_cyclic ? std::clamp(static_cast<int>(std::ceil(kSettle / round)) + 1, 2, 40) : 1;
  for (int i = 0; i < rounds; ++i) {
    offsets_.clear();
    offsets_.push_back(simulation.offsets());
    for (int frame = 0; frame < options.frames; ++frame) {
      simulation.run_frame(frame * options.frame_seconds, options.frame_seconds);
      offsets_.push_back(simulation.offsets());
    }
    closing_error_ = largest_difference(offsets_.front(), offsets_.back());
    if (closing_error_ < kClosed) break;
  }
  if (options.is_cyclic) close_round(offsets_);
}

std::vector<Vector3f> ClothMotion::offsets_at(double seconds) const {
  if (offsets_.empty()) return {};
  const int count = static_cast<int>(offsets_.size());
  const double place = seconds / options_.frame_seconds;
  const int base = static_cast<int>(std::floor(place));
  const auto t = static_cast<float>(place - base);
  const auto at = [&](int frame) -> const std::vector<Vector3f>& {
    const int inside = options_.is_cyclic ? (frame % count + count) % count : std::clamp(frame, 0, count - 1);
    return offsets_[static_cast<std::size_t>(inside)];
  };
  const auto &a = at(base - 1), &b = at(base), &c = at(base + 1), &d = at(base + 2);
  std::vector<Vector3f> offsets(b.size());
  for (std::size_t i = 0; i < offsets.size(); ++i)  // Catmull and Rom 1974
    offsets[i] =
        b[i] +
        0.5F * t * (c[i] - a[i] + t * (2 * a[i] - 5 * b[i] + 4 * c[i] - d[i] + t * (3 * (b[i] - c[i]) + d[i] - a[i])));
  return offsets;
}

void ClothMotion::move(const Person& person, const JointTransforms& world_from_bind, double seconds,
                       recon::TriangleMesh& skinned) const {
  if (offsets_.empty()) return;
  const Cloth& cloth = person.cloth;
  const auto offsets = offsets_at(seconds);
  const auto limbs = posed_limbs(cloth.limbs, world_from_bind);
  std::vector<Vector3f> moved(skinned.positions.size(), Vector3f::Zero());
  for (const auto& follower : cloth.followers) {
    const Vector3f& from = skinned.positions[follower.vertex];
    Vector3f to = from + follow(follower, offsets);
    if (follower.hangs) to = out_of_limbs(limbs, 0.5 * kOffLimb, to.cast<double>()).cast<float>();
    moved[follower.vertex] = to - from;
  }
  for (const auto& follower : cloth.lining) moved[follower.vertex] = follow(follower, offsets);
  constexpr int kSmoothing = 12;  // rounds: the lining spans evenly from hem to legs
  for (int round = 0; round < kSmoothing; ++round)
    for (std::size_t i = 0; i < cloth.lining.size(); ++i) {
      Vector3f mean = Vector3f::Zero();
      for (const auto n : cloth.round[i]) mean += moved[n];
      moved[cloth.lining[i].vertex] = mean / static_cast<float>(cloth.round[i].size());
    }
  for (std::size_t v = 0; v < moved.size(); ++v) skinned.positions[v] += moved[v];
  recon::compute_normals(skinned);
}

}  // namespace rotunda::simulator
