#include "rig/tui/camera_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace rotunda::rig {
namespace {

constexpr int kWide = 120, kWider = 150;  // columns from which there is room for what an engineer looks at
constexpr double kAtPeak = 0.97;
constexpr double kClippedMuch = 0.02;

struct Columns {
  int name = 8, state = 9, rate = 5, drops = 0, offset = 9, clipped = 5, score = 3, bar = 8;
  int device = 0, frames = 0, resends = 0, drift = 0, clock = 0, heat = 0;  // where it is wide
};

// One space stands between columns; the drops get what is left.
Columns columns_for(int width) {
  Columns c;
  if (width >= kWide) {
    c.device = 16;
    c.frames = 9;
    c.resends = 8;
    c.drift = 8;
  }
  if (width >= kWider) {
    c.clock = 10;
    c.heat = 4;
    c.bar = 20;
  }
  int used = c.name + c.state + c.rate + c.offset + c.clipped + c.score + c.bar + 7;
  for (const int extra : {c.device, c.frames, c.resends, c.drift, c.clock, c.heat})
    if (extra > 0) used += extra + 1;
  c.drops = std::max(4, width - used);
  return c;
}

void add(Line& line, std::string cell, Style style = Style::plain) {
  if (!line.empty()) line.push_back({" ", Style::plain});
  line.push_back({std::move(cell), style});
}

Line head(const Columns& c) {
  Line line;
  add(line, left_in("camera", c.name), Style::title);
  if (c.device) add(line, left_in("device", c.device), Style::title);
  add(line, left_in("state", c.state), Style::title);
  add(line, right_in("Hz", c.rate), Style::title);
  if (c.frames) add(line, right_in("frames", c.frames), Style::title);
  if (c.resends) add(line, right_in("resends", c.resends), Style::title);
  add(line, left_in("drops", c.drops), Style::title);
  add(line, right_in("clock us", c.offset), Style::title);
  if (c.drift) add(line, right_in("ppm", c.drift), Style::title);
  if (c.clock) add(line, left_in("clock", c.clock), Style::title);
  if (c.heat) add(line, right_in("deg", c.heat), Style::title);
  add(line, right_in("clip%", c.clipped), Style::title);
  add(line, left_in("focus, peak", c.score + 1 + c.bar), Style::title);
  return line;
}

std::string number_or_dash(const std::optional<double>& value, const char* pattern, double scale = 1.0) {
  return value ? fmt::format(fmt::runtime(pattern), *value * scale) : "-";
}

std::string state_word(const CameraStatus& camera, Health health) {
  return health == Health::lost && camera.state == "streaming" ? "lost" : camera.state;
}

Style style_of(Health health) {
  if (health == Health::lost) return Style::alarm;
  return health == Health::warn ? Style::warn : Style::good;
}

void add_focus(Line& line, const CameraStatus& camera, double peak, const Columns& c) {
  const double score = camera.focus.value_or(0.0);
  const bool at_peak = camera.focus && score >= kAtPeak * peak;
  add(line, right_in(number_or_dash(camera.focus, "{:.0f}", 100.0), c.score), at_peak ? Style::good : Style::plain);
  add(line, camera.focus ? focus_bar(score, peak, c.bar) : std::string(static_cast<std::size_t>(c.bar), ' '),
      at_peak ? Style::good : Style::plain);
}

Line row(const CameraStatus& camera, double rate_hz, double peak, const Columns& c) {
  const auto health = health_of(camera, rate_hz);
  const bool lost = health == Health::lost;
  const auto drops = drops_by_cause(camera.missing, c.drops);
  Line line;
  add(line, left_in(camera.name, c.name), lost ? Style::alarm : Style::plain);
  if (c.device) add(line, left_in(camera.device, c.device), lost ? Style::alarm : Style::dim);
  add(line, left_in(state_word(camera, health), c.state), style_of(health));
  add(line, right_in(fmt::format("{:.1f}", camera.rate_hz), c.rate), lost ? Style::alarm : Style::plain);
  if (c.frames) add(line, right_in(fmt::format("{}", camera.frames), c.frames));
  if (c.resends) add(line, right_in(fmt::format("{}", camera.resend_requests), c.resends));
  add(line, left_in(drops, c.drops), drops == "-" ? Style::dim : Style::warn);
  add(line, right_in(number_or_dash(camera.offset_us, "{:+.1f}"), c.offset));
  if (c.drift) add(line, right_in(number_or_dash(camera.drift_ppm, "{:+.2f}"), c.drift));
  if (c.clock) add(line, left_in(camera.clock.value_or("-"), c.clock));
  if (c.heat) add(line, right_in(number_or_dash(camera.temperature_c, "{:.0f}"), c.heat));
  add(line, right_in(number_or_dash(camera.clipped, "{:.1f}", 100.0), c.clipped),
      camera.clipped.value_or(0.0) > kClippedMuch ? Style::warn : Style::plain);
  add_focus(line, camera, peak, c);
  return line;
}

// Short words for causes that a narrow table has no room for.
std::string short_word(const std::string& cause) {
  if (cause == "packets lost") return "wire";
  if (cause == "camera lost") return "gone";
  if (cause == "trigger missed") return "trigger";
  if (cause == "disk too slow") return "disk";
  return cause;
}

std::vector<const CameraStatus*> in_order(const RigStatus& status, bool all_fit) {
  std::vector<const CameraStatus*> cameras;
  for (const auto& camera : status.cameras) cameras.push_back(&camera);
  if (!all_fit)
    std::stable_sort(cameras.begin(), cameras.end(), [&](const auto* a, const auto* b) {
      return health_of(*a, status.rate_hz) > health_of(*b, status.rate_hz);
    });
  return cameras;
}

}  // namespace

std::string drops_by_cause(const std::map<std::string, std::uint64_t>& missing, int width) {
  std::string words, brief;
  std::uint64_t all = 0;
  for (const auto& [cause, frames] : missing) {
    if (frames == 0) continue;
    all += frames;
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", frames, cause);
    brief += fmt::format(" {} {}", short_word(cause), frames);
  }
  if (all == 0) return "-";
  return width_of(words) <= width ? words : fmt::format("{}:{}", all, brief);
}

std::string focus_bar(double score, double peak, int width) {
  const auto cell = [width](double share) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(std::lround(share * width)), 0, width));
  };
  std::string bar(static_cast<std::size_t>(width), ' ');
  std::fill_n(bar.begin(), cell(score), '=');
  if (peak > 0.0 && width > 0) bar[std::max<std::size_t>(cell(peak), 1) - 1] = '|';
  return bar;
}

std::vector<Line> camera_rows(const PageState& state, PageSize room, bool stale) {
  const auto& status = *state.status;
  const auto c = columns_for(room.columns);
  std::vector<Line> lines{head(c)};
  const auto places = static_cast<std::size_t>(std::max(1, room.rows));
  const bool all_fit = status.cameras.size() <= places;
  const auto cameras = in_order(status, all_fit);
  const auto shown = all_fit ? cameras.size() : places - 1;
  for (std::size_t i = 0; i < shown; ++i) {
    const auto peak = state.peak.find(cameras[i]->name);
    lines.push_back(row(*cameras[i], status.rate_hz, peak == state.peak.end() ? 0.0 : peak->second, c));
  }
  if (!all_fit)
    lines.push_back({{fmt::format("and {} more cameras, no worse than these", cameras.size() - shown), Style::dim}});
  if (stale)
    for (auto& line : lines)
      for (auto& span : line) span.style = Style::dim;
  return lines;
}

}  // namespace rotunda::rig
