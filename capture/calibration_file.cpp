#include "capture/calibration_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/LU>
#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/core/eigen.hpp>
#include <opencv2/core/persistence.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <system_error>

#include "capture/calibration/camera_rules.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kLargestColourGain = 100.0, kLeastColourVolume = 1e-6;  // of a colour matrix, its determinant
constexpr std::size_t kLargestFile = 16U << 20U;                         // bytes; a thousand cameras take one

// Collects the mistakes of one camera's map under its place in the file.
// Of lenses alone nothing more is wanted.
enum class Poses { wanted, optional };

class CameraReader {
 public:
  CameraReader(const YAML::Node& map, std::string place, Poses poses, std::vector<ConfigProblem>& problems)
      : map_(map), place_(std::move(place)), poses_(poses), problems_(problems) {}

  std::optional<CameraModel> read();
  const std::optional<Eigen::Matrix3d>& colour() const { return colour_; }  // after read()

 private:
  void complain(const YAML::Node& node, const std::string& key, std::string message);
  YAML::Node wanted(const char* key, const char* what);
  std::optional<std::vector<double>> numbers(const YAML::Node& node, const char* key, std::size_t rows,
                                             std::size_t columns);
  void tell(const YAML::Node& node, const char* key, std::string mistake);  // nothing if it is empty
  void read_name(CameraModel& camera);
  void read_size(CameraModel& camera);
  void read_K(CameraModel& camera);
  void read_distortion(CameraModel& camera);
  void read_pose(CameraModel& camera);
  void read_rms(CameraModel& camera);
  void read_colour();

  const YAML::Node map_;
  std::string place_;
  Poses poses_;
  std::vector<ConfigProblem>& problems_;
  std::string name_;
  std::optional<Eigen::Matrix3d> colour_;
};

int counted_from_one(int place) {
  return place < 0 ? 0 : place + 1;
}

ConfigProblem problem_at(const YAML::Node& node, std::string key, std::string message) {
  const auto mark = node.IsDefined() ? node.Mark() : YAML::Mark::null_mark();
  return {counted_from_one(mark.line), counted_from_one(mark.column), std::move(key), std::move(message)};
}

void CameraReader::complain(const YAML::Node& node, const std::string& key, std::string message) {
  std::string path = key.empty() ? place_ : place_ + "." + key;
  if (!name_.empty()) path += " (" + name_ + ")";
  problems_.push_back(problem_at(node.IsDefined() ? node : map_, std::move(path), std::move(message)));
}

YAML::Node CameraReader::wanted(const char* key, const char* what) {
  const YAML::Node node = map_[key];
  if (!node.IsDefined()) complain(map_, key, fmt::format("is missing; expected {}", what));
  return node;
}

void append_scalars(const YAML::Node& node, int depth, std::vector<double>& out) {
  if (!node.IsSequence()) {
    out.push_back(node.as<double>());
    return;
  }
  if (depth == 0) throw std::length_error("nested too deep");
  if (node.size() > 64) throw std::length_error("too long");
  for (const auto& element : node) append_scalars(element, depth - 1, out);
}

// A matrix of the given shape from !!opencv-matrix (row by row) or from plain, perhaps nested, sequences.
// A vector may stand or lie.
std::optional<std::vector<double>> CameraReader::numbers(const YAML::Node& node, const char* key, std::size_t rows,
                                                         std::size_t columns) {
  const bool vector = rows == 1 || columns == 1;
  const auto expected = vector ? fmt::format("expected {} numbers", rows * columns)
                               : fmt::format("expected a {} x {} matrix", rows, columns);
  std::vector<double> values;
  try {
    if (node.IsMap()) {
      const auto written_rows = node["rows"].as<std::size_t>(), written_columns = node["cols"].as<std::size_t>();
      const bool fits = (written_rows == rows && written_columns == columns) ||
                        (vector && written_rows == columns && written_columns == rows);
      if (!fits) {
        complain(node, key, fmt::format("{}, found {} x {}", expected, written_rows, written_columns));
        return std::nullopt;
      }
      append_scalars(node["data"], 1, values);
    } else {
      append_scalars(node, 2, values);
    }
  } catch (const std::exception&) {  // yaml-cpp's or ours: something that is not a number
    complain(node, key, expected + " (an !!opencv-matrix with rows, cols, data, or a plain sequence)");
    return std::nullopt;
  }
  if (values.size() != rows * columns) {
    complain(node, key, fmt::format("{}, found {} numbers", expected, values.size()));
    return std::nullopt;
  }
  for (const double value : values)
    if (!std::isfinite(value)) {
      complain(node, key, "every number must be finite; found infinity or NaN");
      return std::nullopt;
    }
  return values;
}

