#include "rig/cli/live_mocap.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "config/errors.h"
#include "rig/client.h"
#include "rig/motion_frame.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using recon::LiveMotionState;

double delay_ms(const MotionFrame& frame) {
  return std::chrono::duration<double, std::milli>(frame.made - frame.exposure).count();
}

json to_json(const MotionFrame& frame) {
  json line{{"trigger", frame.trigger},
            {"exposure_ns", frame.exposure.time_since_epoch().count()},
            {"state", recon::to_string(frame.motion.state)},
            {"delay_ms", delay_ms(frame)}};
  if (!frame.motion.why.empty()) line["why"] = frame.motion.why;
  if (!frame.motion.body) return line;
  line["height_m"] = recon::height_of(frame.motion.body->measures);
  const auto positions = recon::joint_positions(frame.motion.body->skeleton, frame.motion.fit.pose);
  for (std::size_t j = 0; j < recon::kBodyJoints; ++j)
    line["joints"][std::string(recon::to_string(recon::body_joint(j)))] = {
        {"position", {positions[j].x(), positions[j].y(), positions[j].z()}},
        {"confidence", frame.motion.fit.confidence[j]}};
  return line;
}

// Once a second, on stderr.
class Teller {
 public:
  void tell(const MotionFrame& frame) {
    ++frames_;
    const auto now = std::chrono::steady_clock::now();
    if (now - told_ < 1s) return;
    const double rate = frames_ / std::chrono::duration<double>(now - told_).count();
    told_ = now;
    frames_ = 0;
    if (!frame.motion.why.empty())
      fmt::print(stderr, "{}: {}\n", recon::to_string(frame.motion.state), frame.motion.why);
    else if (frame.motion.body)
      fmt::print(stderr, "{}: a person {:.2f} m tall, {:.1f} frames a second, {:.0f} ms late\n",
                 recon::to_string(frame.motion.state), recon::height_of(frame.motion.body->measures), rate,
                 delay_ms(frame));
  }

 private:
  int frames_ = 0;
  std::chrono::steady_clock::time_point told_ = std::chrono::steady_clock::now();
};

recon::TrackedPose tracked_pose(const recon::LiveMotionFrame& motion) {
  auto state = recon::TrackState::tracked;
  if (motion.state == LiveMotionState::recovered) state = recon::TrackState::recovered;
  if (motion.state == LiveMotionState::lost) state = recon::TrackState::lost;
  return {motion.fit, state, motion.why};
}

using Followed = std::map<long, recon::TrackedPose>;  // by frames of the rig since the first

recon::TrackedPose pose_at(const Followed& followed, long frame) {
  const auto after = followed.lower_bound(frame);
  if (after->first == frame) return after->second;
  const auto before = std::prev(after);
  auto pose = before->second;
  const double share = static_cast<double>(frame - before->first) / static_cast<double>(after->first - before->first);
  pose.fit.pose = recon::interpolate(pose.fit.pose, after->second.fit.pose, share);
  return pose;
}

class LiveRecording {
 public:
  LiveRecording(const LiveMocapRequest& request, double fps) : request_(request), fps_(fps) {}

  // False once there is as much as was asked for.
  bool add(const MotionFrame& frame) {
    if (request_.json) {
      fmt::print("{}\n", to_json(frame).dump());
      std::fflush(stdout);
    } else {
      teller_.tell(frame);
    }
    if (!frame.motion.body) return true;
    if (!begun_) begun_ = frame.exposure;
    body_ = frame.motion.body;
    const double seconds = std::chrono::duration<double>(frame.exposure - *begun_).count();
    followed_[std::lround(seconds * fps_)] = tracked_pose(frame.motion);
    return request_.seconds <= 0.0 || seconds < request_.seconds;
  }

  recon::CapturedMotion motion() const {
    if (followed_.empty()) return {};
    recon::CapturedMotion motion{.body = *body_, .fps = fps_};
    for (long frame = 0; frame <= followed_.rbegin()->first; ++frame)
      motion.frames.push_back(pose_at(followed_, frame));
    return motion;
  }

 private:
  const LiveMocapRequest& request_;
  const double fps_;  // the rig's
  Teller teller_;
  std::optional<capture::Timestamp> begun_;
  std::optional<recon::BodyTemplate> body_;  // as it was measured last
  Followed followed_;
};

}  // namespace

recon::CapturedMotion capture_live(const LiveMocapRequest& request, std::stop_token stop) {
  RigClient client(request.socket);
  const auto status = client.status();
  if (status.state == "armed" || status.state == "idle")
    throw DeviceError("live", fmt::format("the rig is {}; have its cameras triggered: rotunda rig live", status.state));
  LiveRecording recording(request, status.rate_hz);
  client.watch_motion([&](MotionFrame&& frame) { return recording.add(frame); }, std::move(stop));
  return recording.motion();
}

}  // namespace rotunda::rig
