#include "rig/tui/page_state.h"

#include <algorithm>
#include <cmath>

namespace rotunda::rig {
namespace {

constexpr double kLeastSilence_s = 0.3;
constexpr double kClippedMuch = 0.02;
constexpr double kOffMuch_us = 1000.0;

// A frame is a period, an exposure and a transfer away from the one before; half a period covers what is late.
double silence_limit(double rate_hz) {
  return std::max(kLeastSilence_s, rate_hz > 0.0 ? 1.5 / rate_hz + 0.1 : 0.0);
}

}  // namespace

void take_status(PageState& state, const RigStatus& status) {
  for (const auto& camera : status.cameras) {
    if (!camera.focus) continue;
    auto& peak = state.peak[camera.name];
    peak = std::max(peak, *camera.focus);
  }
  if (!state.slate_known && !status.take.name.empty()) {
    state.scene = status.take.scene;
    state.shot = status.take.shot;
    state.slate_known = true;
  }
  state.status = status;
  state.status_age_s = 0.0;
  state.trouble.clear();
}

Health health_of(const CameraStatus& camera, double rate_hz) {
  if (camera.state != "streaming" || camera.silent_s > silence_limit(rate_hz)) return Health::lost;
  const bool drops =
      std::any_of(camera.missing.begin(), camera.missing.end(), [](const auto& m) { return m.second > 0; });
  const bool bright = camera.clipped && *camera.clipped > kClippedMuch;
  const bool off = camera.offset_us && std::abs(*camera.offset_us) > kOffMuch_us;
  return drops || bright || off || !camera.problem.empty() ? Health::warn : Health::good;
}

bool recording(const PageState& state) {
  return state.status && (state.status->state == "recording" || state.status->state == "stopping");
}

}  // namespace rotunda::rig
