#include "capture/matte/chroma_key.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr int kSupersampling = 8;
const cv::Point2d kCentre(161.3, 118.6);
constexpr double kRadius = 50.4;

float to_srgb(float linear) {
  return 255.0F * (linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1.0F / 2.4F) - 0.055F);
}

struct Scene {
  cv::Vec3f cloth{0.30F, 0.12F, 0.10F};     // linear light
  cv::Vec3f backdrop{0.02F, 0.06F, 0.30F};  // blue paint
  double shadow_below = 0.0;                // how much of the light the floor under the disc loses
  double noise = 1.5;                       // grey levels, standard deviation
  double contact = 0.0;                     // of the light about the disc, the share that it keeps off next to it
};

double disc_coverage(int x, int y) {
  int inside = 0;
  for (int j = 0; j < kSupersampling; ++j)
    for (int i = 0; i < kSupersampling; ++i)
      inside += std::hypot(x + (i + 0.5) / kSupersampling - 0.5 - kCentre.x,
                           y + (j + 0.5) / kSupersampling - 0.5 - kCentre.y) < kRadius;
  return static_cast<double>(inside) / (kSupersampling * kSupersampling);
}

// A disc of cloth before an unevenly lit backdrop; the pixels mix in linear light, as a lens does.
cv::Mat picture_of(const Scene& scene, bool with_disc = true) {
  cv::Mat rgb(kHeight, kWidth, CV_8UC3);
  cv::RNG random(7);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const float light = 1.0F - 0.3F * static_cast<float>(x) / kWidth;
      const float shadow = y > 175 ? 1.0F - static_cast<float>(scene.shadow_below) : 1.0F;
      const double away = std::max(0.0, std::hypot(x - kCentre.x, y - kCentre.y) - kRadius);
      const auto open = static_cast<float>(1.0 - 0.95 * scene.contact * std::exp(-away / 4.0));
      // Light off paint fills a shadow: it takes less of blue than of the rest.
      const std::array<float, 3> shade{open * std::pow(open, 0.25F), open * std::pow(open, 0.125F), open};
      const float a = with_disc ? static_cast<float>(disc_coverage(x, y)) : 0.0F;
      for (int c = 0; c < 3; ++c) {
        const float value =
            a * scene.cloth[c] + (1.0F - a) * scene.backdrop[c] * light * shadow * shade[static_cast<std::size_t>(c)];
        rgb.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(to_srgb(value) + random.gaussian(scene.noise));
      }
    }
  return rgb;
}

double area_of(const Matte& matte) {
  return cv::sum(matte.alpha)[0] / 255.0;
}

// The sub-pixel outline: mean distance from the centre at which alpha crosses one half, along 360 rays.
double outline_radius(const Matte& matte) {
  double sum = 0.0;
  for (int degree = 0; degree < 360; ++degree) {
    const double angle = degree * CV_PI / 180.0;
    double before = 255.0;
    for (double r = kRadius - 8.0; r < kRadius + 8.0; r += 0.05) {
      cv::Mat sample;
      cv::getRectSubPix(
          matte.alpha, {1, 1},
          {static_cast<float>(kCentre.x + r * std::cos(angle)), static_cast<float>(kCentre.y + r * std::sin(angle))},
          sample, CV_32F);
      const double here = sample.at<float>(0, 0);
      if (before >= 127.5 && here < 127.5) {
        sum += r;
        break;
      }
      before = here;
    }
  }
  return sum / 360.0;
}

void expect_the_disc(const Matte& matte) {
  EXPECT_NEAR(outline_radius(matte), kRadius, 0.25);  // a quarter of a pixel of bias would cost 1.5 mm on a body
  const auto moments = cv::moments(matte.alpha);
  EXPECT_NEAR(moments.m10 / moments.m00, kCentre.x, 0.1);
  EXPECT_NEAR(moments.m01 / moments.m00, kCentre.y, 0.1);
}

}  // namespace

TEST(ChromaKey, FindsADiscOfClothWithoutBiasAndWithoutAPlate) {
  expect_the_disc(chroma_key(picture_of({})));
}

TEST(ChromaKey, FindsItWithACleanPlate) {
  expect_the_disc(chroma_key(picture_of({}), {}, picture_of({}, /*with_disc=*/false)));
}

TEST(ChromaKey, HoldsGreyAndDarkCloth) {
  expect_the_disc(chroma_key(picture_of({.cloth = {0.2F, 0.2F, 0.2F}})));
  expect_the_disc(chroma_key(picture_of({.cloth = {0.012F, 0.011F, 0.011F}})));
}

