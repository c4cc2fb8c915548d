#include <gtest/gtest.h>

#include "capture/picture.h"
#include "simulator/people/synthetic_performance.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/pixel_encoding.h"
#include "simulator/studio/scene_renderer.h"
#include "simulator/studio/truth.h"

namespace rotunda::simulator {
namespace {

const Performance& walk() {
  static const auto performance = make_performance({.act = "walk", .coarseness = 1.4, .texels_per_edge = 2});
  return *performance;
}

std::vector<capture::CameraModel> odd_cameras() {
  auto cameras = camera_layout(
      {.cameras = 3, .width = 320, .height = 256, .aspect = 16.0 / 15.0, .skew_px = 3.0, .k1 = -0.12, .k2 = 0.02});
  cameras[1].distortion[2] = 0.001;  // p1
  return cameras;
}

// Person and cameras are made once; the GL context stays current for all tests.
SceneRenderer& studio() {
  static SceneRenderer renderer(walk(), odd_cameras());
  return renderer;
}

// Where the half-covered outline of a row lies, from the left; sub-pixel.
double left_edge(const cv::Mat& matte, int row) {
  for (int x = 1; x < matte.cols; ++x) {
    const double before = matte.at<std::uint8_t>(row, x - 1), here = matte.at<std::uint8_t>(row, x);
    if (here >= 127.5) return x - 1 + (127.5 - before) / (here - before);
  }
  return -1.0;
}

// The leftmost truth point in each picture row is the silhouette's edge there, for skewed and distorted lenses too.
TEST(SceneRenderer, SilhouettesAgreeWithTheProjectedSurface) {
  const auto body = walk().surfaces_at(0.2).front();
  for (std::size_t camera = 0; camera < studio().cameras().size(); ++camera) {
    const auto& model = studio().cameras()[camera];
    const auto matte = studio().picture(camera, 0.2, 5).matte;
    std::vector<double> leftmost(static_cast<std::size_t>(model.height), 1e9);
    for (const auto& t : body.triangles)  // edges, cut at every row
      for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector2d a = *capture::project(model, body.positions[t[i]].cast<double>());
        const Eigen::Vector2d b = *capture::project(model, body.positions[t[(i + 1) % 3]].cast<double>());
        for (int y = static_cast<int>(std::ceil(std::min(a.y(), b.y()))); y <= std::max(a.y(), b.y()); ++y) {
          const double x =
              std::abs(b.y() - a.y()) < 1e-9 ? a.x() : a.x() + (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y());
          leftmost[static_cast<std::size_t>(y)] = std::min(leftmost[static_cast<std::size_t>(y)], x);
        }
      }
    std::vector<double> error;
    for (int y = 0; y < model.height; ++y)
      if (leftmost[static_cast<std::size_t>(y)] < 1e9 && left_edge(matte, y) >= 0.0)
        error.push_back(left_edge(matte, y) - leftmost[static_cast<std::size_t>(y)]);
    ASSERT_GT(error.size(), 100U);
    std::sort(error.begin(), error.end());
    EXPECT_NEAR(error[error.size() / 2], 0.0, 0.1) << model.name;  // no offset of the pixel grid
    EXPECT_GT(error[error.size() / 20], -0.5) << model.name;       // 5 % of the rows graze an outline
    EXPECT_LT(error[error.size() - error.size() / 20 - 1], 0.5) << model.name;
  }
}

TEST(SceneRenderer, FramesAreDeterministicAndTheirNoiseDiffers) {
  const auto first = studio().picture(0, 0.0, 7).rgb, again = studio().picture(0, 0.0, 7).rgb;
  const auto other = studio().picture(0, 0.0, 8).rgb;
  EXPECT_EQ(cv::norm(first, again, cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(first, other, cv::NORM_INF), 0.0);
}

TEST(SceneRenderer, TheMatteIsWhereThePictureLeavesThePlate) {
  const auto picture = studio().picture(1, 0.1, 3);
  cv::Mat changed;
  cv::absdiff(picture.rgb, studio().clean_plate(1), changed);
  double far_out = 0, out = 0, far_in = 0, in = 0;
  for (int y = 0; y < changed.rows; ++y)
    for (int x = 0; x < changed.cols; ++x) {
      const auto& d = changed.at<cv::Vec3b>(y, x);
      const bool differs = d[0] > 25 || d[1] > 25;
      const auto cover = picture.matte.at<std::uint8_t>(y, x);
      if (cover == 0) ++out, far_out += differs;
      if (cover == 255) ++in, far_in += differs;
    }
  EXPECT_LT(far_out / out, 0.01);  // the darkest contact shadow, under the soles
  EXPECT_GT(far_in / in, 0.80);    // dark cloth and shaded hair come close to the plate's dark red
}

TEST(SceneRenderer, TheEmptyStudioIsBlue) {
  const auto mean = cv::mean(studio().clean_plate(0));
  EXPECT_GT(mean[2], 1.5 * mean[1]);
  EXPECT_GT(mean[1], mean[0]);
}

TEST(ActFrame, ShowsWhatTheTimeOfExposureSays) {
  const auto at = [](std::int64_t ms) { return capture::Timestamp(std::chrono::milliseconds(ms)); };
  EXPECT_EQ(act_frame_at(at(0), 26), 0);
  EXPECT_EQ(act_frame_at(at(40 * 26 * 1000 + 40 * 3), 26), 3);
  EXPECT_EQ(act_frame_at(at(40 * 5 + 19), 26), 5);  // a late trigger shows the nearest act frame
  EXPECT_EQ(act_frame_at(at(40 * 5 + 21), 26), 6);
  EXPECT_DOUBLE_EQ(act_seconds(act_frame_at(at(40 * 27), 26)), kActStep);
}

TEST(Truth, IsThePosedSurfaceOfTheExposuresActFrame) {
  const auto truth = truth_mesh(walk(), capture::Timestamp(std::chrono::milliseconds(40 * 29)));
  const auto expected = walk().surfaces_at(act_seconds(3)).front();
  ASSERT_EQ(truth.positions.size(), expected.positions.size());
  EXPECT_LT((truth.positions[1000] - expected.positions[1000]).norm(), 1e-6F);
}

TEST(Performance, AnotherSurfaceActOrTextureHasAnotherFingerprint) {
  auto description = describe_person("alex");
  description.coarseness = 1.4;
  description.texels_per_edge = 2;
  const Person alex = make_person(description);
  auto repainted = alex, reshaped = alex;
  repainted.texture.picture = alex.texture.picture.clone();
  repainted.texture.picture.at<cv::Vec3b>(5, 5) += cv::Vec3b(1, 0, 0);
  reshaped.bind.positions[100].x() += 0.001F;
  const auto print = [](Person person, const char* act) {
    const auto motion = motion_of(act, person.skeleton);
    return SyntheticPerformance(std::move(person), motion).fingerprint();
  };
  EXPECT_EQ(print(alex, "idle"), print(alex, "idle"));
  EXPECT_NE(print(alex, "idle"), print(alex, "a-pose"));
  EXPECT_NE(print(alex, "idle"), print(repainted, "idle"));
  EXPECT_NE(print(alex, "idle"), print(reshaped, "idle"));
}

}  // namespace
}  // namespace rotunda::simulator
