#pragma once
// Smooth curves through keys: piecewise cubics with slopes limited so that nothing overshoots and what is held stays
// held (Fritsch and Carlson, "Monotone piecewise cubic interpolation", 1980, harmonic mean of the secants). C1.
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace rotunda::simulator {

template <std::size_t N>
struct CurveKey {
  double time;
  std::array<double, N> value;
};

// The slope at a key between the secants before and after it.
inline double limited_slope(double before, double after) {
  return before * after <= 0.0 ? 0.0 : 2.0 * before * after / (before + after);
}

// Hermite's cubic over [0, 1] between two values; slopes are a unit of t.
inline double hermite(double t, double from, double to, double slope_from, double slope_to) {
  const double s = 1.0 - t;
  return s * s * (1.0 + 2.0 * t) * from + t * t * (3.0 - 2.0 * t) * to + t * s * (s * slope_from - t * slope_to);
}

// 0 before 0, 1 after 1, between them 3 t^2 - 2 t^3.
inline double smooth_step(double t) {
  return t <= 0.0 ? 0.0 : t >= 1.0 ? 1.0 : t * t * (3.0 - 2.0 * t);
}

// The curve's value between key `i` and the next, given the two keys around them (the same ones again at an end).
template <std::size_t N>
std::array<double, N> curve_between(const CurveKey<N>& before, const CurveKey<N>& from, const CurveKey<N>& to,
                                    const CurveKey<N>& after, double time) {
  const auto secant = [](const CurveKey<N>& a, const CurveKey<N>& b, std::size_t c) {
    return b.time > a.time ? (b.value[c] - a.value[c]) / (b.time - a.time) : 0.0;
  };
  const double width = to.time - from.time, t = (time - from.time) / width;
  std::array<double, N> value;
  for (std::size_t c = 0; c < N; ++c) {
    const double middle = secant(from, to, c);
    value[c] = hermite(t, from.value[c], to.value[c], width * limited_slope(secant(before, from, c), middle),
                       width * limited_slope(middle, secant(to, after, c)));
  }
  return value;
}

// Rests at the first key before it and at the last one after it. Keys in order of time, at least one.
template <std::size_t N>
std::array<double, N> curve_at(std::span<const CurveKey<N>> keys, double time) {
  if (time <= keys.front().time) return keys.front().value;
  if (time >= keys.back().time) return keys.back().value;
  std::size_t i = 0;
  while (time >= keys[i + 1].time) ++i;
  return curve_between(keys[i == 0 ? 0 : i - 1], keys[i], keys[i + 1], keys[i + 2 < keys.size() ? i + 2 : i + 1], time);
}

// Runs on into the next period; keys lie in [0, period), at least two.
template <std::size_t N>
std::array<double, N> periodic_curve_at(std::span<const CurveKey<N>> keys, double period, double time) {
  const auto n = static_cast<long>(keys.size());
  time -= period * std::floor(time / period);
  long i = n - 1;
  for (long k = 0; k + 1 < n; ++k)
    if (time >= keys[static_cast<std::size_t>(k)].time && time < keys[static_cast<std::size_t>(k + 1)].time) i = k;
  if (time < keys.front().time) time += period;
  const auto key = [&](long k) {
    const long round = k < 0 ? -1 : k / n;
    CurveKey<N> shifted = keys[static_cast<std::size_t>(k - round * n)];
    shifted.time += period * static_cast<double>(round);
    return shifted;
  };
  return curve_between(key(i - 1), key(i), key(i + 1), key(i + 2), time);
}

}  // namespace rotunda::simulator