TEST(ChromaKey, LeavesShadowOnTheBackdropToTheBackdrop) {
  const auto matte = chroma_key(picture_of({.shadow_below = 0.5}), {}, picture_of({}, false));
  EXPECT_LT(cv::sum(matte.alpha.rowRange(185, kHeight))[0] / 255.0, 20.0);  // of 17600 pixels
}

// Under soles shadow deepens towards the outline: dark as the cloth above it, but bluer.
TEST(ChromaKey, FindsDarkClothAboveAShadowThatDeepensTowardsIt) {
  Scene scene{.cloth = {0.03F, 0.025F, 0.025F}};
  const cv::Mat lit = picture_of(scene, false);
  scene.contact = 1.0;
  expect_the_disc(chroma_key(picture_of(scene), {}, lit));
}

TEST(ChromaKey, KeepsAGapOfFourPixelsOpen) {
  const cv::Mat plate = picture_of({}, false);
  cv::Mat rgb = plate.clone();
  const cv::Scalar cloth(150, 97, 89);
  rgb(cv::Rect(100, 60, 30, 120)).setTo(cloth);
  rgb(cv::Rect(134, 60, 30, 120)).setTo(cloth);
  cv::GaussianBlur(rgb, rgb, {5, 5}, 0.6);  // the lens
  const auto matte = chroma_key(rgb, {}, plate);
  EXPECT_LT(cv::mean(matte.alpha(cv::Rect(131, 80, 2, 80)))[0], 110.0);
  EXPECT_GT(cv::mean(matte.alpha(cv::Rect(104, 64, 22, 112)))[0], 250.0);
}

// Behind a bent knee, between hand and hip: no backdrop farther off tells what it looks like there.
TEST(ChromaKey, KeepsASmallGapOpenThatThePerformerSurrounds) {
  const cv::Mat plate = picture_of({}, false);
  cv::Mat rgb = plate.clone(), gap;
  rgb(cv::Rect(100, 60, 80, 120)).setTo(cv::Scalar(150, 97, 89));
  const cv::Rect hole(138, 116, 4, 5);
  plate(hole).copyTo(rgb(hole));
  cv::GaussianBlur(rgb, rgb, {5, 5}, 0.6);
  for (const auto& background : {plate, cv::Mat()}) {
    const auto matte = chroma_key(rgb, {}, background);
    EXPECT_LT(cv::mean(matte.alpha(cv::Rect(139, 117, 2, 3)))[0], 120.0);
    EXPECT_GT(cv::mean(matte.alpha(cv::Rect(104, 64, 30, 112)))[0], 250.0);
  }
}

// A dark wall, in which the performer stands out by light alone.
// A fold of the cloth that the screen's light made nearly as blue as the screen.
cv::Mat with_blue_fold(cv::Mat rgb, const cv::Vec3f& linear) {
  cv::Mat fold(rgb.size(), CV_8UC1, cv::Scalar(0));
  cv::ellipse(fold, cv::Point(kCentre), {9, 14}, 0, 0, 360, cv::Scalar(255), cv::FILLED);
  rgb.setTo(cv::Scalar(to_srgb(linear[0]), to_srgb(linear[1]), to_srgb(linear[2])), fold);
  return rgb;
}

TEST(ChromaKey, TheFramesBeforeAndAfterHoldWhatOneFrameLoses) {
  const auto whole = picture_of({}), plate = picture_of({}, false);
  const auto fold = with_blue_fold(whole.clone(), {0.0253F, 0.055F, 0.255F});
  const auto sure = chroma_key(whole, {}, plate), alone = chroma_key(fold, {}, plate);
  ASSERT_LT(area_of(alone), area_of(sure) - 200.0) << "a fold that the key loses";
  const auto held = chroma_key(fold, {.backdrop = {}, .held = held_between(sure, sure)}, plate);
  EXPECT_NEAR(area_of(held), area_of(sure), 10.0);
  const auto gap = with_blue_fold(whole.clone(), {0.017F, 0.051F, 0.255F});  // the screen itself
  const auto open = chroma_key(gap, {.backdrop = {}, .held = held_between(sure, sure)}, plate);
  EXPECT_NEAR(area_of(open), area_of(chroma_key(gap, {}, plate)), 5.0);
  EXPECT_LT(area_of(open), area_of(sure) - 200.0);
}

TEST(ChromaKey, WhatIsThereInOneFrameOnlyStays) {
  const auto whole = picture_of({}), plate = picture_of({}, false);
  const Matte nobody{cv::Mat::zeros(whole.size(), CV_8UC1)};
  const auto held = chroma_key(whole, {.backdrop = {}, .held = held_between(nobody, nobody)}, plate);
  EXPECT_EQ(cv::countNonZero(held.alpha != chroma_key(whole, {}, plate).alpha), 0);
  EXPECT_TRUE(held_between({}, nobody).empty());
}

