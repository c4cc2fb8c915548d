#include "capture/calibration/colour_card.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "capture/picture.h"
#include "capture/srgb.h"
#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

// A card as somebody holds it: patches on black, a little turned, before a grey wall, through a camera's response.
cv::Mat picture_of_card(const Eigen::Matrix3d& response, double angle) {
  cv::Mat card(450, 670, CV_8UC3, cv::Scalar(20, 20, 20));
  for (int i = 0; i < 24; ++i) {
    const Eigen::Vector3d light = response * (0.8 * card_colours()[static_cast<std::size_t>(i)]);
    card(cv::Rect(10 + 110 * (i % 6), 10 + 110 * (i / 6), 100, 100))
        .setTo(cv::Scalar(srgb8_of(light[0]), srgb8_of(light[1]), srgb8_of(light[2])));
  }
  cv::Mat turn = cv::getRotationMatrix2D({335, 225}, angle, 0.7), picture(600, 800, CV_8UC3);
  turn.at<double>(0, 2) += 65;
  turn.at<double>(1, 2) += 75;
  cv::warpAffine(card, picture, turn, picture.size(), cv::INTER_AREA, cv::BORDER_CONSTANT, {110, 112, 115});
  return picture;
}

Eigen::Matrix3d response(int i) {
  Eigen::Matrix3d matrix = Eigen::Vector3d(1.0 + 0.08 * i, 0.95, 1.0 - 0.08 * i).asDiagonal();
  matrix(0, 1) = 0.02 * i;
  return matrix;
}

TEST(ColourCard, IsFoundAndItsPatchesMeasured) {
  const auto card = find_card(picture_of_card(Eigen::Matrix3d::Identity(), 7.0));
  ASSERT_TRUE(card);
  for (std::size_t i = 0; i < kCardPatches; ++i) {
    ASSERT_TRUE((*card)[i]) << i;
    EXPECT_LT(((*card)[i].value() - 0.8 * card_colours()[i]).cwiseAbs().maxCoeff(), 0.01) << i;
  }
  EXPECT_FALSE(find_card(cv::Mat(300, 400, CV_8UC3, cv::Scalar(90, 90, 90))));
}

TEST(ColourCard, MakesCamerasAgreeAndTrue) {
  const test::TemporaryFolder folder;
  const std::vector<std::string> names = {"left", "right", "blind"};
  for (int i = 0; i < 2; ++i) {
    std::filesystem::create_directories(folder.path() / names[static_cast<std::size_t>(i)]);
    write_png(folder.path() / names[static_cast<std::size_t>(i)] / "card0.png",
              picture_of_card(response(i), 5.0 - 12.0 * i));
  }
  const auto seen = card_samples(folder.path(), names);
  EXPECT_THAT(seen.cards, testing::ElementsAre(1, 1, 0));
  const auto match = match_colours(names, seen.samples, seen.known);
  EXPECT_GT(match.before, 3.0);
  EXPECT_LT(match.after, 1.0);
  EXPECT_LT(match.known_error.value(), 1.5);
  EXPECT_THAT(match.advice, testing::ElementsAre(testing::HasSubstr("blind")));
  EXPECT_THROW(card_samples(folder.path() / "none", names), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
