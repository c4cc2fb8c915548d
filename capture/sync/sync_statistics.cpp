#include "capture/sync/sync_statistics.h"

#include <algorithm>
#include <cmath>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kBinsAnOctave = 16.0;

std::size_t bin_of(std::chrono::nanoseconds spread) {
  if (spread.count() <= 0) return 0;
  const auto bin = 1.0 + kBinsAnOctave * std::log2(static_cast<double>(spread.count()));
  return std::min<std::size_t>(static_cast<std::size_t>(bin), 1023);
}

std::chrono::nanoseconds middle_of(std::size_t bin) {
  if (bin == 0) return {};
  return std::chrono::nanoseconds(std::llround(std::exp2((static_cast<double>(bin) - 0.5) / kBinsAnOctave)));
}

std::chrono::nanoseconds nanoseconds_from(double value) {
  return std::chrono::nanoseconds(std::llround(value));
}

}  // namespace

void SyncStatistics::add(const FrameSet& set) {
  if (set.slots.size() != lines_.size()) throw InvalidInput("a frame set of other cameras than the statistics'");
  if (!begun_) first_ = set.time;
  begun_ = true;
  const double t = std::chrono::duration<double>(set.time - first_).count();
  std::vector<Timestamp> starts;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (!set.slots[i].frame) continue;
    starts.push_back(set.slots[i].frame->exposure_start);
    const auto y = static_cast<double>((starts.back() - set.time).count());
    Line& line = lines_[i];
    line.n += 1, line.t += t, line.y += y, line.tt += t * t, line.ty += t * y, line.yy += y * y;
  }
  if (starts.size() < 2) return;
  const auto [least, most] = std::minmax_element(starts.begin(), starts.end());
  ++sets_;
  ++spreads_[bin_of(*most - *least)];
  largest_ = std::max<std::chrono::nanoseconds>(largest_, *most - *least);
}

CameraSync SyncStatistics::fitted(const Line& line) {
  if (line.n == 0) return {};
  const double offset = line.y / line.n;
  const double tt = line.tt - line.t * line.t / line.n, ty = line.ty - line.t * line.y / line.n;
  const double yy = std::max(0.0, line.yy - line.y * line.y / line.n);
  const double slope = tt > 0.0 ? ty / tt : 0.0;  // nanoseconds a second
  const double residual = std::max(0.0, yy - slope * ty) / line.n;
  return {
      .offset = nanoseconds_from(offset), .jitter = nanoseconds_from(std::sqrt(residual)), .drift_ppm = slope * 1e-3};
}

std::chrono::nanoseconds SyncStatistics::quantile(double share) const {
  const double wanted = share * static_cast<double>(sets_);
  double below = 0.0;
  for (std::size_t bin = 0; bin < spreads_.size(); ++bin) {
    below += static_cast<double>(spreads_[bin]);
    if (below >= wanted && spreads_[bin] > 0) return std::min(middle_of(bin), largest_);
  }
  return largest_;
}

SyncSummary SyncStatistics::summary() const {
  SyncSummary summary{.sets = sets_,
                      .spread_median = quantile(0.5),
                      .spread_p99 = quantile(0.99),
                      .spread_max = largest_,
                      .cameras = {}};
  for (const auto& line : lines_) summary.cameras.push_back(fitted(line));
  return summary;
}

}  // namespace rotunda::capture
