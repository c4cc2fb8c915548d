#pragma once
// Does a camera stand where the calibration says? What is told of it, and how it is written down.
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "recon/hull/camera_agreement.h"

namespace rotunda::recon {

struct CameraStanding {
  std::string camera;
  std::optional<CameraShift> shift;  // nothing: it cannot be told
};

// "cam03 does not stand where the calibration says: its picture lies 31.2 px off (30.1 right, 8.2 down, turned by 0.30
// degrees clockwise; +- 0.4 px)". For a camera that moved.
std::string in_words(const CameraStanding& standing);

// A JSON object a camera: camera, moved, and where it can be told shift_px, deviation_px, at_middle_px, roll_deg,
// tangents, performer_still.
std::string to_json(std::span<const CameraStanding> standings);

// Throws std::system_error.
void write_standings(const std::filesystem::path& file, std::span<const CameraStanding> standings);

}  // namespace rotunda::recon
