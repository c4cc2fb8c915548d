#include "playback/stride_phase.h"

#include <algorithm>
#include <cmath>

namespace rotunda::playback {
namespace {

// Into [0, period).
double wrapped(double frames, double period) {
  const double rest = std::fmod(frames, period);
  return rest < 0.0 ? rest + period : rest;
}

}  // namespace

double StridePhase::phase_at(double frame) const {
  const double after_left = wrapped(frame - enter - left, period), half = wrapped(right - left, period);
  return after_left < half ? 0.5 * after_left / half : 0.5 + 0.5 * (after_left - half) / (period - half);
}

double StridePhase::frame_at(double phase) const {
  const double half = wrapped(right - left, period);
  const double after_left = phase < 0.5 ? 2.0 * phase * half : half + (2.0 * phase - 1.0) * (period - half);
  return enter + wrapped(left + after_left, period);
}

std::optional<StridePhase> stride_phase(const recon::MotionGraph& graph, const recon::MotionState& state) {
  const auto& clip = graph.clip(state.clip);
  const double enter = state.loop.enter, period = state.period();
  if (clip.speed == 0.0) return std::nullopt;
  const auto strike = [&](recon::Side side) {
    const auto found =
        std::find_if(clip.strikes.begin(), clip.strikes.end(), [&](const auto& one) { return one.side == side; });
    return found == clip.strikes.end() ? std::optional<double>() : wrapped(found->frame - enter, period);
  };
  const auto left = strike(recon::Side::left), right = strike(recon::Side::right);
  if (!left || !right || *left == *right) return std::nullopt;
  return StridePhase{enter, period, *left, *right};
}

// Lengths and times are blended alike, so v ((1-a) T0 + a T1) = (1-a) L0 + a L1.
double share_for(double speed, const StridePace& slow, const StridePace& fast) {
  const double gained = fast.seconds * (fast.speed - speed), lacking = slow.seconds * (speed - slow.speed);
  if (lacking <= 0.0) return 0.0;
  return gained <= 0.0 ? 1.0 : lacking / (lacking + gained);
}

}  // namespace rotunda::playback
