#include "recon/alignment_report.h"

#include <utility>
#include <vector>

#include "config/errors.h"
#include "config/median.h"

namespace rotunda::recon {

using nlohmann::json;

json json_of(const FrameAlignment& frame) {
  return {{"frame", frame.frame},
          {"residual_mean_mm", frame.residual_mean_mm},
          {"residual_p95_mm", frame.residual_p95_mm},
          {"stretch_p95", frame.stretch_p95},
          {"uncovered", frame.uncovered},
          {"folds", frame.folds}};
}

FrameAlignment frame_alignment_of(const std::string& text, const std::filesystem::path& folder) {
  try {
    const auto frame = json::parse(text);
    return {.frame = frame.at("frame").get<std::size_t>(),
            .residual_mean_mm = frame.at("residual_mean_mm").get<double>(),
            .residual_p95_mm = frame.at("residual_p95_mm").get<double>(),
            .stretch_p95 = frame.at("stretch_p95").get<double>(),
            .uncovered = frame.at("uncovered").get<double>(),
            .folds = frame.at("folds").get<std::size_t>()};
  } catch (const json::exception&) {
    throw CorruptData(folder.string() + ": a frame's report is damaged; delete the folder and align again");
  }
}

double TakeAlignmentReport::uncovered() const {
  std::vector<double> shares;
  for (const auto& frame : frames) shares.push_back(frame.uncovered);
  return median(std::move(shares));
}

}  // namespace rotunda::recon
