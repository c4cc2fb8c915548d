// rotunda calibrate --live as a whole: somebody walks with a board before a running rig, until every camera has enough;
// later somebody leans against a camera. The walk's pictures are rendered, imported as a take and replayed by the
// daemon's cameras.
#include <fmt/format.h>

#include <csignal>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <span>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "simulator/people/board_prop.h"
#include "tests/integration/house_test.h"
#include "tests/support/board_scene.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

// To each camera in turn the board is shown at the ninths of its picture, nearer and farther, facing between the
// cameras and tilted; last it lies on the floor.
std::vector<Eigen::Isometry3d> walk_before(const std::vector<capture::CameraModel>& rig) {
  Eigen::Vector3d eyes = Eigen::Vector3d::Zero();
  for (const auto& camera : rig) eyes += camera.centre() / static_cast<double>(rig.size());
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 12 * static_cast<int>(rig.size()); ++i) {
    const auto& camera = rig[static_cast<std::size_t>(i) % rig.size()];
    const int place = i / static_cast<int>(rig.size());
    const Eigen::Vector2d pixel(0.5 * camera.width * (1.0 + 0.66 * (place % 3 - 1)),
                                0.5 * camera.height * (1.0 + 0.62 * (place / 3 % 3 - 1)));
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = camera.centre() + (2.4 + 0.3 * (i % 4)) * *capture::ray_through(camera, pixel);
    const Eigen::Vector3d out = (eyes - pose.translation()).normalized(),
                          right = Eigen::Vector3d::UnitZ().cross(out).normalized();
    pose.linear() << right, out.cross(right), out;
    pose.rotate(Eigen::AngleAxisd(0.4 * std::sin(1.7 * i), Eigen::Vector3d(std::cos(i), std::sin(i), 0.0)));
    poses.push_back(pose);
  }
  poses.push_back(Eigen::Isometry3d::Identity());
  return poses;
}

std::vector<double> distances_between(const std::vector<capture::CameraModel>& cameras) {
  std::vector<double> distances;
  for (std::size_t a = 0; a < cameras.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) distances.push_back((cameras[a].centre() - cameras[b].centre()).norm());
  return distances;
}

class WalkWithABoard : public HouseTest {
 protected:
  WalkWithABoard() {
    for (auto& camera : board_rig(9, 360, 288, 375.0))
      if (rig_.size() < 3) rig_.push_back(camera);
    simulator::write_board(board_, {.columns = 6, .rows = 4, .square = 0.18, .marker = 0.144});
    capture::write_calibration(truth_, rig_);
  }

  std::unique_ptr<ScopedProgram> start_daemon_that_replays(std::span<const Eigen::Isometry3d> walk) {
    const capture::BoardPrint print(capture::read_boards(board_).front());
    for (const auto& camera : rig_) {
      fs::create_directories(images_ / camera.name);
      for (std::size_t i = 0; i < walk.size(); ++i)
        capture::write_png(images_ / camera.name / fmt::format("{:03}.png", i),
                           board_picture(camera, print, walk[i], {.noise = 1.0}));
    }
    const auto imported =
        rotunda({"take", "import", "walk", "--images", images_.string(), "--calibration", truth_.string()});
    EXPECT_EQ(imported.exit_code, 0) << imported.err;
    const auto rig = folder() / "rig.yaml";
    std::ofstream text(rig);
    text << "name: replayed\ntrigger: { mode: software, rate_hz: 8 }\nstorage: { reserve_mb: 1 }\ncameras:\n";
    for (const auto& camera : rig_)
      text << fmt::format("  - {{ name: {}, source: replay, address: {} }}\n", camera.name,
                          (takes() / "walk").string());
    text.close();
    auto daemon = start("rotundad", {"--rig", rig.string(), "--takes", takes().string(), "--socket", socket().string(),
                                     "--no-surfaces"});
    EXPECT_TRUE(daemon->wait_for(" ready: ")) << daemon->err();
    return daemon;
  }

  std::vector<std::string> live(const fs::path& out, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"calibrate", "--live", "--board", board_.string(), "-o", out.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  std::vector<capture::CameraModel> rig_;
  const fs::path images_ = folder() / "images", board_ = folder() / "board.yaml", truth_ = folder() / "truth.yaml";
};

TEST_F(WalkWithABoard, EndsByItselfWithTheRigAndALaterKnockIsTold) {
  const auto daemon = start_daemon_that_replays(walk_before(rig_));
  const auto kept = folder() / "kept", found = folder() / "found.yaml", report = folder() / "report.html";
  const auto walked = rotunda(live(found, {"--images", kept.string(), "--report", report.string(), "--json"}));
  ASSERT_EQ(walked.exit_code, 0) << walked.out << walked.err;
  EXPECT_THAT(walked.err, AllOf(HasSubstr("cam00 needs 1"), HasSubstr("3 of 3 cameras have enough")));
  EXPECT_NE(json::parse(walked.out)["verdict"], "rejected") << walked.out;
  const auto truth = distances_between(rig_), seen = distances_between(capture::read_calibration(found));
  ASSERT_EQ(seen.size(), truth.size());
  // At 3 m a pixel is 8 mm: a corner's tenth of one, and some fifty boards.
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_NEAR(seen[i], truth[i], 0.006);
  EXPECT_GT(fs::file_size(report), 10000U);
  EXPECT_GE(contents_of(kept / "cam02").size(), 15U) << "the pictures are kept";
  EXPECT_THAT(rotunda({"take", "list"}).out, testing::Not(HasSubstr("boards for calibration")));
  EXPECT_EQ(rotunda(live(found)).exit_code, 3) << "nothing is overwritten";

  const std::vector<std::string> check{"calibrate",     "--check",       "--images",     kept.string(), "--board",
                                       board_.string(), "--calibration", found.string(), "--json"};
  const auto before = rotunda(check);
  EXPECT_EQ(before.exit_code, 0) << before.out << before.err;
  const cv::Matx23d leant(1, 0, 5, 0, 1, 0);  // pixels to the right
  for (const auto& picture : fs::directory_iterator(kept / "cam01")) {
    cv::Mat moved;
    cv::warpAffine(capture::read_rgb(picture.path()), moved, leant, cv::Size(360, 288), cv::INTER_LINEAR,
                   cv::BORDER_REPLICATE);
    capture::write_png(picture.path(), moved);
  }
  const auto after = rotunda(check);
  EXPECT_EQ(after.exit_code, 1) << after.out << after.err;
  for (const auto& camera : json::parse(after.out)) {
    EXPECT_EQ(camera["moved"].get<bool>(), camera["camera"] == "cam01") << camera.dump();
    if (camera["camera"] == "cam01") {
      EXPECT_NEAR(camera["shift_px"].get<double>(), 5.0, 0.5);
    }
  }
}

TEST_F(WalkWithABoard, EndedTooEarlySaysSoAndWritesNothing) {
  const auto walk_begun = walk_before(rig_);
  const auto daemon = start_daemon_that_replays(std::span(walk_begun).first(4));
  const auto found = folder() / "found.yaml";
  auto arguments = live(found);
  arguments.insert(arguments.begin(), {"--takes", takes().string(), "--daemon", socket().string()});
  const auto walk = start("rotunda", arguments);
  ASSERT_TRUE(walk->wait_for("3 moments kept")) << walk->err();
  walk->send(SIGINT);
  EXPECT_EQ(walk->wait(), 3) << walk->out() << walk->err();
  EXPECT_THAT(walk->err(), HasSubstr("ended before every camera had enough"));
  EXPECT_FALSE(fs::exists(found));
}

}  // namespace
}  // namespace rotunda::tests