TEST(ChromaKey, TellsThePerformerPastTheScreensEdgeByTheDifference) {
  cv::Mat plate = picture_of({}, false), rgb = picture_of({});
  const cv::Mat half = picture_of({.backdrop = {0.008F, 0.009F, 0.012F}});
  half.colRange(150, kWidth).copyTo(rgb.colRange(150, kWidth));
  picture_of({.backdrop = {0.008F, 0.009F, 0.012F}}, false).colRange(150, kWidth).copyTo(plate.colRange(150, kWidth));
  const auto matte = chroma_key(rgb, {}, plate);
  EXPECT_NEAR(area_of(matte), CV_PI * kRadius * kRadius, 80.0);  // a quarter of a pixel all round
  EXPECT_NEAR(outline_radius(matte), kRadius, 0.4);
}

TEST(ChromaKey, TakesWhatIsOffTheStageForNobody) {
  cv::Mat stage(kHeight, kWidth, CV_8UC1, cv::Scalar(255)), rgb = picture_of({});
  stage.colRange(0, 60).setTo(0);
  rgb.colRange(0, 50).setTo(cv::Scalar(30, 30, 30));  // past the screen's edge
  expect_the_disc(chroma_key(rgb, {.backdrop = {}, .stage = stage}));
}

TEST(ChromaKey, TakesBlackBarsAlongThePictureForNobody) {
  cv::Mat rgb = picture_of({});
  rgb.colRange(kWidth - 20, kWidth).setTo(cv::Scalar(12, 14, 18));
  rgb.rowRange(0, 3).setTo(cv::Scalar(8, 8, 8));
  expect_the_disc(chroma_key(rgb));
}

TEST(ChromaKey, FillsAFoldTooDarkToTellInTheMiddleOfThePerformer) {
  const cv::Mat plate = picture_of({}, false);
  cv::Mat rgb = picture_of({});
  cv::circle(rgb, {155, 120}, 12, {3, 4, 22}, cv::FILLED);  // velvet in its own shade, blue light on it
  EXPECT_GT(cv::mean(chroma_key(rgb, {}, plate).alpha(cv::Rect(143, 108, 25, 25)))[0], 250.0);
  rgb = picture_of({});
  plate(cv::Rect(143, 108, 25, 25)).copyTo(rgb(cv::Rect(143, 108, 25, 25)));  // the backdrop, seen between limbs
  EXPECT_LT(cv::mean(chroma_key(rgb, {}, plate).alpha(cv::Rect(147, 112, 17, 17)))[0], 5.0);
}

// Under a coat's tail: the fold's dark reaches the hem. About as dark is what lies under a sole, outside of it.
TEST(ChromaKey, FillsAFoldThatOpensAtTheHemButNoContactShadow) {
  const cv::Scalar unlit(3, 4, 22);
  const cv::Mat plate = picture_of({}, false);
  cv::Mat rgb = picture_of({});
  cv::circle(rgb, {155, 120}, 12, unlit, cv::FILLED);
  rgb(cv::Rect(152, 120, 6, 46)).setTo(unlit);
  rgb(cv::Rect(152, 166, 6, 8)).setTo(cv::Scalar(4, 12, 60));  // the deepest shadow on paint, at the hem
  EXPECT_GT(cv::mean(chroma_key(rgb, {}, plate).alpha(cv::Rect(147, 112, 17, 17)))[0], 250.0);
  rgb = picture_of({});
  cv::Mat below(rgb.size(), CV_8UC1, cv::Scalar(0));
  cv::circle(below, {161, 169}, 8, cv::Scalar(255), cv::FILLED);
  cv::circle(below, {161, 119}, 50, cv::Scalar(0), cv::FILLED);
  rgb.setTo(unlit, below);
  EXPECT_LT(cv::mean(chroma_key(rgb, {}, plate).alpha(cv::Rect(158, 173, 7, 3)))[0], 60.0);
}

// Where a coat catches the screen's light its colour comes as near to the screen's as a half-covered pixel's.
TEST(ChromaKey, TakesAWidePatchNearTheScreensColourForCloth) {
  cv::Mat rgb = picture_of({});
  const cv::Rect patch(146, 104, 30, 30);
  rgb(patch).setTo(cv::Vec3b(52, 88, 138));
  const Matte matte = chroma_key(rgb, {}, picture_of({}, false));
  double least = 0.0;
  cv::minMaxLoc(matte.alpha(cv::Rect(patch.tl() + cv::Point(3, 3), patch.size() - cv::Size(6, 6))), &least);
  EXPECT_GT(least, 200.0);
}

