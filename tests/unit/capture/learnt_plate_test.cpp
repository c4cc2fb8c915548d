#include "capture/matte/learnt_plate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "capture/matte/chroma_key.h"
#include "capture/matte/live_key.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

const cv::Size kSize(200, 150);
constexpr int kPictures = 12;
const cv::Rect kNeverUncovered(90, 60, 14, 20);

// Unevenly lit paint with a board's edge down the middle, which no smooth surface has.
cv::Vec3d paint_at(int x, const cv::Vec3d& paint) {
  const double board = x < kSize.width / 2 ? 1.0 : 0.9;
  return board * (1.0 - 0.35 * x / kSize.width) * paint;
}

const cv::Vec3d kBlue(40, 80, 180), kGreen(50, 170, 70), kCloth(190, 140, 120);

// A disc of cloth that walks across, its shadow below it; a part of it always stays over the middle.
cv::Mat picture_of(const cv::Vec3d& paint, double walked, double light, bool anybody) {
  cv::Mat rgb(kSize, CV_8UC3);
  cv::RNG random(static_cast<std::uint64_t>(1 + 1000 * walked));
  const cv::Point2d centre(20 + walked * 160, 60);
  for (int y = 0; y < kSize.height; ++y)
    for (int x = 0; x < kSize.width; ++x) {
      cv::Vec3d colour = paint_at(x, paint);
      if (anybody && y > 110 && std::abs(x - centre.x) < 30) colour = colour.mul(cv::Vec3d(0.62, 0.68, 0.72));
      if (anybody && (std::hypot(x - centre.x, y - centre.y) < 18 || kNeverUncovered.contains({x, y}))) colour = kCloth;
      for (int c = 0; c < 3; ++c)
        rgb.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(light * colour[c] + random.gaussian(1.5));
    }
  return rgb;
}

std::vector<cv::Mat> take_of(const cv::Vec3d& paint, double drift) {
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < kPictures; ++i) {
    const double share = (i + 0.5) / kPictures;
    pictures.push_back(picture_of(paint, share, 1.0 + drift * (share - 0.5), true));
  }
  return pictures;
}

// Mean difference of the plates' three channels, grey levels, where `mask` says.
double apart(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  return cv::norm(a, b, cv::NORM_L1, mask) / (3.0 * cv::countNonZero(mask));
}

cv::Mat around_hidden(int value) {
  cv::Mat mask(kSize, CV_8UC1, cv::Scalar(255 - value));
  const int reach = 8;
  mask(cv::Rect(kNeverUncovered.x - reach, kNeverUncovered.y - reach, kNeverUncovered.width + 2 * reach,
                kNeverUncovered.height + 2 * reach))
      .setTo(value);
  return mask;
}

}  // namespace

TEST(LearntPlate, IsTheEmptyStudioWithItsEdgesThoughSomebodyWalksThroughAllPictures) {
  for (const auto& [paint, backdrop] : {std::pair(kBlue, Backdrop::blue), std::pair(kGreen, Backdrop::green)}) {
    const auto learnt = learn_plate(take_of(paint, 0.0), backdrop);
    const cv::Mat truth = picture_of(paint, 0.0, 1.0, false);
    // 1.2 levels are the truth picture's own noise; shadow, were it learnt, would be 40.
    EXPECT_LT(apart(learnt.picture, truth, around_hidden(0)), 1.9);
    EXPECT_LT(apart(learnt.picture, truth, around_hidden(255)), 5.0);  // filled
    EXPECT_GT(learnt.uncovered, 0.9);
    EXPECT_LT(learnt.uncovered, 1.0);
  }
}

TEST(LearntPlate, IsInTheLightOfTheTakesMiddleWhereLampsDrift) {
  const auto learnt = learn_plate(take_of(kBlue, 0.12), Backdrop::blue);
  EXPECT_LT(apart(learnt.picture, picture_of(kBlue, 0.0, 1.0, false), around_hidden(0)), 2.5);
}

// Both keys follow lamps that lose a tenth and a camera whose red gains as much.
TEST(LearntPlate, KeysAsAGivenPlateDoesUnderLightThatDrifted) {
  const auto learnt = learn_plate(take_of(kBlue, 0.1), Backdrop::blue);
  cv::Mat drifted = picture_of(kBlue, 0.8, 0.9, true), truth(kSize, CV_8UC1, cv::Scalar(0));
  cv::multiply(drifted, cv::Scalar(1.1, 1.0, 1.0), drifted);
  for (int y = 0; y < kSize.height; ++y)
    for (int x = 0; x < kSize.width; ++x)
      if (std::hypot(x - 148, y - 60) < 18 || kNeverUncovered.contains({x, y})) truth.at<std::uint8_t>(y, x) = 255;
  const auto overlap = [&](const cv::Mat& alpha) {
    const cv::Mat found = alpha > 127;
    return static_cast<double>(cv::countNonZero(found & truth)) / cv::countNonZero(found | truth);
  };
  EXPECT_GT(overlap(chroma_key(drifted, {}, learnt.picture).alpha), 0.95);
  const auto image = make_image(kSize.width, kSize.height, PixelFormat::rgb8, {drifted.datastart, drifted.dataend});
  EXPECT_GT(overlap(LiveKey(learnt.picture, PixelFormat::rgb8)(image).alpha), 0.92);
}

TEST(LearntPlate, KeepsALampThatLooksIntoTheCamera) {
  auto take = take_of(kBlue, 0.0);
  const cv::Rect lamp(60, 0, 40, 12);
  for (auto& picture : take) picture(lamp).setTo(cv::Scalar::all(255));
  const auto learnt = learn_plate(take, Backdrop::blue);
  EXPECT_GT(cv::mean(learnt.picture(lamp))[0], 252.0);
  EXPECT_EQ(cv::countNonZero(chroma_key(take.front(), {}, learnt.picture).alpha(lamp) > 127), 0);
}

TEST(LearntPlate, IsNoneWhereThereIsTooLittleToLearnFrom) {
  const auto take = take_of(kBlue, 0.0);
  EXPECT_TRUE(learn_plate(std::span(take).first(3), Backdrop::blue).picture.empty());
  EXPECT_TRUE(learn_plate(take, Backdrop::green).picture.empty());
  EXPECT_TRUE(learn_plate({}, Backdrop::blue).picture.empty());
  auto mixed = take;
  mixed.back() = mixed.back()(cv::Rect(0, 0, 50, 50)).clone();
  EXPECT_THROW(learn_plate(mixed, Backdrop::blue), InvalidInput);
}

}  // namespace rotunda::capture
