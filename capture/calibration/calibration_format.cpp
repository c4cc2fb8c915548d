#include "capture/calibration/calibration_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "capture/calibration/camera_json.h"
#include "capture/calibration/camera_rules.h"
#include "capture/calibration/colmap_text.h"
#include "capture/calibration/projection_text.h"
#include "capture/calibration/text_rows.h"
#include "capture/picture.h"
#include "capture/take/atomic_file.h"
#include "capture/take/picture_folders.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::array kNames = {std::pair{CalibrationFormat::opencv, std::string_view("opencv")},
                               std::pair{CalibrationFormat::json, std::string_view("json")},
                               std::pair{CalibrationFormat::projections, std::string_view("projections")},
                               std::pair{CalibrationFormat::colmap, std::string_view("colmap")}};

// YAML of ours, or a FileStorage's, has keys with colons in its first rows; tables of numbers have none.
bool is_yaml(const std::vector<TextRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const TextRow& row) {
    return !row.words.empty() && (row.words.front().text.rfind("%YAML", 0) == 0 ||
                                  row.words.front().text == "cameras:" || row.words.front().text == "unit:");
  });
}

CalibrationFormat format_of_folder(const fs::path& folder) {
  if (fs::exists(folder / "cameras.txt")) return CalibrationFormat::colmap;
  if (fs::exists(folder / "cameras.bin"))
    refuse(folder, 0, 0, "", "holds COLMAP's binary model; write it as text: colmap model_converter --output_type TXT");
  return CalibrationFormat::projections;
}

void read_sizes(const fs::path& images, CalibrationFile& calibration) {
  Problems problems;
  const auto files = list_pictures(images, calibration.cameras, problems);
  for (std::size_t i = 0; i < files.size(); ++i) {
    auto& camera = calibration.cameras[i];
    if (camera.width > 0 || files[i].empty()) continue;
    const cv::Mat picture = read_grey(files[i].front());
    if (const auto mistake = set_image_size(camera, picture.cols, picture.rows); !mistake.empty())
      throw InvalidInput(files[i].front().string() + ": " + mistake);
  }
}

std::string loss_in(const CameraModel& camera, CalibrationFormat format) {
  if (format == CalibrationFormat::projections && !camera.distortion.isZero(0.0))
    return camera.name + ": a projection matrix holds no distortion; undistort the pictures that go with it";
  if (format == CalibrationFormat::colmap && camera.K(0, 1) != 0.0)
    return fmt::format("{}: COLMAP has no skew (here {:.3g} px)", camera.name, camera.K(0, 1));
  return {};
}

void write_colmap(const fs::path& folder, const CalibrationFile& calibration) {
  const auto text = colmap_text(calibration);
  fs::create_directories(folder);
  replace_file(folder / "cameras.txt", text.cameras);
  replace_file(folder / "images.txt", text.images);
  replace_file(folder / "points3D.txt", text.points);
}

}  // namespace

std::string_view to_string(CalibrationFormat format) {
  for (const auto& [known, name] : kNames)
    if (known == format) return name;
  return "";
}

std::optional<CalibrationFormat> format_named(std::string_view name) {
  for (const auto& [format, known] : kNames)
    if (known == name) return format;
  return std::nullopt;
}

CalibrationFormat format_of_file(const fs::path& file) {
  if (fs::is_directory(file)) return format_of_folder(file);
  const auto text = read_text(file);
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && (text[first] == '{' || text[first] == '[')) return CalibrationFormat::json;
  return is_yaml(split_rows(text)) ? CalibrationFormat::opencv : CalibrationFormat::projections;
}

CalibrationFormat format_of_name(const fs::path& file) {
  const auto ending = file.extension().string();
  if (fs::is_directory(file) || ending.empty()) return CalibrationFormat::colmap;
  if (ending == ".yaml" || ending == ".yml") return CalibrationFormat::opencv;
  if (ending == ".json") return CalibrationFormat::json;
  if (ending == ".txt") return CalibrationFormat::projections;
  throw InvalidInput(file.string() +
                     ": which format is wanted? Name it .yaml (OpenCV), .json, .txt (projection matrices) "
                     "or a folder (COLMAP), or say --to");
}

ImportedCalibration read_any_calibration(const fs::path& file, CalibrationFormat format) {
  switch (format) {
    case CalibrationFormat::json:
      return read_camera_json(file);
    case CalibrationFormat::projections:
      return read_projection_text(file);
    case CalibrationFormat::colmap:
      return read_colmap(file);
    default:
      return {read_calibration_file(file), {}};
  }
}

void complete_sizes(CalibrationFile& calibration, const fs::path& images, std::optional<std::pair<int, int>> size) {
  if (!images.empty()) read_sizes(images, calibration);
  std::vector<std::string> unknown;
  for (auto& camera : calibration.cameras) {
    if (camera.width > 0) continue;
    if (!size) {
      unknown.push_back(camera.name);
    } else if (const auto mistake = set_image_size(camera, size->first, size->second); !mistake.empty()) {
      throw InvalidInput("the image size: " + mistake);
    }
  }
  if (!unknown.empty())
    throw InvalidInput(fmt::format(
        "the size of the pictures is not known of {}: name them with --images DIR (DIR/<camera>/*.png), or say "
        "--image-size WxH",
        fmt::join(unknown, ", ")));
}

void mirror_world(CalibrationFile& calibration) {
  for (auto& camera : calibration.cameras) camera.R.col(2) *= -1.0;
}

std::vector<std::string> losses_in(const CalibrationFile& calibration, CalibrationFormat format) {
  std::vector<std::string> losses;
  for (const auto& camera : calibration.cameras)
    if (auto loss = loss_in(camera, format); !loss.empty()) losses.push_back(std::move(loss));
  return losses;
}

void write_any_calibration(const fs::path& file, const CalibrationFile& calibration, CalibrationFormat format) {
  switch (format) {
    case CalibrationFormat::json:
      return replace_file(file, camera_json(calibration));
    case CalibrationFormat::projections:
      return replace_file(file, projection_text(calibration));
    case CalibrationFormat::colmap:
      return write_colmap(file, calibration);
    default:
      return write_calibration(file, calibration);
  }
}

}  // namespace rotunda::capture
