#include "capture/matte/learnt_plate.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr int kClear = 6;            // pixels from the rough outline: beyond them no lens or demosaicing mixes colours
constexpr float kDeepShade = -0.5F;  // of ln of the backdrop's channel: darker is not learnt from
constexpr float kOneLight = 0.06F;   // of it: three deviations of noise in mid-tones
constexpr int kOverexposed = 250;    // grey levels: what the sensor or its curve cannot tell from white
constexpr double kLampShare = 0.9;   // of the pictures
constexpr int kRounds = 2;           // the second knows the paint where the smooth surface does not bend as it does
constexpr double kUnshadedRank = 0.75;
constexpr std::size_t kFewestValues = 3;  // of a pixel

// One picture as it tells of the backdrop.
struct Witness {
  cv::Mat logs;   // CV_32FC3, in the light of the reference
  cv::Mat clear;  // CV_8UC1, 255 where it shows the backdrop
};

cv::Mat clear_of_performer(const cv::Mat& logs, const cv::Mat& surface, Backdrop backdrop) {
  const KeyChannels channels = key_channels(surface, backdrop);
  cv::Mat covered(logs.size(), CV_8UC1), reach, shaded(logs.size(), CV_8UC1);
  for (int y = 0; y < logs.rows; ++y)
    for (int x = 0; x < logs.cols; ++x) {
      const cv::Vec3f gain = logs.at<cv::Vec3f>(y, x) - surface.at<cv::Vec3f>(y, x);
      covered.at<std::uint8_t>(y, x) = key_lead(gain, channels) > 0.0F ? 255 : 0;
      shaded.at<std::uint8_t>(y, x) = gain[channels.own] < kDeepShade ? 255 : 0;
    }
  cv::medianBlur(covered, covered, 3);  // single pixels are noise
  cv::dilate(covered, reach, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kClear + 1, 2 * kClear + 1}));
  return ~(reach | shaded);
}

// The pictures that show the backdrop. `reference`: a smooth surface in whose light they are brought.
std::vector<Witness> witnesses(std::span<const cv::Mat> pictures, Backdrop backdrop, cv::Mat& reference) {
  std::vector<Witness> found;
  reference = fit_plate(pictures[pictures.size() / 2], backdrop);
  for (const auto& picture : pictures) {
    const cv::Mat surface = fit_plate(picture, backdrop);
    if (surface.empty()) continue;
    if (reference.empty()) reference = surface;
    cv::Mat soft;
    cv::GaussianBlur(picture, soft, {3, 3}, 0.5);
    const cv::Mat clear = clear_of_performer(log_picture(soft), surface, backdrop);
    const cv::Mat logs = log_picture(picture);
    found.push_back({logs - light_change(logs, reference, backdrop), clear});
  }
  return found;
}

// Mean of a pixel's values without those in shadow: shadow only darkens, so the brighter ones that agree are taken.
// False if there are too few.
bool unshaded_mean(std::vector<cv::Vec3f>& values, int own, cv::Vec3f& mean) {
  if (values.size() < kFewestValues) return false;
  const auto rank =
      values.begin() + static_cast<std::ptrdiff_t>(kUnshadedRank * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), rank, values.end(),
                   [own](const cv::Vec3f& a, const cv::Vec3f& b) { return a[own] < b[own]; });
  const float light = (*rank)[own];
  cv::Vec3f sum(0.0F, 0.0F, 0.0F);
  int count = 0;
  for (const auto& value : values)
    if (std::abs(value[own] - light) <= kOneLight) sum += value, ++count;
  mean = sum / static_cast<float>(count);
  return true;
}

// What was learnt, less the reference, where it was: CV_32FC3; `learnt` CV_8UC1.
cv::Mat learnt_rest(const std::vector<Witness>& found, const cv::Mat& reference, int own, cv::Mat& learnt) {
  cv::Mat rest(reference.size(), CV_32FC3, cv::Scalar::all(0.0));
  learnt.create(reference.size(), CV_8UC1);
  std::vector<cv::Vec3f> values;
  for (int y = 0; y < rest.rows; ++y)
    for (int x = 0; x < rest.cols; ++x) {
      values.clear();
      for (const auto& witness : found)
        if (witness.clear.at<std::uint8_t>(y, x)) values.push_back(witness.logs.at<cv::Vec3f>(y, x));
      cv::Vec3f mean;
      const bool known = unshaded_mean(values, own, mean);
      learnt.at<std::uint8_t>(y, x) = known ? 255 : 0;
      if (known) rest.at<cv::Vec3f>(y, x) = mean - reference.at<cv::Vec3f>(y, x);
    }
  return rest;
}

