// What is wrong with the rig, in words, the worst first.
#include <fmt/format.h>

#include <algorithm>

#include "rig/preflight.h"
#include "rig/tui/rig_page.h"

namespace rotunda::rig {
namespace {

constexpr double kSlowAnswer_s = 1.5;  // six missed polls

void add_daemon(const PageState& state, std::vector<Span>& spans) {
  if (!state.trouble.empty()) {
    spans.push_back({state.trouble, Style::alarm});
    if (recording(state))
      spans.push_back({fmt::format("take {} was recording when it was last heard; its frames are on disk, see: rotunda "
                                   "take list",
                                   state.status->take.name),
                       Style::alarm});
  } else if (state.status_age_s > kSlowAnswer_s) {
    spans.push_back(
        {fmt::format("the daemon has not answered for {:.0f} s; a take goes on without this page", state.status_age_s),
         Style::alarm});
  }
}

void add_take(const TakeProgress& take, std::vector<Span>& spans) {
  if (!take.failure.empty())
    spans.push_back({fmt::format("take {} ended early: {}", take.name, take.failure), Style::alarm});
  if (take.closed) return;
  for (const auto& warning : take.warnings) spans.push_back({warning, Style::warn});
}

bool names_itself(const CameraStatus& camera) {
  return camera.problem.rfind(camera.name, 0) == 0;
}

void add_cameras(const RigStatus& status, std::vector<Span>& spans) {
  for (const auto& camera : status.cameras) {
    const auto health = health_of(camera, status.rate_hz);
    if (health == Health::lost && camera.state == "streaming")
      spans.push_back(
          {fmt::format("{}: no frame for {:.1f} s; check its cable and power", camera.name, camera.silent_s),
           Style::alarm});
    else if (health == Health::lost)
      spans.push_back(
          {camera.problem.empty() ? fmt::format("{} is {}", camera.name, camera.state) : camera.problem, Style::alarm});
    else if (!camera.problem.empty())
      spans.push_back(
          {names_itself(camera) ? camera.problem : fmt::format("{}: {}", camera.name, camera.problem), Style::warn});
  }
}

// Cameras tell for themselves; notes are for the doctor.
void add_preflight(const RigStatus& status, std::vector<Span>& spans) {
  for (const auto& finding : status.preflight)
    if (finding.verdict == Verdict::look && finding.what.rfind("camera ", 0) != 0)
      spans.push_back({fmt::format("{}: {}; {}", finding.what, finding.measured, finding.cure), Style::warn});
}

}  // namespace

std::vector<Span> concerns(const PageState& state) {
  std::vector<Span> spans;
  add_daemon(state, spans);
  if (!state.status) return spans;
  for (const auto& reason : why_not_record(state.status->preflight))
    spans.push_back({"cannot record: " + reason, Style::alarm});
  add_take(state.status->take, spans);
  add_cameras(*state.status, spans);
  if (const auto& problem = state.status->surfaces.problem; !problem.empty())
    spans.push_back({"live surfaces: " + problem, Style::warn});
  for (const auto& warning : state.status->warnings) spans.push_back({warning, Style::warn});
  add_preflight(*state.status, spans);
  std::stable_partition(spans.begin(), spans.end(), [](const Span& span) { return span.style == Style::alarm; });
  return spans;
}

}  // namespace rotunda::rig
