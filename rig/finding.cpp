#include "rig/finding.h"

#include <fmt/format.h>

namespace rotunda::rig {

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::good:
      return "good";
    case Verdict::note:
      return "note";
    case Verdict::look:
      return "LOOK";
    case Verdict::stop:
      return "STOP";
  }
  return "?";
}

std::string lines_of(const Finding& finding) {
  auto lines = fmt::format("{:<5} {:<24} {}\n", to_string(finding.verdict), finding.what, finding.measured);
  if (!finding.cure.empty()) lines += fmt::format("      -> {}\n", finding.cure);
  return lines;
}

Verdict verdict_from(const std::string& word) {
  for (const auto verdict : {Verdict::good, Verdict::note, Verdict::stop})
    if (word == to_string(verdict)) return verdict;
  return Verdict::look;
}

}  // namespace rotunda::rig
