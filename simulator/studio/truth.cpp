#include "simulator/studio/truth.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {
namespace {

nlohmann::json joints_of(const Performance& performance, double seconds) {
  nlohmann::json joints;
  const auto states = performance.joints_at(seconds);
  for (std::size_t i = 0; i < states.size(); ++i) {
    const auto& centre = states[i].position;
    joints[performance.joints()[i].name] = {centre.x(), centre.y(), centre.z()};
  }
  return joints;
}

nlohmann::json describe(const Performance& performance, int frames) {
  nlohmann::json truth{{"person", performance.person()},          {"act", performance.act()},
                       {"act_frames", performance.frames()},      {"act_step_ns", 40'000'000},
                       {"heel_strikes", nlohmann::json::array()}, {"joints", nlohmann::json::array()}};
  for (const auto& strike : performance.heel_strikes())
    truth["heel_strikes"].push_back(
        {{"seconds", strike.seconds}, {"side", strike.side == Side::left ? "left" : "right"}});
  for (int frame = 0; frame < frames; ++frame) truth["joints"].push_back(joints_of(performance, act_seconds(frame)));
  return truth;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text << '\n';
  if (!out.flush()) throw std::system_error(errno, std::generic_category(), "cannot write " + file.string());
}

}  // namespace

std::string frame_name(int frame) {
  return fmt::format("frame{:06}", frame);
}

recon::TriangleMesh truth_mesh(const Performance& performance, capture::Timestamp exposure_start) {
  const int frame = act_frame_at(exposure_start, performance.frames());
  return performance.surfaces_at(act_seconds(frame)).front();
}

TruthFiles::TruthFiles(std::filesystem::path directory, const SceneRenderer& studio, int frames)
    : directory_(std::move(directory)), studio_(studio) {
  std::filesystem::create_directories(directory_ / "meshes");
  for (const auto& camera : studio.cameras()) std::filesystem::create_directories(directory_ / "mattes" / camera.name);
  capture::write_calibration(directory_ / "calibration.yaml", studio.cameras());
  write_text(directory_ / "truth.json", describe(studio.performance(), frames).dump(2));
}

void TruthFiles::write_frame(int frame, const std::vector<ScenePicture>& pictures) const {
  recon::write_ply(directory_ / "meshes" / (frame_name(frame) + ".ply"),
                   studio_.performance().surfaces_at(act_seconds(frame)).front());
  for (std::size_t camera = 0; camera < pictures.size(); ++camera)
    capture::write_png(directory_ / "mattes" / studio_.cameras()[camera].name / (frame_name(frame) + ".png"),
                       pictures[camera].matte);
}

}  // namespace rotunda::simulator
