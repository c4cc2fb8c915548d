#include "capture/calibration/colour_card.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/mcc.hpp>

#include "capture/picture.h"
#include "capture/srgb.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr int kColumns = 6, kRows = 4;
// The finder's model of the card: patches of 2.5 with 0.25 between and around.
constexpr float kPatch = 2.5F, kGap = 0.25F, kPitch = kPatch + kGap;
constexpr float kSampled = 0.5F;               // of a patch's side, its middle
constexpr int kDarkest = 8, kBrightest = 250;  // grey levels: beyond, noise or the end of the scale
constexpr int kFewestPixels = 9;

std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const auto ending = entry.path().extension().string();
    if (entry.is_regular_file() && (ending == ".png" || ending == ".jpg" || ending == ".jpeg"))
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The middle of a patch on the picture.
std::vector<cv::Point> patch_outline(const cv::Mat& picture_from_card, int patch) {
  const float x = kGap + kPatch / 2 + kPitch * static_cast<float>(patch % kColumns);
  const float y = kGap + kPatch / 2 + kPitch * static_cast<float>(patch / kColumns), half = kSampled * kPatch / 2;
  const std::vector<cv::Point2f> on_card = {
      {x - half, y - half}, {x + half, y - half}, {x + half, y + half}, {x - half, y + half}};
  std::vector<cv::Point2f> seen;
  cv::perspectiveTransform(on_card, seen, picture_from_card);
  return {seen.begin(), seen.end()};
}

std::optional<Eigen::Vector3d> mean_light(const cv::Mat& rgb, const std::vector<cv::Point>& outline) {
  const cv::Rect box = cv::boundingRect(outline) & cv::Rect({}, rgb.size());
  if (box.area() < kFewestPixels) return std::nullopt;
  std::vector<cv::Point> in_box;
  for (const auto& point : outline) in_box.push_back(point - box.tl());
  cv::Mat mask = cv::Mat::zeros(box.size(), CV_8UC1);
  cv::fillConvexPoly(mask, in_box, {255});
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      if (!mask.at<std::uint8_t>(y, x)) continue;
      const auto& pixel = rgb.at<cv::Vec3b>(box.y + y, box.x + x);
      if (*std::max_element(pixel.val, pixel.val + 3) > kBrightest) return std::nullopt;
      sum += linear_of(pixel);
      ++count;
    }
  if (count < kFewestPixels) return std::nullopt;
  const Eigen::Vector3d mean = sum / count;
  if (mean.maxCoeff() < linear_table()[kDarkest]) return std::nullopt;
  return mean;
}

}  // namespace

const std::array<Eigen::Vector3d, kCardPatches>& card_colours() {
  static const auto colours = [] {
    constexpr std::array<std::array<std::uint8_t, 3>, kCardPatches> kCodes = {{
        {115, 82, 68},   {194, 150, 130}, {98, 122, 157},  {87, 108, 67},   {133, 128, 177}, {103, 189, 170},
        {214, 126, 44},  {80, 91, 166},   {193, 90, 99},   {94, 60, 108},   {157, 188, 64},  {224, 163, 46},
        {56, 61, 150},   {70, 148, 73},   {175, 54, 60},   {231, 199, 31},  {187, 86, 149},  {8, 133, 161},
        {243, 243, 242}, {200, 200, 200}, {160, 160, 160}, {122, 122, 121}, {85, 85, 85},    {52, 52, 52},
    }};
    std::array<Eigen::Vector3d, kCardPatches> linear;
    for (std::size_t i = 0; i < kCardPatches; ++i)
      linear[i] = linear_of(cv::Vec3b(kCodes[i][0], kCodes[i][1], kCodes[i][2]));
    return linear;
  }();
  return colours;
}

std::optional<CardColours> find_card(const cv::Mat& rgb) {
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  const auto finder = cv::mcc::CCheckerDetector::create();
  if (!finder->process(bgr, cv::mcc::MCC24, 1)) return std::nullopt;
  const auto card = finder->getBestColorChecker();
  if (!card || card->getBox().size() != 4) return std::nullopt;
  constexpr float kWidth = kColumns * kPitch + kGap, kHeight = kRows * kPitch + kGap;
  const std::vector<cv::Point2f> corners = {{0, 0}, {kWidth, 0}, {kWidth, kHeight}, {0, kHeight}};
  const cv::Mat picture_from_card = cv::getPerspectiveTransform(corners, card->getBox());
  CardColours colours;
  for (std::size_t i = 0; i < kCardPatches; ++i)
    colours[i] = mean_light(rgb, patch_outline(picture_from_card, static_cast<int>(i)));
  return colours;
}

CardSamples card_samples(const fs::path& folder, std::span<const std::string> names) {
  if (!fs::is_directory(folder)) throw InvalidInput(folder.string() + " is not a folder");
  CardSamples result;
  result.cards.assign(names.size(), 0);
  std::map<std::string, std::size_t> moments;
  for (std::size_t camera = 0; camera < names.size(); ++camera)
    for (const auto& file : pictures_in(folder / names[camera])) {
      ++result.pictures;
      const auto moment = moments.emplace(file.stem().string(), moments.size()).first->second;
      try {
        const auto card = find_card(read_rgb(file));
        if (!card) continue;
        ++result.cards[camera];
        for (std::size_t patch = 0; patch < kCardPatches; ++patch)
          if ((*card)[patch]) result.samples.push_back({camera, moment * kCardPatches + patch, *(*card)[patch]});
      } catch (const CorruptData& error) {
        result.problems.emplace_back(error.what());
      }
    }
  for (std::size_t moment = 0; moment < moments.size(); ++moment)
    for (std::size_t patch = 0; patch < kCardPatches; ++patch)
      result.known.push_back({moment * kCardPatches + patch, card_colours()[patch]});
  return result;
}

}  // namespace rotunda::capture