void CameraReader::tell(const YAML::Node& node, const char* key, std::string mistake) {
  if (!mistake.empty()) complain(node, key, std::move(mistake));
}

void CameraReader::read_name(CameraModel& camera) {
  const YAML::Node node = wanted("name", "the camera's name");
  if (!node.IsDefined()) return;
  tell(node, "name", set_name(camera, node.IsScalar() ? node.Scalar() : std::string()));
  name_ = camera.name;
}

void CameraReader::read_size(CameraModel& camera) {
  const YAML::Node node = wanted("image_size", "[width, height] in pixels");
  if (!node.IsDefined()) return;
  if (const auto size = numbers(node, "image_size", 1, 2))
    tell(node, "image_size", set_image_size(camera, (*size)[0], (*size)[1]));
}

void CameraReader::read_K(CameraModel& camera) {
  const YAML::Node node = wanted("K", "a 3 x 3 matrix");
  if (!node.IsDefined()) return;
  if (const auto values = numbers(node, "K", 3, 3))
    tell(node, "K", set_K(camera, Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values->data())));
}

void CameraReader::read_distortion(CameraModel& camera) {
  const YAML::Node node = map_["distortion"];
  if (!node.IsDefined()) return;
  const auto values = numbers(node, "distortion", 1, 5);
  if (values) camera.distortion = Eigen::Map<const Eigen::Matrix<double, 5, 1>>(values->data());
}

void CameraReader::read_pose(CameraModel& camera) {
  if (poses_ == Poses::optional && !map_["R"].IsDefined() && !map_["t"].IsDefined()) return;
  const YAML::Node rotation = wanted("R", "a 3 x 3 rotation matrix"), translation = wanted("t", "three numbers");
  if (translation.IsDefined())
    if (const auto values = numbers(translation, "t", 3, 1))
      camera.t = Eigen::Map<const Eigen::Vector3d>(values->data());
  if (!rotation.IsDefined()) return;
  const auto values = numbers(rotation, "R", 3, 3);
  if (!values) return;
  tell(rotation, "R", set_R(camera, Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values->data())));
}

void CameraReader::read_rms(CameraModel& camera) {
  const YAML::Node node = map_["rms_px"];
  if (!node.IsDefined()) return;
  const auto value = numbers(node, "rms_px", 1, 1);
  if (value && (*value)[0] < 0.0) return complain(node, "rms_px", "expected pixels, not negative");
  if (value) camera.rms_px = (*value)[0];
}

void CameraReader::read_colour() {
  const YAML::Node node = map_["colour"];
  if (!node.IsDefined()) return;
  const auto values = numbers(node, "colour", 3, 3);
  if (!values) return;
  const Eigen::Matrix3d matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values->data());
  if (!(matrix.determinant() > kLeastColourVolume && matrix.cwiseAbs().maxCoeff() < kLargestColourGain))
    return complain(node, "colour",
                    "expected a matrix near gains a channel (linear light of the rig from the camera's)");
  colour_ = matrix;
}

std::optional<CameraModel> CameraReader::read() {
  const std::size_t before = problems_.size();
  if (!map_.IsMap()) {
    complain(map_, "", "expected a map with name, image_size, K, distortion, R, t");
    return std::nullopt;
  }
  CameraModel camera;
  read_name(camera);
  read_size(camera);
  read_K(camera);
  read_distortion(camera);
  read_pose(camera);
  read_rms(camera);
  read_colour();
  if (problems_.size() != before) return std::nullopt;
  make_focal_lengths_positive(camera);
  return camera;
}

std::string whole_text(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw ConfigError(file, {{0, 0, "", "is a folder; give the calibration file itself"}});
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ConfigError(file, {{0, 0, "", "cannot be opened; does the file exist, and may it be read?"}});
  std::string text(kLargestFile + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kLargestFile) throw ConfigError(file, {{0, 0, "", "is too large for a calibration (over 16 MB)"}});
  return text;
}

void refuse_names_used_twice(const YAML::Node& list, const std::vector<CameraModel>& cameras,
                             std::vector<ConfigProblem>& problems) {
  std::set<std::string> names;
  for (const auto& camera : cameras)
    if (!names.insert(camera.name).second)
      problems.push_back(problem_at(list, "cameras", fmt::format("the name {} is used twice", camera.name)));
}

