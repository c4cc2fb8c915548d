#pragma once
// Calibrations of this and other programs, told apart by their content, in and out. docs/calibration-formats.md says
// what each means, how it is read, and what it cannot hold.
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/calibration/imported_calibration.h"

namespace rotunda::capture {

enum class CalibrationFormat { opencv, json, projections, colmap };

std::string_view to_string(CalibrationFormat format);
std::optional<CalibrationFormat> format_named(std::string_view name);

// By what is in it: a folder with cameras.txt, text that begins with a brace or bracket, YAML, else numbers. Throws
// ConfigError if there is nothing there.
CalibrationFormat format_of_file(const std::filesystem::path& file);
// By the name of a file to be written: .yaml, .yml, .json, .txt; a folder (no ending) is COLMAP's. Throws InvalidInput.
CalibrationFormat format_of_name(const std::filesystem::path& file);

// Throws ConfigError with the place of every mistake.
ImportedCalibration read_any_calibration(const std::filesystem::path& file, CalibrationFormat format);

// Cameras without a size get that of their pictures (DIR/<camera>/*.png|jpg), or the given one. Throws InvalidInput
// that names every camera whose size stays unknown.
void complete_sizes(CalibrationFile& calibration, const std::filesystem::path& images,
                    std::optional<std::pair<int, int>> size);

// The world's z turned round: a left-handed set becomes right-handed, and the other way.
void mirror_world(CalibrationFile& calibration);

// What of this calibration `format` cannot hold, a sentence each with the camera's name.
std::vector<std::string> losses_in(const CalibrationFile& calibration, CalibrationFormat format);

// Replaces what is there. Throws std::system_error, InvalidInput for what cannot be written at all.
void write_any_calibration(const std::filesystem::path& file, const CalibrationFile& calibration,
                           CalibrationFormat format);

}  // namespace rotunda::capture
