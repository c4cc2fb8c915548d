#include "simulator/studio/truth.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/studio/frame_cache.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {
namespace {

constexpr std::array<const char*, kJoints> kJointNames = {
    "pelvis",    "spine",           "chest",         "neck",       "head",       "upper_arm_left", "forearm_left",
    "hand_left", "upper_arm_right", "forearm_right", "hand_right", "thigh_left", "shank_left",     "foot_left",
    "toes_left", "thigh_right",     "shank_right",   "foot_right", "toes_right"};

nlohmann::json joints_of(const Skeleton& skeleton, const Pose& pose) {
  nlohmann::json joints;
  const auto centres = joint_centres(skeleton, pose);
  for (std::size_t i = 0; i < kJoints; ++i) joints[kJointNames[i]] = {centres[i].x(), centres[i].y(), centres[i].z()};
  return joints;
}

nlohmann::json describe(const Person& person, Act act, int frames) {
  nlohmann::json truth{{"person", person.name},
                       {"act", act_names()[static_cast<std::size_t>(act)]},
                       {"act_frames", act_frames(act)},
                       {"act_step_ns", 40'000'000},
                       {"heel_strikes", nlohmann::json::array()},
                       {"joints", nlohmann::json::array()}};
  for (const auto& strike : heel_strikes(act))
    truth["heel_strikes"].push_back(
        {{"seconds", strike.seconds}, {"side", strike.side == Side::left ? "left" : "right"}});
  for (int frame = 0; frame < frames; ++frame)
    truth["joints"].push_back(joints_of(person.skeleton, pose_at(person.skeleton, act, frame * kActStep)));
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

recon::TriangleMesh truth_mesh(const Person& person, Act act, capture::Timestamp exposure_start) {
  return posed_mesh(person, pose_at(person.skeleton, act, act_seconds(exposure_start, act)));
}

TruthFiles::TruthFiles(std::filesystem::path directory, const SceneRenderer& studio, Act act, int frames)
    : directory_(std::move(directory)), studio_(studio), act_(act) {
  std::filesystem::create_directories(directory_ / "meshes");
  for (const auto& camera : studio.cameras()) std::filesystem::create_directories(directory_ / "mattes" / camera.name);
  capture::write_calibration(directory_ / "calibration.yaml", studio.cameras());
  write_text(directory_ / "truth.json", describe(studio.person(), act, frames).dump(2));
}

void TruthFiles::write_frame(int frame, const std::vector<ScenePicture>& pictures) const {
  const Person& person = studio_.person();
  recon::write_ply(directory_ / "meshes" / (frame_name(frame) + ".ply"),
                   posed_mesh(person, pose_at(person.skeleton, act_, frame * kActStep)));
  for (std::size_t camera = 0; camera < pictures.size(); ++camera)
    capture::write_png(directory_ / "mattes" / studio_.cameras()[camera].name / (frame_name(frame) + ".png"),
                       pictures[camera].matte);
}

}  // namespace rotunda::simulator
