#include "capture/calibration/projection_text.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "capture/calibration/camera_rules.h"
#include "capture/calibration/projection_matrix.h"
#include "capture/calibration/text_rows.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kOfMatrix = 12, kOfParts = 21, kOfRow = 4;

struct NamedProjection {
  std::string name;
  ProjectionMatrix P;
};

using Size = std::pair<double, double>;

// Reads one file; the place of what is wrong is where the row in question stands.
class ProjectionReader {
 public:
  explicit ProjectionReader(fs::path file) : file_(std::move(file)) {}

  std::vector<NamedProjection> read(const std::string& name_of_file);
  const std::map<std::string, Size>& sizes() const { return sizes_; }

 private:
  void read_row(const TextRow& row);
  void read_size(const TextRow& row);
  void begin(const TextRow& row, std::string name);
  void append(const TextRow& row, std::size_t first);
  void finish(const TextRow& row);
  ProjectionMatrix matrix_of(const TextRow& row, const std::vector<double>& numbers) const;

  fs::path file_;
  std::vector<NamedProjection> found_;
  std::map<std::string, Size> sizes_;
  std::string name_;  // of the camera that is being read
  std::vector<double> numbers_;
  bool in_parts_ = false;  // K, R, t apart
};

// "dinoSR0001.png" is camera dinoSR0001: names of pictures stand for cameras.
std::string without_picture_ending(const std::string& name) {
  const auto ending = fs::path(name).extension().string();
  const bool picture = ending == ".png" || ending == ".jpg" || ending == ".ppm" || ending == ".tif";
  return picture ? fs::path(name).stem().string() : name;
}

void ProjectionReader::begin(const TextRow& row, std::string name) {
  CameraModel probe;
  if (const auto mistake = set_name(probe, without_picture_ending(name)); !mistake.empty())
    refuse(file_, row.line, row.words.front().column, "", mistake);
  name_ = probe.name;
  for (const auto& earlier : found_)
    if (earlier.name == name_) refuse(file_, row.line, 1, name_, "is there twice");
}

ProjectionMatrix ProjectionReader::matrix_of(const TextRow& row, const std::vector<double>& n) const {
  using Rows3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  if (n.size() == kOfMatrix) return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(n.data());
  CameraModel camera;
  for (const auto& mistake :
       {set_K(camera, Eigen::Map<const Rows3>(n.data())), set_R(camera, Eigen::Map<const Rows3>(n.data() + 9))})
    if (!mistake.empty()) refuse(file_, row.line, 1, name_, mistake);
  camera.t = Eigen::Map<const Eigen::Vector3d>(n.data() + 18);
  return projection_matrix(camera);
}

void ProjectionReader::finish(const TextRow& row) {
  found_.push_back({name_, matrix_of(row, numbers_)});
  name_.clear();
  numbers_.clear();
}

void ProjectionReader::append(const TextRow& row, std::size_t first) {
  const auto more = numbers_in(file_, row, first);
  numbers_.insert(numbers_.end(), more.begin(), more.end());
  in_parts_ = first == 1 && more.size() == kOfParts;
  const std::size_t wanted = in_parts_ ? kOfParts : kOfMatrix;
  if (numbers_.size() > wanted || (first == 1 && numbers_.size() < wanted) ||
      (first == 0 && more.size() != kOfRow && more.size() != kOfMatrix))
    refuse(file_, row.line, 1, name_,
           fmt::format("expected a projection matrix (12 numbers, or three lines of 4) or K, R, t "
                       "(21 numbers), found {} on this line",
                       more.size()));
  if (numbers_.size() == wanted) finish(row);
}

void ProjectionReader::read_row(const TextRow& row) {
  const auto& first = row.words.front();
  if (first.text == "CONTOUR" && row.words.size() == 1) return;
  const bool number = number_in(first).has_value();
  if (!name_.empty()) {
    if (!number)
      refuse(file_, row.line, first.column, name_,
             fmt::format("expected numbers of its matrix, found \"{}\"", first.text.substr(0, 40)));
    return append(row, 0);
  }
  const bool count = number && row.words.size() == 1 && found_.empty();
  if (count) return;  // how many cameras follow
  if (number && row.words.size() != kOfMatrix + 1 && row.words.size() != kOfParts + 1)
    refuse(file_, row.line, first.column, "", "expected a camera's name before its numbers");
  begin(row, first.text);
  if (row.words.size() > 1) append(row, 1);
}

