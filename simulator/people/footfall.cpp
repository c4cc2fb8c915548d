#include "simulator/people/footfall.h"

#include <algorithm>
#include <cmath>

namespace rotunda::simulator {
namespace {

// Metres of a person of 1.75 m.
constexpr double kLifted = 0.04;  // heels of the slowest walk rise by three times that
constexpr double kNear = 0.02;    // over where it stands: it is about to strike, or has struck
constexpr double kDown = 0.004;   // over the lowest that it then comes
constexpr double kStandsShare = 0.05;

using Heights = std::vector<double>;

// The height at which a heel stands: most feet stand a tenth of the time at least, and a glitch may dip below.
double standing_height(Heights heights) {
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(kStandsShare * static_cast<double>(heights.size()));
  std::nth_element(heights.begin(), low, heights.end());
  return *low;
}

// Samples at which the heel strikes; a round follows the one before.
std::vector<std::size_t> strikes_in(const Heights& heights, std::size_t rounds, double scale) {
  const double near = standing_height(heights) + kNear * scale, lifted = near + (kLifted - kNear) * scale;
  const std::size_t count = rounds * heights.size();
  const auto height = [&](std::size_t i) { return heights[i % heights.size()]; };
  std::vector<std::size_t> strikes;
  bool is_lifted = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (height(i) > lifted) is_lifted = true;
    if (!is_lifted || height(i) > near) continue;
    // A heel may glide low over the floor before it strikes.
    std::size_t until = i;
    double lowest = height(i);
    for (; until < count && height(until) <= near; ++until) lowest = std::min(lowest, height(until));
    while (height(i) > lowest + kDown * scale) ++i;
    strikes.push_back(i);
    i = until - 1;
    is_lifted = false;
  }
  return strikes;
}

}  // namespace

std::vector<HeelStrike> find_heel_strikes(const std::function<std::array<double, 2>(double seconds)>& heights_at,
                                          const FootfallOptions& options) {
  const auto count = static_cast<std::size_t>(std::floor(options.duration / options.step));
  std::vector<HeelStrike> strikes;
  if (count < 2) return strikes;
  std::array<Heights, 2> heights;
  for (std::size_t i = 0; i < count; ++i) {
    const auto both = heights_at(static_cast<double>(i) * options.step);
    for (std::size_t side = 0; side < 2; ++side) heights[side].push_back(both[side]);
  }
  // Of a cyclic motion the middle one of three rounds counts: it begins and ends as it goes on.
  const std::size_t rounds = options.is_cyclic ? 3 : 1, counted = rounds / 2;
  for (const Side side : {Side::left, Side::right})
    for (const auto i : strikes_in(heights[at(side)], rounds, options.person_height / 1.75))
      if (i / count == counted) strikes.push_back({static_cast<double>(i % count) * options.step, side});
  std::stable_sort(strikes.begin(), strikes.end(), [](const auto& a, const auto& b) { return a.seconds < b.seconds; });
  return strikes;
}

}  // namespace rotunda::simulator
