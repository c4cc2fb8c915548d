#include "playback/picture_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

namespace rotunda::playback {
namespace {

constexpr auto kPicturePeriod = std::chrono::microseconds(16'667);  // where the display does not hold us to its own
constexpr double kSmoothing = 0.1;
constexpr int kJudged = 15;       // pictures at a time: one slow picture is no slow machine
constexpr double kQuick = 0.4;    // of the deadline: one level finer takes up to four times as long, in vertices
constexpr double kOnTrial = 2.0;  // seconds that a finer level must last
constexpr double kMostPatience = 60.0;

}  // namespace

void DetailKeeper::hear(double seconds) {
  sum_ += seconds;
  since_finer_ += seconds;
  late_ += seconds > deadline_;
  quick_ones_ += seconds < kQuick * deadline_;
  if (++heard_ < kJudged) return;
  judge();
  sum_ = 0.0;
  heard_ = late_ = quick_ones_ = 0;
}

// By what most of the pictures were.
void DetailKeeper::judge() {
  quick_ = 2 * quick_ones_ > heard_ ? quick_ + sum_ : 0.0;
  if (2 * late_ > heard_ && coarser_ < coarsest_) {
    if (since_finer_ < kOnTrial) patience_ = std::min(kMostPatience, 2.0 * patience_);
    ++coarser_;
  } else if (coarser_ > 0 && quick_ >= patience_) {
    --coarser_;
    quick_ = since_finer_ = 0.0;
  }
}

PictureClock::PictureClock() : made_(Clock::now()), begun_(made_) {}

double PictureClock::begin() {
  const auto now = Clock::now();
  const double passed = std::chrono::duration<double>(now - begun_).count();
  begun_ = now;
  period_ += kSmoothing * (passed - period_);
  return passed;
}

void PictureClock::end(bool levels_matter) {
  if (levels_matter) detail_.hear(std::chrono::duration<double>(Clock::now() - begun_).count());
  std::this_thread::sleep_until(begun_ + kPicturePeriod);
}

double PictureClock::seconds() const {
  return std::chrono::duration<double>(Clock::now() - made_).count();
}

std::string PictureClock::told() const {
  const auto rate = fmt::format("{:.0f} pictures/s", 1.0 / period_);
  return coarser() > 0 ? fmt::format("{}, {} coarser to keep up", rate, coarser() == 1 ? "a level" : "two levels")
                       : rate;
}

}  // namespace rotunda::playback
