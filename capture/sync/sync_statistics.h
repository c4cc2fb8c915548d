#pragma once
// How well cameras are in step, measured from their exposure starts: over all sets, in memory that does not grow.
#include <array>
#include <chrono>
#include <cstdint>
#include <vector>

#include "capture/frame.h"

namespace rotunda::capture {

struct CameraSync {
  std::chrono::nanoseconds offset{};  // mean of exposure start less the trigger's moment
  std::chrono::nanoseconds jitter{};  // standard deviation about the line through the offsets
  double drift_ppm = 0.0;             // slope of that line: later by so many microseconds a second
};

// Spread: the last exposure start of a set less the first. Median and p99 are exact to 3 %.
struct SyncSummary {
  std::uint64_t sets = 0;  // with two frames at least
  std::chrono::nanoseconds spread_median{}, spread_p99{}, spread_max{};
  std::vector<CameraSync> cameras;  // as in the sets
};

class SyncStatistics {
 public:
  explicit SyncStatistics(std::size_t cameras) : lines_(cameras) {}

  void add(const FrameSet& set);  // InvalidInput unless it has as many slots as there are cameras
  SyncSummary summary() const;

 private:
  // Sums for a straight line through (seconds since the first set, offset in nanoseconds).
  struct Line {
    double n = 0, t = 0, y = 0, tt = 0, ty = 0, yy = 0;
  };
  static CameraSync fitted(const Line& line);
  std::chrono::nanoseconds quantile(double share) const;

  std::vector<Line> lines_;
  Timestamp first_;
  bool begun_ = false;
  std::uint64_t sets_ = 0;
  std::chrono::nanoseconds largest_{};
  std::array<std::uint64_t, 1024> spreads_{};  // by 16 bins an octave of nanoseconds; bin 0: none
};

}  // namespace rotunda::capture
