#include "capture/calibration/calibration_result.h"

#include <fmt/format.h>

namespace rotunda::capture {

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::good:
      return "good";
    case Verdict::usable:
      return "usable";
    case Verdict::rejected:
      break;
  }
  return "rejected";
}

std::string in_times(std::size_t count) {
  return count == 1 ? "once" : count == 2 ? "twice" : fmt::format("{} times", count);
}

std::string held_out_where(const CalibrationResult& result) {
  if (result.held_out_moments == 0) return "at a fifth of the corners";
  return fmt::format("at {} moments", result.held_out_moments);
}

}  // namespace rotunda::capture
