#include "rig/daemon/camera_status.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds kRateOver = 1s;  // whose half is not 0, as that of a second is

std::optional<double> in_us(const std::optional<std::chrono::nanoseconds>& time) {
  return time ? std::optional(std::chrono::duration<double, std::micro>(*time).count()) : std::nullopt;
}

}  // namespace

void tell_stats(CameraStatus& status, const capture::SourceStats& stats) {
  status.frames = stats.frames;
  status.incomplete = stats.incomplete;
  status.dropped = stats.dropped;
  status.resend_requests = stats.resend_requests;
  status.packet_size = static_cast<std::uint32_t>(stats.packet_size);
  status.socket_buffer_bytes = static_cast<std::uint32_t>(stats.socket_buffer_bytes);
}

void tell_description(CameraStatus& status, const capture::SourceDescription& description) {
  status.model = description.model;
  status.serial = description.serial;
  status.address = description.address;
  status.width = static_cast<std::uint32_t>(description.width);
  status.height = static_cast<std::uint32_t>(description.height);
  status.pixel_format = capture::to_string(description.format);
}

void tell_health(CameraStatus& status, const capture::SourceHealth& health) {
  const auto& clock = health.clock;
  status.clock = clock.kind.empty() ? std::nullopt : std::optional(clock.kind);
  status.clock_offset_us = in_us(clock.offset);
  status.clock_error_us = in_us(clock.error);
  status.temperature_c = health.temperature_c;
}

std::string problems_of(const capture::SourceDescription& description, const capture::SourceHealth& health, bool silent,
                        const std::string& ailment) {
  auto problems = description.warnings;
  if (silent) problems.insert(problems.begin(), "sends no pictures though it is triggered; check its cable and power");
  for (const auto& problem : {ailment, health.problem, health.clock.problem})
    if (!problem.empty()) problems.push_back(problem);
  return fmt::format("{}", fmt::join(problems, "; "));
}

double FrameRate::measure(std::uint64_t frames, std::chrono::steady_clock::time_point now) {
  if (!counts_.empty() && frames < counts_.back().second) counts_.clear();
  counts_.emplace_back(now, frames);
  while (counts_.size() > 2 && now - counts_[1].first >= kRateOver) counts_.pop_front();
  const std::chrono::duration<double> span = now - counts_.front().first;
  if (span < kRateOver / 2) return 0.0;
  return static_cast<double>(frames - counts_.front().second) / span.count();
}

}  // namespace rotunda::rig
