#include "rig/daemon/live_session.h"

#include <pthread.h>
#include <spdlog/spdlog.h>

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

// A live picture that is later than this is not waited for.
constexpr auto kDeadline = 150ms;
constexpr auto kPulse = capture::kLookForSilence;

FrameSetStreamOptions stream_options(const config::RigConfig& rig) {
  FrameSetStreamOptions options{.trigger = rig.trigger, .wanted = std::nullopt, .cameras = {}, .deadline = kDeadline};
  for (const auto& camera : rig.cameras) options.cameras.push_back(camera.name);
  return options;
}

}  // namespace

LiveSession::LiveSession(const config::RigConfig& rig, CameraFleet& fleet, Onlooker onlooker)
    : stream_(stream_options(rig), fleet) {
  stream_.start([this, look = std::move(onlooker)](capture::FrameSet&& set) { look(set, stream_.cameras()); });
  thread_ = std::jthread([this](const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), "live");
    while (!stop.stop_requested() && stream_.advance()) {
      for (const auto& incident : stream_.take_incidents()) spdlog::warn("live: {}", incident);
      std::this_thread::sleep_for(kPulse);
    }
  });
}

LiveSession::~LiveSession() {
  thread_ = {};
  stream_.stop();
}

}  // namespace rotunda::rig