void ProjectionReader::read_size(const TextRow& row) {
  std::istringstream words(row.comment);
  std::string key, name;
  double width = 0, height = 0;
  if (words >> key >> name >> width >> height && key == "image_size") sizes_[name] = {width, height};
}

std::vector<NamedProjection> ProjectionReader::read(const std::string& name_of_file) {
  const auto rows = split_rows(read_text(file_));
  name_ = name_of_file;
  for (const auto& row : rows) {
    read_size(row);
    if (!row.words.empty()) read_row(row);
  }
  if (!name_.empty())
    refuse(file_, static_cast<int>(rows.size()), 0, name_,
           fmt::format("its matrix ends after {} of 12 numbers", numbers_.size()));
  if (found_.empty()) refuse(file_, 0, 0, "", "holds no projection matrix");
  return found_;
}

std::vector<fs::path> matrix_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && (entry.path().extension() == ".txt" || entry.path().extension() == ".P"))
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (files.empty()) refuse(folder, 0, 0, "", "holds no matrices: expected <camera>.txt or <camera>.P");
  return files;
}

std::vector<NamedProjection> read_all(const fs::path& place, std::map<std::string, Size>& sizes) {
  std::vector<NamedProjection> all;
  const bool folder = fs::is_directory(place);
  for (const auto& file : folder ? matrix_files(place) : std::vector{place}) {
    ProjectionReader reader(file);
    for (auto& one : reader.read(folder ? file.stem().string() : "")) all.push_back(std::move(one));
    sizes.insert(reader.sizes().begin(), reader.sizes().end());
  }
  return all;
}

}  // namespace

ImportedCalibration read_projection_text(const fs::path& place) {
  std::map<std::string, Size> sizes;
  std::vector<ProjectionMatrix> matrices;
  std::vector<std::string> names;
  for (const auto& [name, P] : read_all(place, sizes)) {
    names.push_back(name);
    matrices.push_back(P);
  }
  ImportedCalibration imported;
  try {
    auto decomposed = decompose(matrices, names);
    imported.calibration.cameras = std::move(decomposed.cameras);
    if (decomposed.handedness == Handedness::left)
      imported.notes.push_back("the set is left-handed (every det R is -1); it is kept so, and works as it stands");
  } catch (const InvalidInput& error) {
    refuse(place, 0, 0, "", error.what());
  }
  for (auto& camera : imported.calibration.cameras)
    if (const auto size = sizes.find(camera.name); size != sizes.end())
      if (const auto mistake = set_image_size(camera, size->second.first, size->second.second); !mistake.empty())
        refuse(place, 0, 0, "image_size " + camera.name, mistake);
  return imported;
}

std::string projection_text(const CalibrationFile& calibration) {
  for (const auto& camera : calibration.cameras)
    if (camera.name.find_first_of(" \t,;#") != std::string::npos)
      throw InvalidInput("\"" + camera.name + "\" would be taken for several words in a text file; rename this camera");
  std::string text =
      "# one line a camera: name, then P (3x4, row by row); x ~ P X, pixel (0, 0) is the centre of the top-left "
      "pixel\n";
  for (const auto& camera : calibration.cameras)
    text += fmt::format("# image_size {} {} {}\n", camera.name, camera.width, camera.height);
  for (const auto& camera : calibration.cameras) {
    const ProjectionMatrix P = projection_matrix(camera);
    text += camera.name;
    for (Eigen::Index row = 0; row < 3; ++row)
      for (Eigen::Index column = 0; column < 4; ++column) text += fmt::format(" {:.17g}", P(row, column));
    text += "\n";
  }
  return text;
}

}  // namespace rotunda::capture
