#include "capture/calibration/camera_json.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "capture/calibration/camera_rules.h"
#include "capture/calibration/text_rows.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

using nlohmann::json;
using Rows3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Numbers = std::vector<double>;

constexpr std::size_t kMostNumbers = 64;  // in one value; more is no camera's

// Collects the mistakes of one camera's object.
class CameraObject {
 public:
  CameraObject(const json& object, std::string place, std::vector<ConfigProblem>& problems)
      : object_(object), place_(std::move(place)), problems_(problems) {}

  // `name` stands for the key "name" where it is known already.
  std::optional<CameraModel> read(const std::string& name);

 private:
  const json* find(std::initializer_list<const char*> keys, std::string& found) const;
  void tell(const std::string& key, const std::string& mistake);
  std::optional<Numbers> numbers(std::initializer_list<const char*> keys, std::size_t count, bool needed);
  void read_name(CameraModel& camera, const std::string& name);
  void read_size(CameraModel& camera);
  void read_intrinsics(CameraModel& camera);
  void read_pose(CameraModel& camera);

  const json& object_;
  std::string place_;
  std::vector<ConfigProblem>& problems_;
};

const json* CameraObject::find(std::initializer_list<const char*> keys, std::string& found) const {
  for (const char* key : keys)
    if (const auto at = object_.find(key); at != object_.end()) {
      found = key;
      return &*at;
    }
  found = *keys.begin();
  return nullptr;
}

void CameraObject::tell(const std::string& key, const std::string& mistake) {
  if (!mistake.empty()) problems_.push_back({0, 0, place_ + "." + key, mistake});
}

bool append(const json& value, Numbers& numbers, int depth) {
  if (numbers.size() > kMostNumbers) return false;
  if (value.is_number()) {
    numbers.push_back(value.get<double>());
    return std::isfinite(numbers.back());
  }
  if (!value.is_array() || depth == 0) return false;
  for (const auto& element : value)
    if (!append(element, numbers, depth - 1)) return false;
  return true;
}

// `count` 0: any number of them.
std::optional<Numbers> CameraObject::numbers(std::initializer_list<const char*> keys, std::size_t count, bool needed) {
  std::string key;
  const json* value = find(keys, key);
  const auto expected =
      count == 0 ? std::string("expected a list of numbers") : fmt::format("expected {} numbers", count);
  if (!value) {
    if (needed) tell(key, "is missing; " + expected);
    return std::nullopt;
  }
  Numbers result;
  if (!append(*value, result, 2)) {
    tell(key, expected + ", finite, plain or in rows");
    return std::nullopt;
  }
  if (count != 0 && result.size() != count) {
    tell(key, fmt::format("{}, found {}", expected, result.size()));
    return std::nullopt;
  }
  return result;
}

void CameraObject::read_name(CameraModel& camera, const std::string& name) {
  std::string key;
  const json* value = name.empty() ? find({"name", "id"}, key) : nullptr;
  if (!name.empty()) return tell("name", set_name(camera, name));
  if (!value) return tell("name", "is missing");
  if (value->is_number_unsigned()) return tell(key, set_name(camera, std::to_string(value->get<std::uint64_t>())));
  tell(key, set_name(camera, value->is_string() ? value->get<std::string>() : std::string()));
}

void CameraObject::read_size(CameraModel& camera) {
  if (object_.contains("width") || object_.contains("height")) {
    const auto width = numbers({"width"}, 1, true), height = numbers({"height"}, 1, true);
    if (width && height) tell("width", set_image_size(camera, (*width)[0], (*height)[0]));
  } else if (const auto size = numbers({"image_size", "resolution", "size"}, 2, false)) {
    tell("image_size", set_image_size(camera, (*size)[0], (*size)[1]));
  }
}

void CameraObject::read_intrinsics(CameraModel& camera) {
  if (const auto values = numbers({"K"}, 9, true)) tell("K", set_K(camera, Eigen::Map<const Rows3>(values->data())));
  if (const auto values = numbers({"dist", "distCoef", "dist_coeffs", "distortion"}, 0, false))
    tell("dist", set_distortion(camera, *values));
  if (const auto rms = numbers({"rms_px"}, 1, false)) {
    if ((*rms)[0] < 0.0) return tell("rms_px", "expected pixels, not negative");
    camera.rms_px = (*rms)[0];
  }
}

