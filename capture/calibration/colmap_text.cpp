#include "capture/calibration/colmap_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "capture/calibration/camera_rules.h"
#include "capture/calibration/text_rows.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr double kCornerToCentre = 0.5;  // pixels

// A COLMAP camera model: which of our numbers each parameter is.
enum class Parameter { f, fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6 };
struct Model {
  const char* name;
  std::vector<Parameter> parameters;
};
const std::vector<Model>& models() {
  using enum Parameter;
  static const std::vector<Model> kModels = {
      {"SIMPLE_PINHOLE", {f, cx, cy}},
      {"PINHOLE", {fx, fy, cx, cy}},
      {"SIMPLE_RADIAL", {f, cx, cy, k1}},
      {"RADIAL", {f, cx, cy, k1, k2}},
      {"OPENCV", {fx, fy, cx, cy, k1, k2, p1, p2}},
      {"FULL_OPENCV", {fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6}},
  };
  return kModels;
}

// Empty, or why the number cannot be kept.
std::string set_parameter(CameraModel& camera, Parameter parameter, double value) {
  switch (parameter) {
    case Parameter::f:
      camera.K(0, 0) = camera.K(1, 1) = value;
      return {};
    case Parameter::fx:
      camera.K(0, 0) = value;
      return {};
    case Parameter::fy:
      camera.K(1, 1) = value;
      return {};
    case Parameter::cx:
      camera.K(0, 2) = value - kCornerToCentre;
      return {};
    case Parameter::cy:
      camera.K(1, 2) = value - kCornerToCentre;
      return {};
    case Parameter::k1:
    case Parameter::k2:
    case Parameter::p1:
    case Parameter::p2:
    case Parameter::k3:
      camera.distortion[static_cast<int>(parameter) - static_cast<int>(Parameter::k1)] = value;
      return {};
    default:
      return value == 0.0 ? "" : "k4, k5, k6 other than 0 cannot be kept: let COLMAP refine an OPENCV camera instead";
  }
}

std::string without_edges(const fs::path& file, const TextRow& row, std::size_t words) {
  if (row.words.size() >= words) return {};
  refuse(file, row.line, 1, "", fmt::format("expected {} words or more, found {}", words, row.words.size()));
}

CameraModel read_camera(const fs::path& file, const TextRow& row) {
  without_edges(file, row, 4);
  const auto& word = row.words[1];
  const auto model =
      std::find_if(models().begin(), models().end(), [&](const Model& m) { return word.text == m.name; });
  if (model == models().end())
    refuse(file, row.line, word.column, "",
           fmt::format("the camera model {} is not read here; let COLMAP undistort to PINHOLE first, or use "
                       "OPENCV",
                       word.text.substr(0, 40)));
  const auto numbers = numbers_in(file, row, 2);
  if (numbers.size() != 2 + model->parameters.size())
    refuse(file, row.line, word.column, "",
           fmt::format("{} takes width, height and {} parameters, found {} numbers", model->name,
                       model->parameters.size(), numbers.size()));
  CameraModel camera;
  std::string mistake = set_image_size(camera, numbers[0], numbers[1]);
  for (std::size_t i = 0; i < model->parameters.size() && mistake.empty(); ++i)
    mistake = set_parameter(camera, model->parameters[i], numbers[2 + i]);
  if (mistake.empty()) mistake = set_K(camera, Eigen::Matrix3d(camera.K));
  if (!mistake.empty()) refuse(file, row.line, 1, "", mistake);
  return camera;
}

std::map<std::string, CameraModel> read_intrinsics(const fs::path& file) {
  std::map<std::string, CameraModel> cameras;
  for (const auto& row : split_rows(read_text(file))) {
    if (row.words.empty()) continue;
    if (!cameras.emplace(row.words.front().text, read_camera(file, row)).second)
      refuse(file, row.line, 1, "", "the camera " + row.words.front().text + " is there twice");
  }
  if (cameras.empty()) refuse(file, 0, 0, "", "holds no camera");
  return cameras;
}

struct Picture {
  std::string name;  // as COLMAP has it, "folder/file.png"
  TextRow row;
  CameraModel camera;
};

// IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME; the name may hold blanks.
Picture read_pose(const fs::path& file, const TextRow& row, const std::map<std::string, CameraModel>& intrinsics) {
  without_edges(file, row, 10);
  TextRow numbers_only = row;
  numbers_only.words.resize(8);
  const auto n = numbers_in(file, numbers_only, 1);
  const auto camera = intrinsics.find(row.words[8].text);
  if (camera == intrinsics.end())
    refuse(file, row.line, row.words[8].column, "",
           fmt::format("there is no camera {} in cameras.txt", row.words[8].text.substr(0, 40)));
  Picture picture{.name = row.words[9].text, .row = row, .camera = camera->second};
  for (std::size_t i = 10; i < row.words.size(); ++i) picture.name += " " + row.words[i].text;
  Eigen::Vector4d q(n[0], n[1], n[2], n[3]);
  const double length = q.norm();
  if (!(length > 1e-6 && length < 1e6))
    refuse(file, row.line, row.words[1].column, picture.name, "its quaternion has no direction");
  q /= length;
  picture.camera.R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  picture.camera.t = {n[4], n[5], n[6]};
  return picture;
}

// A picture's second line: nothing, or x, y, point id over and over. Files without them exist.
bool is_points(const TextRow& row) {
  return row.words.size() % 3 == 0 && std::all_of(row.words.begin(), row.words.end(),
                                                  [](const TextWord& word) { return number_in(word).has_value(); });
}

std::vector<Picture> read_pictures(const fs::path& file, const std::map<std::string, CameraModel>& intrinsics) {
  const auto rows = split_rows(read_text(file));
  std::vector<Picture> pictures;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].words.empty()) continue;
    pictures.push_back(read_pose(file, rows[i], intrinsics));
    if (i + 1 < rows.size() && is_points(rows[i + 1])) ++i;
  }
  if (pictures.empty()) refuse(file, 0, 0, "", "holds no picture");
  return pictures;
}

// By folder where each picture has one of its own, else by file.
void name_cameras(const fs::path& file, std::vector<Picture>& pictures) {
  std::set<std::string> folders, names;
  for (const auto& picture : pictures) folders.insert(fs::path(picture.name).parent_path().string());
  const bool by_folder = folders.size() == pictures.size() && folders.count("") == 0;
  for (auto& picture : pictures) {
    const fs::path path(picture.name);
    std::string name = by_folder ? path.parent_path().string() : (path.parent_path() / path.stem()).string();
    std::replace(name.begin(), name.end(), '/', '_');
    auto mistake = set_name(picture.camera, name);
    if (mistake.empty() && !names.insert(name).second) mistake = "is there twice";
    if (!mistake.empty()) refuse(file, picture.row.line, picture.row.words[9].column, name, mistake);
  }
}

std::string camera_row(const CameraModel& camera, std::size_t id) {
  const auto& d = camera.distortion;
  const auto& K = camera.K;
  const std::size_t kept = d[4] != 0.0 ? 12U : d.head<4>().isZero(0.0) ? 4U : 8U;
  std::vector<double> parameters{
      K(0, 0), K(1, 1), K(0, 2) + kCornerToCentre, K(1, 2) + kCornerToCentre, d[0], d[1], d[2], d[3], d[4], 0.0,
      0.0,     0.0};
  parameters.resize(kept);
  const char* model = kept == 4 ? "PINHOLE" : kept == 8 ? "OPENCV" : "FULL_OPENCV";
  std::string row = fmt::format("{} {} {} {}", id, model, camera.width, camera.height);
  for (const double value : parameters) row += fmt::format(" {:.17g}", value);
  return row + "\n";
}

std::string picture_rows(const CameraModel& camera, std::size_t id) {
  const Eigen::Quaterniond q(camera.R);
  return fmt::format("{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {} {}.png\n\n", id, q.w(), q.x(),
                     q.y(), q.z(), camera.t.x(), camera.t.y(), camera.t.z(), id, camera.name);
}

}  // namespace

ImportedCalibration read_colmap(const fs::path& folder) {
  const auto intrinsics = read_intrinsics(folder / "cameras.txt");
  const auto images = folder / "images.txt";
  auto pictures = read_pictures(images, intrinsics);
  name_cameras(images, pictures);
  ImportedCalibration imported;
  for (auto& picture : pictures) {
    make_focal_lengths_positive(picture.camera);
    imported.calibration.cameras.push_back(std::move(picture.camera));
  }
  imported.notes.push_back("COLMAP knows no unit: lengths stand as they are (say what they are with --unit)");
  return imported;
}

ColmapText colmap_text(const CalibrationFile& calibration) {
  ColmapText text{"# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]; (0, 0) is the corner of the top-left pixel\n",
                  "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME, then a line of points (none)\n",
                  "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] (none)\n"};
  for (std::size_t i = 0; i < calibration.cameras.size(); ++i) {
    const auto& camera = calibration.cameras[i];
    if (camera.R.determinant() < 0.0)
      throw InvalidInput(camera.name + " is of a left-handed set, which COLMAP does not know: convert with --mirror");
    text.cameras += camera_row(camera, i + 1);
    text.images += picture_rows(camera, i + 1);
  }
  return text;
}

}  // namespace rotunda::capture
