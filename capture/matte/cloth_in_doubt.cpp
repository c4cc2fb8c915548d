#include "capture/matte/cloth_in_doubt.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "capture/matte/mask_pieces.h"

namespace rotunda::capture {
namespace {

constexpr double kFoldBorder = 0.75;  // of a fold's border, the share that is performer
constexpr int kMixtureReach = 2;      // pixels about a gap, however narrow, that lens, demosaicing and blur mix with it
constexpr int kEdgeReach = 4;         // pixels over which lens, demosaicing and blur spread an outline
// Dark cloth that catches the screen's light comes near to deep shadow in colour: pixels between these, pieces whose
// mean leads by more than shadow does (-0.2 in the development studies, in nearly all less than -0.22).
constexpr double kLeastLead = -0.4, kClothLead = -0.2;
constexpr double kDark = -0.6;  // ln of the backdrop's own channel: lighter shadow than that is told by its colour
// ln of the backdrop's own channel over kEdgeReach: shadows at the soles of the development studies get to 0.49 in
// nearly all and 0.56 at most.
constexpr float kSharpStep = 0.55F;
constexpr int kSmallestPatch = 20000;  // a picture's area over this: what is smaller has too short a border to tell

float median_of(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Of each piece (`labels`, 0: none) whether `performer` makes up kFoldBorder of its border.
std::vector<bool> bordered_by(const cv::Mat& performer, const cv::Mat& labels, std::size_t count) {
  std::vector<int> all(count, 0), by_performer(count, 0);
  for (int y = 1; y + 1 < labels.rows; ++y)
    for (int x = 1; x + 1 < labels.cols; ++x) {
      const auto piece = static_cast<std::size_t>(labels.at<int>(y, x));
      if (piece == 0) continue;
      for (const cv::Point beside :
           {cv::Point(x - 1, y), cv::Point(x + 1, y), cv::Point(x, y - 1), cv::Point(x, y + 1)}) {
        if (labels.at<int>(beside) != 0) continue;
        ++all[piece];
        if (performer.at<std::uint8_t>(beside) != 0) ++by_performer[piece];
      }
    }
  std::vector<bool> is_bordered(count, false);
  for (std::size_t i = 1; i < count; ++i) is_bordered[i] = all[i] > 0 && by_performer[i] >= kFoldBorder * all[i];
  return is_bordered;
}

// Of each piece, the mean lead; kLeastLead where it is too small to tell.
std::vector<double> leads_of(const KeyedPixels& inside, const cv::Mat& labels, std::size_t count) {
  const int smallest = std::max(4, static_cast<int>(labels.total()) / kSmallestPatch);
  std::vector<double> sums(count, 0.0);
  std::vector<int> pixels(count, 0);
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x) {
      const auto piece = static_cast<std::size_t>(labels.at<int>(y, x));
      sums[piece] += inside.lead.at<float>(y, x), ++pixels[piece];
    }
  for (std::size_t i = 0; i < count; ++i) sums[i] = pixels[i] < smallest ? kLeastLead : sums[i] / pixels[i];
  return sums;
}

// Of each piece, by how much the backdrop beside it is brighter, in the median over its border; 0 where it does not
// touch the performer.
std::vector<float> steps_outward(const KeyedPixels& inside, const cv::Mat& labels, std::size_t count) {
  std::vector<std::vector<float>> steps(count);
  std::vector<bool> touches(count, false);
  for (int y = kEdgeReach; y + kEdgeReach < labels.rows; ++y)
    for (int x = kEdgeReach; x + kEdgeReach < labels.cols; ++x) {
      const int piece = labels.at<int>(y, x);
      if (piece == 0) continue;
      for (const cv::Point way : {cv::Point(-1, 0), cv::Point(1, 0), cv::Point(0, -1), cv::Point(0, 1)}) {
        const cv::Point here(x, y), beside = here + way, off = here + kEdgeReach * way;
        if (inside.all.at<std::uint8_t>(beside) != 0) touches[static_cast<std::size_t>(piece)] = true;
        if (labels.at<int>(beside) != 0 || inside.all.at<std::uint8_t>(beside) != 0) continue;
        steps[static_cast<std::size_t>(piece)].push_back(inside.brightness.at<float>(off) -
                                                         inside.brightness.at<float>(here));
      }
    }
  std::vector<float> medians(count, 0.0F);
  for (std::size_t i = 1; i < count; ++i)
    if (touches[i] && !steps[i].empty()) medians[i] = median_of(steps[i]);
  return medians;
}

}  // namespace

void fill_open_folds(KeyedPixels& inside) {
  cv::Mat dark, labels;
  cv::morphologyEx(inside.unlit, dark, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8UC1));  // noise lights single pixels
  dark &= ~inside.all;
  if (cv::countNonZero(dark) == 0) return;
  const auto count = static_cast<std::size_t>(cv::connectedComponents(dark, labels, 4, CV_32S));
  const auto is_fold = bordered_by(inside.all, labels, count);
  for (int y = 0; y < dark.rows; ++y)
    for (int x = 0; x < dark.cols; ++x)
      if (is_fold[static_cast<std::size_t>(labels.at<int>(y, x))])
        inside.all.at<std::uint8_t>(y, x) = inside.firm.at<std::uint8_t>(y, x) = 255;
}

void add_sharp_edged_cloth(KeyedPixels& inside) {
  const cv::Mat doubtful = (inside.lead > kLeastLead) & (inside.brightness < kDark) & ~inside.unlit & ~inside.all;
  if (cv::countNonZero(doubtful) == 0) return;
  cv::Mat labels;
  const auto count = static_cast<std::size_t>(cv::connectedComponents(doubtful, labels, 4, CV_32S));
  const auto leads = leads_of(inside, labels, count);
  const auto steps = steps_outward(inside, labels, count);
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x) {
      const auto piece = static_cast<std::size_t>(labels.at<int>(y, x));
      if (leads[piece] > kClothLead && steps[piece] > kSharpStep)
        inside.all.at<std::uint8_t>(y, x) = inside.firm.at<std::uint8_t>(y, x) = 255;
    }
}

void firm_wide_cloth(KeyedPixels& inside) {
  cv::Mat wide;
  cv::morphologyEx(inside.all & ~inside.firm, wide, cv::MORPH_OPEN,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kMixtureReach + 1, 2 * kMixtureReach + 1}));
  if (cv::countNonZero(wide) == 0) return;
  cv::Mat sure = inside.all.clone();
  turn_pieces(sure, 255, inside.firm, [](const int* piece, int firm) { return 2 * firm < piece[cv::CC_STAT_AREA]; });
  inside.firm |= wide & sure;
}

}  // namespace rotunda::capture