// Lamps that look into the camera are white whoever moves before them; with what shines about them.
cv::Mat lamps_in(std::span<const cv::Mat> pictures) {
  cv::Mat often(pictures[0].size(), CV_16UC1, cv::Scalar(0)), white, lamps;
  for (const auto& picture : pictures) {
    cv::inRange(picture, cv::Scalar::all(kOverexposed), cv::Scalar::all(255), white);
    cv::add(often, 1, often, white);
  }
  cv::compare(often, kLampShare * static_cast<double>(pictures.size()), lamps, cv::CMP_GE);
  cv::dilate(lamps, lamps, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kClear + 1, 2 * kClear + 1}));
  return lamps;
}

// They are left in the plate as they are: CV_32FC3 logarithms.
void put_lamps(cv::Mat& plate, const std::vector<Witness>& found, const cv::Mat& lamps, int own) {
  std::vector<cv::Vec3f> values;
  for (int y = 0; y < plate.rows; ++y)
    for (int x = 0; x < plate.cols; ++x) {
      if (!lamps.at<std::uint8_t>(y, x)) continue;
      values.clear();
      for (const auto& witness : found) values.push_back(witness.logs.at<cv::Vec3f>(y, x));
      unshaded_mean(values, own, plate.at<cv::Vec3f>(y, x));
    }
}

// Each unknown pixel gets the mean of the known ones about it, in a window no larger than it takes.
void fill_unknown(cv::Mat rest, const cv::Mat& known) {
  cv::Mat share, filled = known.clone();
  const cv::Mat first = rest.clone();
  for (int window = 9; cv::countNonZero(filled == 0) > 0 && window < 2 * std::max(rest.rows, rest.cols);
       window = 2 * window + 1) {
    cv::Mat sums;
    cv::boxFilter(first, sums, CV_32F, {window, window}, {-1, -1}, true, cv::BORDER_CONSTANT);
    known.convertTo(share, CV_32F, 1.0 / 255.0);
    cv::boxFilter(share, share, CV_32F, {window, window}, {-1, -1}, true, cv::BORDER_CONSTANT);
    for (int y = 0; y < rest.rows; ++y)
      for (int x = 0; x < rest.cols; ++x) {
        if (filled.at<std::uint8_t>(y, x) || share.at<float>(y, x) * static_cast<float>(window * window) < 0.5F)
          continue;
        rest.at<cv::Vec3f>(y, x) = sums.at<cv::Vec3f>(y, x) / share.at<float>(y, x);
        filled.at<std::uint8_t>(y, x) = 255;
      }
  }
}

}  // namespace

LearntPlate learn_plate(std::span<const cv::Mat> pictures, Backdrop backdrop) {
  for (const auto& picture : pictures)
    if (picture.type() != CV_8UC3 || picture.size() != pictures[0].size())
      throw InvalidInput("a plate is learnt from pictures of one camera, 8-bit red, green, blue, of one size");
  if (pictures.size() < kFewestPlatePictures) return {};
  cv::Mat reference, learnt;
  auto found = witnesses(pictures, backdrop, reference);
  if (found.size() < kFewestPlatePictures) return {};
  const int own = backdrop == Backdrop::blue ? 2 : 1;
  cv::Mat plate;
  for (int round = 0; round < kRounds; ++round) {
    if (round > 0)
      for (auto& witness : found) witness.clear = clear_of_performer(witness.logs, plate, backdrop);
    const cv::Mat rest = learnt_rest(found, reference, own, learnt);
    fill_unknown(rest, learnt);
    plate = reference + rest;
  }
  put_lamps(plate, found, lamps_in(pictures), own);
  return {picture_of_log(plate), static_cast<double>(cv::countNonZero(learnt)) / static_cast<double>(learnt.total())};
}

}  // namespace rotunda::capture