// `share` (of the way there) of the plate as deep shadow or dark cloth in the screen's light dims it.
cv::Vec3b dimmed(const cv::Vec3b& plate, double share) {
  const std::array<double, 3> gain{-1.47, -1.0, -1.1};  // of ln(channel + 3), as the key forms ratios
  cv::Vec3b result;
  for (int c = 0; c < 3; ++c)
    result[c] =
        cv::saturate_cast<std::uint8_t>((plate[c] + 3.0) * std::exp(share * gain[static_cast<std::size_t>(c)]) - 3.0);
  return result;
}

// Beside the disc, a strip in such a colour that fades out over `penumbra` pixels.
cv::Mat with_dim_strip(const Scene& scene, const cv::Mat& plate, double penumbra) {
  cv::Mat rgb = picture_of(scene);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 205; x < kWidth; ++x) {
      const double past = std::hypot(std::max(0, x - 225), std::max(0, std::abs(y - 120) - 20));
      const double share = std::max(0.0, 1.0 - past / penumbra);
      if (std::hypot(x - kCentre.x, y - kCentre.y) > kRadius - 1.0)
        rgb.at<cv::Vec3b>(y, x) = dimmed(plate.at<cv::Vec3b>(y, x), share);
    }
  return rgb;
}

// The underside of a thigh before the screen, and a shadow on it.
TEST(ChromaKey, TakesDarkClothOfTheScreensHueByItsSharpEdgeAndLeavesSoftShadow) {
  const Scene scene{.backdrop = {0.05F, 0.09F, 0.35F}, .noise = 0.0};
  const cv::Mat plate = picture_of(scene, false);
  const cv::Rect strip(214, 106, 8, 28);
  EXPECT_GT(cv::mean(chroma_key(with_dim_strip(scene, plate, 1.0), {}, plate).alpha(strip))[0], 240.0);
  EXPECT_LT(cv::mean(chroma_key(with_dim_strip(scene, plate, 30.0), {}, plate).alpha(strip))[0], 15.0);
}

TEST(ChromaKey, TakesALampInThePictureForNobodyWithoutAPlate) {
  cv::Mat rgb = picture_of({});
  const cv::Rect lamp(200, 0, 60, 20);
  rgb(lamp).setTo(cv::Scalar::all(255));
  cv::GaussianBlur(rgb, rgb, {3, 3}, 0.7);
  const auto matte = chroma_key(rgb);
  EXPECT_EQ(cv::countNonZero(matte.alpha.rowRange(0, 40) > 20), 0);
  EXPECT_NEAR(area_of(matte), CV_PI * kRadius * kRadius, 80.0);
}

TEST(ChromaKey, FindsNobodyInAnEmptyStudio) {
  EXPECT_LT(area_of(chroma_key(picture_of({}, false))), 1.0);
}

TEST(ChromaKey, KeysGreenAsWell) {
  const Scene green{.backdrop = {0.03F, 0.30F, 0.05F}};
  expect_the_disc(chroma_key(picture_of(green), {.backdrop = Backdrop::green}));
  expect_the_disc(chroma_key(picture_of(green)));  // the picture shows which colour it is
  expect_the_disc(chroma_key(picture_of(green), {}, picture_of(green, false)));
}

TEST(ChromaKey, KeysByDifferenceWhereTheBackdropHasNoColour) {
  const Scene grey{.cloth = {0.5F, 0.2F, 0.1F}, .backdrop = {0.2F, 0.2F, 0.2F}};
  const auto matte = chroma_key(picture_of(grey), {}, picture_of(grey, false));
  EXPECT_NEAR(area_of(matte), CV_PI * kRadius * kRadius, 0.03 * CV_PI * kRadius * kRadius);
}

TEST(ChromaKey, IsEmptyWhereNothingTellsThePerformerFromTheBackdrop) {
  const Scene grey{.backdrop = {0.2F, 0.2F, 0.2F}};
  EXPECT_EQ(area_of(chroma_key(picture_of(grey))), 0.0);
}

TEST(ChromaKey, RefusesABackgroundOfAnotherSize) {
  EXPECT_THROW(chroma_key(picture_of({}), {}, cv::Mat(10, 10, CV_8UC3)), InvalidInput);
  EXPECT_THROW(chroma_key(picture_of({}), {.method = KeyMethod::difference}), InvalidInput);
}

}  // namespace rotunda::capture
