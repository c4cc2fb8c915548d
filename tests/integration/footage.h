#pragma once
// A ball before a blue screen, as somebody's folder of pictures: for tests of import and reconstruction.
#include <fmt/format.h>

#include <cmath>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "simulator/studio/camera_layout.h"
#include "tests/integration/house_test.h"
#include "tests/support/ball_scene.h"

namespace rotunda::tests {

inline constexpr int kCameras = 6, kFrames = 2;
inline const Ball kBall{.centre = {0.0, 0.0, 0.9}, .radius = 0.5};
inline const cv::Vec3f kBlue(30, 60, 200);

class Footage : public HouseTest {
 protected:
  Footage() : cameras_(simulator::camera_layout({.cameras = kCameras, .width = 180, .height = 144})) {
    capture::write_calibration(calibration(), cameras_);
    const auto colour = [](std::size_t, const Eigen::Vector3d& at) {
      return std::fmod(at.z() * 10.0 + 100.0, 2.0) < 1.0 ? cv::Vec3f(220, 180, 60) : cv::Vec3f(200, 60, 50);
    };
    for (const auto& camera : cameras_) {
      const auto picture = picture_of(camera, std::span(&kBall, 1), kBlue, colour).rgb;
      for (int frame = 0; frame < kFrames; ++frame) write(camera.name, frame, picture);
    }
  }

  std::filesystem::path images() const { return folder() / "images"; }
  std::filesystem::path calibration() const { return folder() / "calibration.yaml"; }
  std::filesystem::path picture_file(const std::string& camera, int frame) const {
    return images() / camera / fmt::format("{:03}.png", frame);
  }
  void write(const std::string& camera, int frame, const cv::Mat& picture) {
    std::filesystem::create_directories(images() / camera);
    capture::write_png(picture_file(camera, frame), picture);
  }
  Outcome import(const std::string& name) {
    return rotunda({"take", "import", name, "--images", images().string(), "--calibration", calibration().string()});
  }
  // Coarse, so that it is quick under a sanitizer.
  Outcome recon(const std::string& take, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"recon", take,          "--quality", "live",  "--cell",
                                       "30mm",  "--triangles", "2000",      "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return rotunda(arguments);
  }

  std::vector<capture::CameraModel> cameras_;
};

}  // namespace rotunda::tests
