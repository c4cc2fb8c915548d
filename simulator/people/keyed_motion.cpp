#include "simulator/people/keyed_motion.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "simulator/people/acts/stand.h"
#include "simulator/people/key_curve.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kGrid = 0.01;        // seconds between samples of the weight's path
constexpr double kPendulum = 0.31;    // seconds: sqrt(height of the centre of mass / g)
constexpr double kEdge = 0.45;        // seconds in which idle's sway goes over into the table and back
constexpr double kHandDown = 0.22;    // seconds in which a hand comes to the floor
constexpr double kPalmHeight = 0.10;  // of the wrist over the floor

class Performer {
 public:
  Performer(const Skeleton& skeleton, KeyedMotion table, std::uint32_t seed)
      : skeleton_(skeleton),
        scale_(leg_scale(skeleton)),
        table_(std::move(table)),
        seed_(seed),
        seconds_(table_.frames * kActStep),
        feet_(skeleton, table_.feet) {
    for (const auto& key : table_.keys) keys_.push_back({key.seconds, values_of(key.posture)});
    plan_weight();
  }

  Pose pose_at(double seconds) const {
    const Posture idle = idle_at(seconds), posture = blend(idle, keyed(seconds), tabled(seconds));
    const Vector2d aside = Eigen::Rotation2Dd(radians(posture.yaw)) * Vector2d(posture.forward, posture.left);
    const Vector2d target = weight(seconds) + scale_ * aside;
    const double height = standing_height(skeleton_) + scale_ * posture.height;
    Pose pose = trunk_pose(skeleton_, posture, {target.x(), target.y(), height});
    for (int round = 0; round < 3; ++round) {  // the pelvis goes where it balances what the limbs do
      settle(pose, posture, height, seconds);
      pose.pelvis.head<2>() += target - centre_of_mass(skeleton_, pose).head<2>();
    }
    pose.pelvis.head<2>() += (1.0 - tabled(seconds)) * (idle_pelvis(seconds) - pose.pelvis.head<2>());
    settle(pose, posture, height, seconds);
    return pose;
  }

 private:
  double tabled(double seconds) const {
    return smooth_step(seconds / kEdge) * smooth_step((seconds_ - seconds) / kEdge);
  }
  // In the beginning idle's first moments, in the end its last.
  Posture idle_at(double seconds) const {
    const bool ending = seconds > 0.5 * seconds_;
    Posture posture = acts::idle_posture(ending ? seconds - seconds_ : seconds, seed_);
    if (ending) posture.yaw += table_.keys.back().posture.yaw;
    return posture;
  }
  Vector2d idle_pelvis(double seconds) const {
    const Posture idle = idle_at(seconds);
    const bool ending = seconds > 0.5 * seconds_;
    const double heading = ending ? table_.keys.back().posture.yaw : 0.0;
    const double at_time = ending ? seconds_ : 0.0;
    // Over the ankles' middle.
    const Pose none = bind_pose(skeleton_);
    Vector2d ankles = Vector2d::Zero();
    for (const Side side : {Side::left, Side::right})
      ankles += 0.5 * feet_.leg(side, at_time, leg_with(skeleton_, none, side, {})).ankle.head<2>();
    const double sway = idle.yaw - heading;
    return ankles + scale_ * (Eigen::Rotation2Dd(radians(heading + sway)) * Vector2d(idle.forward, idle.left));
  }

  // What is far from the trunk follows it a moment later.
  Posture keyed(double seconds) const {
    const auto at_time = [&](double when) { return posture_of(curve_at<kPostureValues>(keys_, when)); };
    Posture posture = at_time(seconds);
    const Posture later = at_time(seconds - 0.04), last = at_time(seconds - 0.08);
    for (std::size_t i = 0; i < 2; ++i) {
      posture.arm[i].elbow = later.arm[i].elbow;
      posture.arm[i].pronation = later.arm[i].pronation;
      posture.arm[i].wrist = last.arm[i].wrist;
      posture.arm[i].curl = last.arm[i].curl;
    }
    return posture;
  }

