#include "recon/body/body_track.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>

#include "config/errors.h"
#include "recon/video/temporal_filter.h"

namespace rotunda::recon {
namespace {

using nlohmann::json;

double finite(const json& number) {
  const double value = number.get<double>();
  if (!std::isfinite(value)) throw CorruptData("a number that is not finite");
  return value;
}

std::optional<Pose> pose_of(const json& frame) {
  if (frame.at("state") == "lost") return std::nullopt;
  Pose pose = rest_pose();
  const auto& root = frame.at("positions").at(0);
  for (std::size_t c = 0; c < 3; ++c) pose.root[static_cast<Eigen::Index>(c)] = finite(root.at(c));
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const auto& q = frame.at("rotations").at(j);
    pose.rotation[j] = {finite(q.at(0)), finite(q.at(1)), finite(q.at(2)), finite(q.at(3))};
    if (!(pose.rotation[j].norm() > 0.5)) throw CorruptData("a rotation that is none");
    pose.rotation[j].normalize();
  }
  return pose;
}

BodyTrack parse(const json& file) {
  BodyMeasures measures{};
  for (std::size_t m = 0; m < kBodyMeasures; ++m)
    measures[m] = finite(file.at("measures").at(std::string(to_string(static_cast<BodyMeasure>(m)))));
  BodyTrack track{.body = make_template(measures), .first_frame = 0, .poses = {}};
  const auto& frames = file.at("frames");
  if (!frames.empty()) track.first_frame = frames.at(0).at("frame").get<std::size_t>();
  for (const auto& frame : frames) track.poses.push_back(pose_of(frame));
  return track;
}

std::vector<Pose> bridged(const std::vector<std::optional<Pose>>& poses) {
  std::vector<Pose> all;
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) continue;
    const Pose& next = *poses[i];
    const auto first = last ? *last + 1 : 0;
    for (std::size_t k = first; k < i; ++k)
      all.push_back(
          last ? interpolate(*poses[*last], next, static_cast<double>(k - *last) / static_cast<double>(i - *last))
               : next);
    all.push_back(next);
    last = i;
  }
  if (last) all.resize(poses.size(), *poses[*last]);
  return all;
}

// What would move far is no noise of a fit but a motion quicker than a cubic can follow (temporal_filter.h has the
// same): a share of the way, none of it from `limit` on.
Eigen::Vector3d bounded(const Eigen::Vector3d& way, double limit) {
  const double share = way.norm() / limit;
  const double rest = 1.0 - share * share;
  return share < 1.0 ? Eigen::Vector3d(rest * rest * way) : Eigen::Vector3d::Zero();
}

// The cubic's value at frame `at` of seven poses, in the tangent space of the pose there.
Pose steadied(std::span<const Pose> window, std::size_t at) {
  const auto weights = filter_weights(static_cast<int>(at));
  Pose pose = window[at];
  constexpr double kRootLimit = 0.01, kTurnLimit = 0.06;  // metres, radians: three times what fits scatter by
  Eigen::Vector3d root = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < window.size(); ++i) root += weights[i] * (window[i].root - pose.root);
  pose.root += bounded(root, kRootLimit);
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < window.size(); ++i) {
      auto off = window[at].rotation[j].conjugate() * window[i].rotation[j];
      if (off.w() < 0.0) off.coeffs() *= -1.0;
      const Eigen::AngleAxisd way(off);
      turn += weights[i] * way.angle() * way.axis();
    }
    turn = bounded(turn, kTurnLimit);
    const double angle = turn.norm();
    if (angle > 0.0)
      pose.rotation[j] =
          (window[at].rotation[j] * Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle))).normalized();
  }
  return pose;
}

// Nobody moves like that from one frame to the next: the take goes on elsewhere, as where clips were put together.
bool is_cut(const Pose& before, const Pose& after) {
  constexpr double kStep = 0.5;  // metres; a sprinter at 25 frames/s makes 0.42
  constexpr double kTurn = 1.2;  // radians; a fast pirouette makes 0.75
  return (after.root - before.root).norm() > kStep || before.rotation[0].angularDistance(after.rotation[0]) > kTurn;
}

// Filters poses in place; too few for the filter stay as they are.
void steady(std::span<Pose> poses) {
  if (poses.size() < kFilterFrames) return;
  const std::vector<Pose> raw(poses.begin(), poses.end());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const auto first = std::min(i < kFilterFrames / 2 ? 0 : i - kFilterFrames / 2, raw.size() - kFilterFrames);
    poses[i] = steadied(std::span(raw).subspan(first, kFilterFrames), i - first);
  }
}

}  // namespace

std::optional<Pose> BodyTrack::pose(std::size_t frame) const {
  if (frame < first_frame || frame - first_frame >= poses.size()) return std::nullopt;
  return poses[frame - first_frame];
}

BodyTrack steadied(const BodyTrack& track) {
  auto all = bridged(track.poses);
  for (std::size_t begin = 0, end = 1; begin < all.size(); begin = end++) {
    while (end < all.size() && !is_cut(all[end - 1], all[end])) ++end;
    steady(std::span(all).subspan(begin, end - begin));
  }
  BodyTrack result = track;
  std::copy(all.begin(), all.end(), result.poses.begin());
  return result;
}

BodyTrack track_of(const CapturedMotion& motion) {
  BodyTrack track{.body = motion.body, .first_frame = motion.first_frame, .poses = {}};
  for (const auto& frame : motion.frames)
    track.poses.push_back(frame.state == TrackState::lost ? std::nullopt : std::optional(frame.fit.pose));
  return track;
}

BodyTrack read_joints_json(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::system_error(errno, std::generic_category(), file.string());
  try {
    return parse(json::parse(stream));
  } catch (const json::exception& e) {
    throw CorruptData(file.string() + ": is no motion that rotunda wrote: " + e.what());
  } catch (const CorruptData& e) {
    throw CorruptData(file.string() + ": " + e.what());
  } catch (const InvalidInput& e) {
    throw CorruptData(file.string() + ": " + e.what());
  }
}

}  // namespace rotunda::recon
