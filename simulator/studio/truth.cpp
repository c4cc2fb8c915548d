#include "simulator/studio/truth.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <system_error>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "recon/colour/visibility.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/people/board_act.h"
#include "simulator/people/board_prop.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

json numbers(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

json numbers(const Eigen::Quaterniond& q) {
  return {q.w(), q.x(), q.y(), q.z()};
}

int nearest_frame(double seconds, int frames) {
  return static_cast<int>(std::lround(seconds / kActStep)) % frames;
}

json describe(const Performance& performance, const std::vector<capture::CameraModel>& cameras, const std::string& key,
              const SensorOptions& sensor) {
  json truth{{"key", key},
             {"person", performance.person()},
             {"act", performance.act()},
             {"act_frames", performance.frames()},
             {"act_step_ns", 40'000'000},
             {"is_cyclic", performance.is_cyclic()},
             {"cameras", json::array()},
             {"lenses", json::array()},
             {"heel_strikes", json::array()}};
  for (const auto& camera : cameras) truth["cameras"].push_back(camera.name);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto lens = lens_flaws(cameras[i], i, sensor);
    truth["lenses"].push_back(
        {{"blur_px", lens.blur_px}, {"red_scale", lens.red_scale}, {"blue_scale", lens.blue_scale}});
  }
  for (const auto& strike : performance.heel_strikes())
    truth["heel_strikes"].push_back({{"seconds", strike.seconds},
                                     {"act_frame", nearest_frame(strike.seconds, performance.frames())},
                                     {"side", strike.side == Side::left ? "left" : "right"}});
  return truth;
}

json joints_of(const Performance& performance, int frames) {
  json file{{"joints", json::array()}, {"frames", json::array()}};
  for (const auto& joint : performance.joints())
    file["joints"].push_back({{"name", joint.name}, {"parent", joint.parent}});
  for (int frame = 0; frame < frames; ++frame) {
    json positions = json::array(), rotations = json::array();
    for (const auto& state : performance.joints_at(act_seconds(frame))) {
      positions.push_back(numbers(state.position));
      rotations.push_back(numbers(state.rotation));
    }
    file["frames"].push_back({{"positions", positions}, {"rotations", rotations}});
  }
  return file;
}

json board_poses(int frames) {
  json file{{"corners", json::array()}, {"frames", json::array()}};
  for (const auto& corner : board_corners()) file["corners"].push_back(numbers(corner));
  for (int frame = 0; frame < frames; ++frame) {
    const Eigen::Isometry3d pose = board_pose(act_seconds(frame));
    file["frames"].push_back({{"position", numbers(Eigen::Vector3d(pose.translation()))},
                              {"rotation", numbers(Eigen::Quaterniond(pose.rotation()))}});
  }
  return file;
}

void write_json(const fs::path& file, const json& value) {
  std::ofstream out(file);
  out << value.dump(1) << '\n';
  if (!out.flush()) throw std::system_error(errno, std::generic_category(), "cannot write " + file.string());
}

std::string key_in(const fs::path& file) {
  std::ifstream in(file);
  const auto truth = json::parse(in, nullptr, /*allow_exceptions=*/false);
  return truth.is_object() ? truth.value("key", "") : "";
}

// Only what has our names: the folder is the user's.
void remove_frames(const fs::path& folder) {
  if (!fs::exists(folder)) return;
  std::vector<fs::path> stale;
  for (const auto& item : fs::recursive_directory_iterator(folder))
    if (item.is_regular_file() && item.path().filename().string().rfind("frame", 0) == 0) stale.push_back(item.path());
  for (const auto& file : stale) fs::remove(file);
}

fs::path mesh_folder(const fs::path& directory, std::size_t figure) {
  return directory / (figure == 0 ? "meshes" : fmt::format("carried{}", figure));
}

// A file with this name is whole, whenever the writer was stopped.
template <class Write>
void write_whole(const fs::path& file, const Write& write) {
  const fs::path part = file.parent_path() / ("part-" + file.filename().string());
  write(part);
  fs::rename(part, file);
}

void write_depth(const fs::path& file, const cv::Mat& depth) {
  if (!cv::imwrite(file.string(), depth, {cv::IMWRITE_EXR_TYPE, cv::IMWRITE_EXR_TYPE_FLOAT}))
    throw std::system_error(EIO, std::generic_category(), "cannot write " + file.string());
}

}  // namespace

std::string frame_name(int frame) {
  return fmt::format("frame{:06}", frame);
}

recon::TriangleMesh truth_mesh(const Performance& performance, capture::Timestamp exposure_start) {
  const int frame = act_frame_at(exposure_start, performance.frames());
  return performance.surfaces_at(act_seconds(frame)).front();
}

cv::Mat true_depth(const capture::CameraModel& camera, const std::vector<recon::TriangleMesh>& surfaces) {
  constexpr float kFarthest = 1e6F;  // metres: beyond is nothing
  cv::Mat nearest(camera.height, camera.width, CV_32FC1, cv::Scalar(2.0 * kFarthest));
  for (const auto& surface : surfaces) cv::min(nearest, recon::render_depth(surface, camera).depth, nearest);
  nearest.setTo(0.0, nearest > kFarthest);
  return nearest;
}

TruthFiles::TruthFiles(fs::path directory, const Performance& performance,
                       const std::vector<capture::CameraModel>& cameras, int frames, const std::string& key,
                       const SensorOptions& sensor)
    : directory_(std::move(directory)), performance_(performance), cameras_(cameras) {
  const bool is_continued = !key.empty() && key_in(directory_ / "truth.json") == key;
  for (std::size_t figure = 0; figure < performance.figures().size(); ++figure) {
    if (!is_continued) remove_frames(mesh_folder(directory_, figure));
    fs::create_directories(mesh_folder(directory_, figure));
  }
  for (const char* kind : {"mattes", "depth"}) {
    if (!is_continued) remove_frames(directory_ / kind);
    for (const auto& camera : cameras) fs::create_directories(directory_ / kind / camera.name);
  }
  capture::write_calibration(directory_ / "calibration.yaml", cameras);
  write_json(directory_ / "joints.json", joints_of(performance, frames));
  if (performance.act() == "board") write_json(directory_ / "board.json", board_poses(frames));
  if (performance.board_at(0.0)) write_board(directory_ / "board.yaml");
  write_json(directory_ / "truth.json", describe(performance, cameras, key, sensor));
}

bool TruthFiles::has(int frame) const {
  return fs::exists(directory_ / "meshes" / (frame_name(frame) + ".ply"));  // written last
}

void TruthFiles::write_frame(int frame, const std::vector<ScenePicture>& pictures) const {
  const auto surfaces = performance_.surfaces_at(act_seconds(frame));
  const auto name = frame_name(frame);
  tbb::parallel_for(std::size_t{0}, cameras_.size(), [&](std::size_t camera) {
    capture::write_png(directory_ / "mattes" / cameras_[camera].name / (name + ".png"), pictures[camera].matte);
    write_depth(directory_ / "depth" / cameras_[camera].name / (name + ".exr"), true_depth(cameras_[camera], surfaces));
  });
  for (std::size_t figure = surfaces.size(); figure-- > 0;)
    write_whole(mesh_folder(directory_, figure) / (name + ".ply"),
                [&](const fs::path& file) { recon::write_ply(file, surfaces[figure]); });
}

}  // namespace rotunda::simulator