  void settle(Pose& pose, const Posture& posture, double height, double seconds) const {
    std::array<LegPlacement, 2> legs;
    pose.pelvis.z() = height;
    const Eigen::Quaterniond& hips = pose.rotation[index(Joint::pelvis)];
    for (const Side side : {Side::left, Side::right}) {
      const LegPosture& leg = posture.leg[at(side)];
      const LegAngles angles{radians(leg.hip), radians(leg.abduction), radians(leg.rotation), radians(leg.knee),
                             radians(leg.ankle)};
      legs[at(side)] = feet_.leg(side, seconds, leg_with(skeleton_, pose, side, angles));
    }
    for (auto& leg : legs) {  // a standing knee points between foot and pelvis
      const double standing = std::max(0.0, 1.0 - leg.slack);
      leg.knee = (leg.knee + 0.6 * standing * (hips * Vector3d::UnitX())).normalized();
    }
    stand_on(skeleton_, pose, legs);
    for (const auto& plant : table_.hands) reach_for(pose, plant, seconds);
    if (!table_.holds) return;
    for (const Side side : {Side::left, Side::right}) hold(pose, side, table_.holds(side, seconds));
  }

  void hold(Pose& pose, Side side, const HandHold& held) const {
    if (held.share <= 0.0) return;
    HandPlacement hand = hand_of(skeleton_, pose, side);
    hand.wrist += held.share * (held.hand.wrist - hand.wrist);
    hand.hand = hand.hand.slerp(held.share, held.hand.hand);
    hand.elbow = (hand.elbow + held.share * (held.hand.elbow - hand.elbow)).normalized();
    place_hand(skeleton_, pose, side, hand);
    Pose gripping = pose;
    curl_fingers(gripping, side, held.curl);
    gripping.rotation[index(on_side(Joint::thumb1_left, side))] =
        Eigen::AngleAxisd(-sign_of(side) * held.thumb, Vector3d::UnitX());
    const std::size_t last = index(on_side(Joint::little2_left, side));
    for (std::size_t i = index(on_side(Joint::thumb1_left, side)); i <= last; ++i)
      pose.rotation[i] = pose.rotation[i].slerp(held.share, gripping.rotation[i]);
  }

  double hand_share(const HandPlant& plant, double seconds) const {
    return smooth_step((seconds - plant.from + kHandDown) / kHandDown) *
           smooth_step((plant.until + kHandDown - seconds) / kHandDown);
  }

  void reach_for(Pose& pose, const HandPlant& plant, double seconds) const {
    const double share = hand_share(plant, seconds);
    if (share <= 0.0) return;
    HandPlacement hand = hand_of(skeleton_, pose, plant.side);
    const Vector2d place = scale_ * plant.at;
    const double yaw = radians(plant.yaw);
    const Vector3d fingers(std::cos(yaw), std::sin(yaw), -0.25);
    hand.wrist += share * (Vector3d(place.x(), place.y(), scale_ * kPalmHeight) - hand.wrist);
    hand.hand = hand.hand.slerp(share, hand_towards(skeleton_, plant.side, fingers, -Vector3d::UnitZ()));
    place_hand(skeleton_, pose, plant.side, hand);
  }

  // Where the floor carries the body: between the feet and hands that stand, by what they carry.
  Vector2d support(double seconds) const {
    constexpr double kLeast = 1e-3;  // while nothing stands
    Vector2d sum = Vector2d::Zero();
    double loads = 0.0;
    for (const Side side : {Side::left, Side::right}) {
      const double load = kLeast + feet_.load(side, seconds);
      sum += load * feet_.middle(side, seconds);
      loads += load;
    }
    for (const auto& plant : table_.hands) {
      const double load = 0.7 * hand_share(plant, seconds);
      sum += load * scale_ * plant.at;
      loads += load;
    }
    return sum / loads;
  }