Eigen::Matrix3d rodrigues(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle < 1e-300) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

void CameraObject::read_pose(CameraModel& camera) {
  if (object_.contains("R")) {
    if (const auto values = numbers({"R"}, 9, true)) tell("R", set_R(camera, Eigen::Map<const Rows3>(values->data())));
  } else if (object_.contains("rvec")) {
    if (const auto values = numbers({"rvec"}, 3, true))
      tell("rvec", set_R(camera, rodrigues(Eigen::Map<const Eigen::Vector3d>(values->data()))));
  } else {
    tell("R", "is missing; expected 9 numbers, or rvec with 3");
  }
  if (const auto values = numbers({"t", "tvec"}, 3, true)) camera.t = Eigen::Map<const Eigen::Vector3d>(values->data());
}

std::optional<CameraModel> CameraObject::read(const std::string& name) {
  const std::size_t before = problems_.size();
  if (!object_.is_object()) {
    problems_.push_back({0, 0, place_, "expected an object with name, K, dist, R, t"});
    return std::nullopt;
  }
  CameraModel camera;
  read_name(camera, name);
  if (!camera.name.empty()) place_ += " (" + camera.name + ")";
  read_size(camera);
  read_intrinsics(camera);
  read_pose(camera);
  if (problems_.size() != before) return std::nullopt;
  make_focal_lengths_positive(camera);
  return camera;
}

void read_cameras(const json& list, const std::string& path, CalibrationFile& calibration,
                  std::vector<ConfigProblem>& problems) {
  std::set<std::string> names;
  const auto read_one = [&](const json& object, const std::string& place, const std::string& name) {
    auto camera = CameraObject(object, place, problems).read(name);
    if (!camera) return;
    if (!names.insert(camera->name).second)
      problems.push_back({0, 0, place, fmt::format("the name {} is used twice", camera->name)});
    calibration.cameras.push_back(std::move(*camera));
  };
  if (list.is_array())
    for (std::size_t i = 0; i < list.size(); ++i) read_one(list[i], fmt::format("{}[{}]", path, i), "");
  else if (list.is_object())
    for (const auto& [name, object] : list.items()) read_one(object, path + "." + name, name);
  else
    problems.push_back({0, 0, path, "expected a list of cameras, or an object with one under each name"});
  if (problems.empty() && calibration.cameras.empty()) problems.push_back({0, 0, path, "holds no camera"});
}

json rows_of(const Eigen::Matrix3d& matrix) {
  json rows = json::array();
  for (Eigen::Index row = 0; row < 3; ++row) rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2)});
  return rows;
}

}  // namespace

ImportedCalibration read_camera_json(const std::filesystem::path& file) {
  const auto text = read_text(file);
  ImportedCalibration imported;
  std::vector<ConfigProblem> problems;
  try {
    const json root = json::parse(text);
    const bool wrapped = root.is_object() && root.contains("cameras");
    if (wrapped && root.contains("unit")) {
      if (root["unit"].is_string())
        imported.calibration.unit = root["unit"].get<std::string>();
      else
        problems.push_back({0, 0, "unit", "expected a word such as \"m\""});
    }
    read_cameras(wrapped ? root["cameras"] : root, wrapped ? "cameras" : "(root)", imported.calibration, problems);
  } catch (const json::parse_error& error) {
    problems.push_back({0, 0, "", std::string("is no JSON: ") + error.what()});  // which names line and column
  }
  if (!problems.empty()) throw ConfigError(file, std::move(problems));
  return imported;
}

std::string camera_json(const CalibrationFile& calibration) {
  json cameras = json::array();
  for (const auto& camera : calibration.cameras) {
    const auto& d = camera.distortion;
    cameras.push_back({{"name", camera.name},
                       {"image_size", {camera.width, camera.height}},
                       {"K", rows_of(camera.K)},
                       {"dist", {d[0], d[1], d[2], d[3], d[4]}},
                       {"R", rows_of(camera.R)},
                       {"t", {camera.t.x(), camera.t.y(), camera.t.z()}},
                       {"rms_px", camera.rms_px}});
  }
  json root = {{"cameras", cameras}};
  if (!calibration.unit.empty()) root["unit"] = calibration.unit;
  return root.dump(1) + "\n";
}

}  // namespace rotunda::capture
