#include "capture/matte/despill.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/picture.h"
#include "capture/srgb.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr int kSide = 120;
const cv::Vec3f kSkin(190, 140, 110), kPaint(60, 100, 200);

struct Scene {
  cv::Mat own, picture;  // CV_8UC3: the performer's colour everywhere; mixed with paint outside of a disc
  Matte matte;
};

// As lens and photosite mix light, in its linear values.
cv::Vec3b mixture(const cv::Vec3f& performer, float alpha) {
  const auto linear = [](float level) { return linear_of_srgb(std::clamp(level, 0.0F, 255.0F) / 255.0); };
  cv::Vec3b mixed;
  for (int c = 0; c < 3; ++c) mixed[c] = srgb8_of(alpha * linear(performer[c]) + (1.0F - alpha) * linear(kPaint[c]));
  return mixed;
}

// A disc of skin, softly edged over three pixels as by lens and mosaic; `glow`: blue on its outermost four pixels.
Scene disc(const cv::Vec3f& colour, float glow) {
  Scene scene{cv::Mat(kSide, kSide, CV_8UC3), cv::Mat(kSide, kSide, CV_8UC3), {cv::Mat(kSide, kSide, CV_8UC1)}};
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const auto depth = static_cast<float>(40.0 - std::hypot(x - 60.2, y - 59.7));
      const float alpha = std::clamp(0.5F + depth / 3.0F, 0.0F, 1.0F);
      const float texture = 8.0F * std::sin(0.9F * static_cast<float>(x)) * std::sin(0.7F * static_cast<float>(y));
      const cv::Vec3f own = colour + cv::Vec3f::all(texture);
      const cv::Vec3f lit = own + cv::Vec3f(0.0F, 0.0F, depth < 4.0F ? glow : 0.0F);
      scene.own.at<cv::Vec3b>(y, x) = cv::Vec3b(own);
      scene.picture.at<cv::Vec3b>(y, x) = mixture(lit, alpha);
      scene.matte.alpha.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(255.0F * alpha);
    }
  cv::GaussianBlur(scene.matte.alpha, scene.matte.alpha, {}, 0.8);  // as the key's are
  return scene;
}

// Over the four pixels inside of the outline.
double rim_error(const cv::Mat& colours, const Scene& scene) {
  cv::Mat inner, difference;
  const cv::Mat inside = scene.matte.alpha >= 128;
  cv::erode(inside, inner, cv::getStructuringElement(cv::MORPH_ELLIPSE, {9, 9}));
  cv::absdiff(colours, scene.own, difference);
  const auto mean = cv::mean(difference, inside & ~inner);
  return (mean[0] + mean[1] + mean[2]) / 3.0;
}

}  // namespace

// 3 of 255: half of the texture's own swing, where the outermost pixels are half paint.
TEST(Despill, TakesTheBackdropOutOfTheRim) {
  const auto scene = disc(kSkin, 0.0F);
  EXPECT_GT(rim_error(scene.picture, scene), 7.0);
  EXPECT_LT(rim_error(despilled(scene.picture, scene.matte, Backdrop::blue), scene), 3.0);
}

// Half black cloth, half paint is far brighter than the mean of the two values.
TEST(Despill, TakesBrightBackdropOutOfDarkCloth) {
  const auto scene = disc({25, 24, 28}, 0.0F);
  const double before = rim_error(scene.picture, scene);
  EXPECT_LT(rim_error(despilled(scene.picture, scene.matte, Backdrop::blue), scene), 0.25 * before);
}

// As a camera of this format sends the scene.
Image mosaic_image(const cv::Mat& rgb, PixelFormat format) {
  std::vector<std::uint8_t> sites;
  const auto order = layout_of(format).order;
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const bool red_right = order == BayerOrder::gr || order == BayerOrder::bg;
      const bool red_below = order == BayerOrder::gb || order == BayerOrder::bg;
      const bool red_column = (x % 2 == 1) == red_right, red_row = (y % 2 == 1) == red_below;
      sites.push_back(rgb.at<cv::Vec3b>(y, x)[red_column != red_row ? 1 : red_row ? 0 : 2]);
    }
  return make_image(rgb.cols, rgb.rows, format, std::move(sites));
}

// Demosaicing takes the paint two pixels further in; taken out of the photosites first it does not.
TEST(Despill, OfAMosaicIsDoneBeforeDemosaicingInEveryOrder) {
  const auto scene = disc(kSkin, 0.0F);
  for (const auto format :
       {PixelFormat::bayer_rg8, PixelFormat::bayer_gr8, PixelFormat::bayer_gb8, PixelFormat::bayer_bg8}) {
    const auto image = mosaic_image(scene.picture, format);
    const double after = rim_error(despilled(to_rgb(image), scene.matte, Backdrop::blue), scene);
    const double before = rim_error(despilled(image, scene.matte, Backdrop::blue), scene);
    EXPECT_LT(before, 0.9 * after) << to_string(format);
    EXPECT_LT(before, 4.0) << to_string(format);
  }
}

TEST(Despill, OfAPictureIsTheSameAsOfItsImage) {
  const auto scene = disc(kSkin, 0.0F);
  const auto image = make_image(kSide, kSide, PixelFormat::rgb8, {scene.picture.datastart, scene.picture.dataend});
  EXPECT_EQ(cv::norm(despilled(image, scene.matte, Backdrop::blue),
                     despilled(scene.picture, scene.matte, Backdrop::blue), cv::NORM_INF),
            0.0);
}

TEST(Despill, TakesBlueLightOffSkin) {
  const cv::Vec3f pale(170, 165, 160);
  const auto scene = disc(pale, 40.0F);
  EXPECT_LT(rim_error(despilled(scene.picture, scene.matte, Backdrop::blue), scene), 5.0);
}

TEST(Despill, LeavesBlueClothBlue) {
  const auto scene = disc({70, 90, 150}, 0.0F);
  const cv::Mat found = despilled(scene.picture, scene.matte, Backdrop::blue);
  EXPECT_LT(rim_error(found, scene), 4.0);
}

TEST(Despill, LeavesTheMiddleAndTheFarBackdropAsTheyWere) {
  const auto scene = disc(kSkin, 0.0F);
  const cv::Mat found = despilled(scene.picture, scene.matte, Backdrop::blue);
  const cv::Rect middle(45, 45, 30, 30), corner(0, 0, 20, 20);
  EXPECT_EQ(cv::norm(found(middle), scene.picture(middle), cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(found(corner), scene.picture(corner), cv::NORM_INF), 0.0);
}

TEST(Despill, HasNothingToDoWithoutAPerformerAndRefusesAnotherSize) {
  const auto scene = disc(kSkin, 0.0F);
  const Matte nobody{cv::Mat::zeros(kSide, kSide, CV_8UC1)};
  EXPECT_EQ(cv::norm(despilled(scene.picture, nobody, Backdrop::blue), scene.picture, cv::NORM_INF), 0.0);
  EXPECT_THROW(despilled(scene.picture, {cv::Mat::zeros(4, 4, CV_8UC1)}, Backdrop::blue), InvalidInput);
}

}  // namespace rotunda::capture
