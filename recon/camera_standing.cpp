#include "recon/camera_standing.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

namespace rotunda::recon {
namespace {

using nlohmann::json;

std::string along(double px, const char* positive, const char* negative) {
  return fmt::format("{:.1f} {}", std::abs(px), px >= 0.0 ? positive : negative);
}

json entry(const CameraStanding& standing) {
  if (!standing.shift) return {{"camera", standing.camera}, {"moved", false}};
  const auto& shift = *standing.shift;
  return {{"camera", standing.camera},
          {"moved", shift.moved},
          {"shift_px", shift.shift_px},
          {"deviation_px", shift.deviation_px},
          {"at_middle_px", {shift.at_middle.x(), shift.at_middle.y()}},
          {"roll_deg", shift.roll_deg},
          {"tangents", shift.tangents},
          {"performer_still", shift.still}};
}

}  // namespace

std::string in_words(const CameraStanding& standing) {
  const auto& shift = *standing.shift;
  return fmt::format(
      "{} does not stand where the calibration says: its picture lies {:.1f} px off ({}, {}, turned by {:.2f} degrees "
      "{}; +- {:.1f} px)",
      standing.camera, shift.shift_px, along(shift.at_middle.x(), "right", "left"),
      along(shift.at_middle.y(), "down", "up"), std::abs(shift.roll_deg),
      shift.roll_deg >= 0.0 ? "clockwise" : "anticlockwise", shift.deviation_px);
}

std::string to_json(std::span<const CameraStanding> standings) {
  json list = json::array();
  for (const auto& standing : standings) list.push_back(entry(standing));
  return list.dump(2);
}

void write_standings(const std::filesystem::path& file, std::span<const CameraStanding> standings) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file);
  out << to_json(standings) << "\n";
  out.close();
  if (!out) throw std::system_error(errno, std::generic_category(), file.string());
}

}  // namespace rotunda::recon