CalibrationFile parse(const YAML::Node& root, Poses poses, std::vector<ConfigProblem>& problems) {
  CalibrationFile calibration;
  if (!root.IsMap()) {
    problems.push_back(problem_at(root, "", "expected a map with unit and cameras; is this a calibration file?"));
    return calibration;
  }
  const YAML::Node unit = root["unit"], list = root["cameras"];
  if (unit.IsDefined() && !unit.IsScalar())
    problems.push_back(problem_at(unit, "unit", "expected a word such as \"m\""));
  if (unit.IsDefined() && unit.IsScalar()) calibration.unit = unit.Scalar();
  if (!list.IsDefined() || !list.IsSequence() || list.size() == 0) {
    problems.push_back(
        problem_at(list.IsDefined() ? list : root, "cameras", "expected a sequence of at least one camera"));
    return calibration;
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    CameraReader reader(list[i], fmt::format("cameras[{}]", i), poses, problems);
    auto camera = reader.read();
    if (!camera) continue;
    if (reader.colour()) calibration.colour[camera->name] = *reader.colour();
    calibration.cameras.push_back(std::move(*camera));
  }
  refuse_names_used_twice(list, calibration.cameras, problems);
  return calibration;
}

CalibrationFile parse_text(const std::filesystem::path& file, const std::string& text, Poses poses) {
  std::vector<ConfigProblem> problems;
  CalibrationFile calibration;
  try {
    calibration = parse(YAML::Load(text), poses, problems);
  } catch (const YAML::Exception& error) {
    problems.push_back({counted_from_one(error.mark.line), counted_from_one(error.mark.column), "",
                        "is not YAML as OpenCV's FileStorage writes it: " + error.msg});
  }
  if (!problems.empty()) throw ConfigError(file, std::move(problems));
  return calibration;
}

template <class Matrix>
cv::Mat as_mat(const Matrix& matrix) {
  cv::Mat result;
  cv::eigen2cv(matrix, result);
  return result;
}

std::string text_of(const CalibrationFile& calibration) {
  cv::FileStorage storage("calibration.yaml",
                          cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
  if (!calibration.unit.empty()) storage << "unit" << calibration.unit;
  storage << "cameras"
          << "[";
  for (const auto& camera : calibration.cameras) {
    storage << "{"
            << "name" << camera.name;
    storage << "image_size"
            << "[:" << camera.width << camera.height << "]";
    storage << "K" << as_mat(camera.K);
    storage << "distortion" << as_mat(Eigen::Matrix<double, 1, 5>(camera.distortion.transpose()));
    storage << "R" << as_mat(camera.R) << "t" << as_mat(camera.t);
    if (const auto colour = calibration.colour.find(camera.name); colour != calibration.colour.end())
      storage << "colour" << as_mat(colour->second);
    storage << "rms_px" << camera.rms_px << "}";
  }
  storage << "]";
  return storage.releaseAndGetString();
}

std::string checked_text_of(const CalibrationFile& calibration) {
  try {
    std::string text = text_of(calibration);
    parse_text("calibration", text, Poses::wanted);
    return text;
  } catch (const ConfigError& error) {
    throw InvalidInput(std::string("this calibration cannot be written: ") + error.what());
  } catch (const cv::Exception& error) {
    throw InvalidInput("this calibration cannot be written: " + error.err);
  }
}

}  // namespace

Eigen::Matrix3d CalibrationFile::colour_of(const std::string& camera) const {
  const auto found = colour.find(camera);
  return found == colour.end() ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : found->second;
}

CalibrationFile read_calibration_file(const std::filesystem::path& file) {
  return parse_text(file, whole_text(file), Poses::wanted);
}

std::vector<CameraModel> read_lenses(const std::filesystem::path& file) {
  return parse_text(file, whole_text(file), Poses::optional).cameras;
}

std::vector<CameraModel> read_calibration(const std::filesystem::path& file) {
  return read_calibration_file(file).cameras;
}

void write_calibration(const std::filesystem::path& file, const CalibrationFile& calibration) {
  const std::string text = checked_text_of(calibration);
  const std::filesystem::path partial = file.string() + ".partial";
  std::ofstream stream(partial, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  std::error_code error = stream ? std::error_code{} : std::make_error_code(std::errc::io_error);
  if (!error) std::filesystem::rename(partial, file, error);
  if (!error) return;
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  throw std::system_error(error, "cannot write " + file.string());
}

void write_calibration(const std::filesystem::path& file, std::span<const CameraModel> cameras) {
  write_calibration(file, CalibrationFile{"m", {cameras.begin(), cameras.end()}, {}});
}

}  // namespace rotunda::capture
