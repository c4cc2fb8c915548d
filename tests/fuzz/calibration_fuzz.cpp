// Any text as a calibration or a board of this or another program: the first line says which reader gets the rest
// (opencv, json, projections, colmap, board; COLMAP's two files are parted by a line "----"). Read or refused by
// ConfigError; what is read is a set of cameras that can be worked with, and is read the same again from what is
// written of it.
#include <stdlib.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "capture/calibration/board.h"
#include "capture/calibration/camera_json.h"
#include "capture/calibration/colmap_text.h"
#include "capture/calibration/projection_text.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

void require(bool claim) {
  if (!claim) std::abort();
}

// In memory where the system has such a place: thousands of small files a second.
const fs::path& scratch() {
  static const fs::path kFolder = [] {
    const fs::path base = fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
    std::string name = (base / "calibration_fuzz.XXXXXX").string();
    require(mkdtemp(name.data()) != nullptr);
    static const struct Sweeper {
      fs::path folder;
      ~Sweeper() {
        std::error_code ignored;
        fs::remove_all(folder, ignored);
      }
    } kSweeper{name};
    return fs::path(name);
  }();
  return kFolder;
}

fs::path file_with(const char* name, std::string_view text) {
  const fs::path file = scratch() / name;
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

// What every later step counts on.
void require_workable(const CalibrationFile& calibration) {
  require(!calibration.cameras.empty());
  for (const auto& camera : calibration.cameras) {
    require(!camera.name.empty() && camera.name.find('/') == std::string::npos);
    require(camera.K.allFinite() && camera.t.allFinite() && camera.distortion.allFinite());
    require(camera.K(0, 0) > 0.0 && camera.K(1, 1) > 0.0 && camera.K(2, 2) == 1.0);
    require(camera.K(1, 0) == 0.0 && camera.K(2, 0) == 0.0 && camera.K(2, 1) == 0.0);
    require((camera.R * camera.R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-8);
    require(camera.width >= 0 && camera.height >= 0 && (camera.width > 0) == (camera.height > 0));
  }
}

template <class Matrix>
bool alike(const Matrix& a, const Matrix& b) {
  return (a - b).cwiseAbs().maxCoeff() <= 1e-9 * (1.0 + a.cwiseAbs().maxCoeff());
}

void require_alike(const CalibrationFile& a, const CalibrationFile& b) {
  require(a.cameras.size() == b.cameras.size());
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    const auto &one = a.cameras[i], &other = b.cameras[i];
    require(one.name == other.name && one.width == other.width && one.height == other.height);
    require(alike(one.K, other.K) && alike(one.R, other.R) && alike(one.t, other.t));
    require(alike(one.distortion, other.distortion));
  }
}

bool have_sizes(const CalibrationFile& calibration) {
  for (const auto& camera : calibration.cameras)
    if (camera.width == 0) return false;
  return true;
}

void read_opencv(std::string_view text) {
  const auto calibration = read_calibration_file(file_with("calibration.yaml", text));
  require_workable(calibration);
  const auto again = scratch() / "again.yaml";
  write_calibration(again, calibration);
  require_alike(calibration, read_calibration_file(again));
}

void read_json(std::string_view text) {
  const auto read = read_camera_json(file_with("cameras.json", text));
  require_workable(read.calibration);
  if (have_sizes(read.calibration))
    require_alike(read.calibration,
                  read_camera_json(file_with("again.json", camera_json(read.calibration))).calibration);
}

void read_projections(std::string_view text) {
  const auto read = read_projection_text(file_with("projections.txt", text));
  require_workable(read.calibration);
  require(!projection_text(read.calibration).empty());
}

void read_colmap_model(std::string_view text) {
  constexpr std::string_view kBetween = "----\n";
  const auto between = text.find(kBetween);
  file_with("cameras.txt", text.substr(0, between));
  file_with("images.txt", between == text.npos ? std::string_view() : text.substr(between + kBetween.size()));
  const auto read = read_colmap(scratch());
  require_workable(read.calibration);
  for (const auto& camera : read.calibration.cameras)
    if (camera.R.determinant() < 0.0) return;  // one negative focal length: COLMAP cannot hold what it becomes
  const auto written = colmap_text(read.calibration);
  file_with("cameras.txt", written.cameras);
  file_with("images.txt", written.images);
  require_alike(read.calibration, read_colmap(scratch()).calibration);
}

void read_board_file(std::string_view text) {
  const auto boards = read_boards(file_with("board.yaml", text));
  require(!boards.empty());
  check_boards(boards);
  for (const auto& board : boards) {
    require(corner_count(board) > 0 && board.square > 0.0);
    require(black_rectangles(board).size() >= static_cast<std::size_t>(board.columns * board.rows) / 2);
  }
}

void run(std::string_view input) {
  const auto line = input.find('\n');
  if (line == input.npos) return;
  const auto reader = input.substr(0, line), text = input.substr(line + 1);
  try {
    if (reader == "opencv") read_opencv(text);
    if (reader == "json") read_json(text);
    if (reader == "projections") read_projections(text);
    if (reader == "colmap") read_colmap_model(text);
    if (reader == "board") read_board_file(text);
  } catch (const ConfigError&) {
  }
}

}  // namespace
}  // namespace rotunda::capture

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  rotunda::capture::run({reinterpret_cast<const char*>(data), size});
  return 0;
}