  // The one path of the pendulum's weight that stays bounded: support convolved with exp(-|t| / T) / 2T.
  void plan_weight() {
    constexpr int kReach = 150;
    const int count = static_cast<int>(seconds_ / kGrid) + 4;
    std::vector<Vector2d> support_path;
    for (int i = -kReach; i < count + kReach; ++i)
      support_path.push_back(support(std::clamp(i * kGrid, 0.0, seconds_)));
    for (int i = 0; i < count; ++i) {
      Vector2d sum = Vector2d::Zero();
      double weights = 0.0;
      for (int j = -kReach; j <= kReach; ++j) {
        const double share = std::exp(-std::abs(j) * kGrid / kPendulum);
        sum += share * support_path[static_cast<std::size_t>(i + kReach + std::min(j, kReach - 1))];
        weights += share;
      }
      weight_.push_back({i * kGrid, {sum.x() / weights, sum.y() / weights}});
    }
  }
  Vector2d weight(double seconds) const {
    const double place = std::clamp(seconds / kGrid, 0.0, static_cast<double>(weight_.size()) - 3.0);
    const auto i = static_cast<std::size_t>(place);
    const double t = place - static_cast<double>(i);
    const auto& before = weight_[i == 0 ? 0 : i - 1].value;
    const auto &from = weight_[i].value, &to = weight_[i + 1].value, &after = weight_[i + 2].value;
    const auto along = [&](std::size_t c) {
      return hermite(t, from[c], to[c], 0.5 * (to[c] - before[c]), 0.5 * (after[c] - from[c]));
    };
    return {along(0), along(1)};
  }

  Skeleton skeleton_;
  double scale_;
  KeyedMotion table_;
  std::uint32_t seed_;
  double seconds_;
  Footwork feet_;
  std::vector<CurveKey<kPostureValues>> keys_;
  std::vector<CurveKey<2>> weight_;
};

struct Segment {
  Joint from, to;       // the proximal joint's centre and the distal one's
  double mass, centre;  // shares of the body's mass and of the way from one to the other
};
constexpr std::array<Segment, 3> kTrunk = {{{Joint::pelvis, Joint::chest, 0.275, 0.35},
                                            {Joint::chest, Joint::neck, 0.1596, 0.5},
                                            {Joint::neck, Joint::head, 0.0694, 1.8}}};
constexpr std::array<Segment, 5> kLimb = {{{Joint::upper_arm_left, Joint::forearm_left, 0.0271, 0.577},
                                           {Joint::forearm_left, Joint::hand_left, 0.0223, 0.6},
                                           {Joint::thigh_left, Joint::shank_left, 0.1416, 0.41},
                                           {Joint::shank_left, Joint::foot_left, 0.0433, 0.446},
                                           {Joint::foot_left, Joint::toes_left, 0.0137, 0.5}}};

}  // namespace

Vector3d centre_of_mass(const Skeleton& skeleton, const Pose& pose) {
  const auto centres = joint_centres(skeleton, pose);
  Vector3d sum = Vector3d::Zero();
  double mass = 0.0;
  const auto add = [&](Joint from, Joint to, const Segment& segment) {
    const Vector3d &a = centres[index(from)], &b = centres[index(to)];
    sum += segment.mass * (a + segment.centre * (b - a));
    mass += segment.mass;
  };
  for (const auto& segment : kTrunk) add(segment.from, segment.to, segment);
  for (const auto& segment : kLimb)
    for (const Side side : {Side::left, Side::right})
      add(on_side(segment.from, side), on_side(segment.to, side), segment);
  return sum / mass;
}

Motion keyed_motion(const Skeleton& skeleton, const KeyedMotion& table, std::uint32_t seed) {
  const auto performer = std::make_shared<const Performer>(skeleton, table, seed);
  std::vector<HeelStrike> strikes;
  for (const auto& step : table.feet.steps) strikes.push_back({step.land, step.side});
  return {table.name, table.frames, false, strikes,
          [performer](double seconds) { return performer->pose_at(seconds); }};
}

}  // namespace rotunda::simulator
