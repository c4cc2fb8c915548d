#include "capture/calibration/calibration_result.h"

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

}  // namespace rotunda::capture
