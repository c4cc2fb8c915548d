#include "capture/calibration/board_refusal.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/calibration/camera_start.h"
#include "capture/calibration/grid_finder.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr std::size_t kLookedAt = 12;  // pictures, to say what is there instead of the board
constexpr int kLongestLookedAt = 800;  // pixels of a side, for another chessboard: large ones take minutes to deny

// Boards that each camera must have seen: where its lens is known already, one tells where it stands; where there are
// no more moments, one must do.
std::size_t fewest_views(const BoardPictures& pictures, const CalibrateOptions& options) {
  return options.known.empty() && pictures.moments.size() >= kFewestViews ? kFewestViews : 1;
}

std::vector<std::size_t> some_of(std::size_t count) {
  std::vector<std::size_t> some;
  const std::size_t n = std::min(count, kLookedAt);
  for (std::size_t i = 0; i < n; ++i) some.push_back(i * count / n);
  return some;
}

// Of all cameras from `first` on to `last`, which is not among them.
std::vector<cv::Mat> some_pictures(const BoardPictures& pictures, std::size_t first, std::size_t last) {
  std::vector<cv::Mat> some;
  for (const std::size_t i : some_of((last - first) * pictures.moments.size())) {
    cv::Mat grey = pictures.grey(first + i / pictures.moments.size(), i % pictures.moments.size());
    if (grey.type() == CV_16UC1) grey.convertTo(grey, CV_8U, 1.0 / 257.0);
    if (!grey.empty()) some.push_back(std::move(grey));
  }
  return some;
}

// The dictionary these markers are of. A large one holds all markers of the smaller ones with as many bits, and by
// chance some more: the smallest that explains nearly as many is meant, the expected one before all.
std::string dictionary_of(const std::vector<cv::Mat>& pictures, const std::string& expected) {
  constexpr double kNearlyAsMany = 0.75;
  std::vector<std::pair<std::string, int>> counts;
  int most = 0;
  for (const auto& name : dictionary_names()) {
    int count = 0;
    for (const auto& picture : pictures) count += count_markers(picture, name);
    most = std::max(most, count);
    counts.insert(name == expected ? counts.begin() : counts.end(), {name, count});
  }
  if (most < 4) return {};
  return std::find_if(counts.begin(), counts.end(), [&](const auto& c) { return c.second >= kNearlyAsMany * most; })
      ->first;
}

std::string other_markers(const std::vector<cv::Mat>& pictures, const std::string& expected) {
  const auto best = dictionary_of(pictures, expected);
  if (best.empty()) return {};
  if (best == expected)
    return fmt::format(
        "there are markers of {}, but not where the board file says: squares, markers or first_marker "
        "are others",
        best);
  return fmt::format("there are markers of {} instead of {}", best,
                     expected.empty() ? "a plain chessboard: is it a ChArUco board?" : expected);
}

cv::Mat no_longer_than(int longest, const cv::Mat& picture) {
  const double scale = static_cast<double>(longest) / std::max(picture.cols, picture.rows);
  cv::Mat smaller = picture;
  if (scale < 1.0) cv::resize(picture, smaller, {}, scale, scale, cv::INTER_AREA);
  return smaller;
}

std::string other_chessboard(const std::vector<cv::Mat>& pictures, const Board& board) {
  const cv::Size wanted(board.columns - 1, board.rows - 1);
  for (const auto& whole : pictures) {
    const cv::Mat picture = no_longer_than(kLongestLookedAt, whole);
    for (int w = std::max(3, wanted.width - 2); w <= wanted.width + 2; ++w)
      for (int h = std::max(3, wanted.height - 2); h <= wanted.height + 2; ++h) {
        if (cv::Size(w, h) == wanted || !cv::checkChessboard(picture, {w, h})) continue;
        std::vector<cv::Point2f> corners;
        if (cv::findChessboardCorners(
                picture, {w, h}, corners,
                cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK))
          return fmt::format("there is a chessboard of {} x {} inner corners instead of {} x {}", w, h, wanted.width,
                             wanted.height);
      }
  }
  return {};
}

bool mirrored_markers(const std::vector<cv::Mat>& pictures, const std::string& dictionary) {
  int as_they_are = 0, mirrored = 0;
  for (const auto& picture : pictures) {
    cv::Mat flipped;
    cv::flip(picture, flipped, 1);
    as_they_are += count_markers(picture, dictionary);
    mirrored += count_markers(flipped, dictionary);
  }
  return mirrored >= 4 && mirrored > 3 * as_they_are;
}

// Markers of this or another dictionary, a chessboard of another size, mirrored markers: in words, none for none.
std::string what_is_there_instead(const std::vector<cv::Mat>& some, std::span<const Board> boards) {
  if (some.empty()) return "there is no picture that can be read";
  for (const auto& board : boards) {
    if (board.type == BoardType::charuco && mirrored_markers(some, board.dictionary))
      return "the pictures are mirrored: markers are found once they are turned about";
    const auto text =
        board.type == BoardType::charuco ? other_markers(some, board.dictionary) : other_chessboard(some, board);
    if (!text.empty()) return text;
  }
  // Not of its kind either.
  if (boards.front().type == BoardType::charuco) return other_chessboard(some, boards.front());
  return other_markers(some, "");
}

}  // namespace

void refuse_too_little(std::size_t cameras) {
  if (cameras < 2) throw InvalidInput(fmt::format("there is {} camera; a rig has two at least", cameras));
}

void refuse_another_board(const BoardSearch& search, const BoardPictures& pictures, const CalibrateOptions& options) {
  std::vector<std::size_t> views(pictures.cameras.size(), 0);
  for (const auto& sighting : search.sightings) ++views[sighting.camera];
  if (!views.empty() && *std::max_element(views.begin(), views.end()) >= fewest_views(pictures, options)) return;
  const auto instead = what_is_there_instead(some_pictures(pictures, 0, pictures.cameras.size()), options.boards);
  if (!search.sightings.empty() && instead.empty()) return;
  throw InvalidInput(fmt::format("the board was found in {} of {} pictures: {}", search.sightings.size(),
                                 pictures.cameras.size() * pictures.moments.size(),
                                 instead.empty()
                                     ? "neither markers nor a chessboard are to be recognised: bring the board nearer "
                                       "(its squares 15 pixels or more), hold it still, the whole of it in the picture"
                                     : instead));
}

void refuse_another_world(std::span<const std::string> cameras, const std::string& world_from) {
  if (world_from.empty() || std::find(cameras.begin(), cameras.end(), world_from) != cameras.end()) return;
  throw InvalidInput(fmt::format("the world cannot be taken from {}: there are {}", world_from,
                                 fmt::join(cameras.begin(), cameras.end(), ", ")));
}

std::vector<std::string> why_unseen(const BoardSearch& search, const BoardPictures& pictures,
                                    const CalibrateOptions& options) {
  std::vector<std::size_t> views(pictures.cameras.size(), 0);
  for (const auto& sighting : search.sightings) ++views[sighting.camera];
  std::vector<std::string> reasons(views.size());
  for (std::size_t i = 0; i < views.size(); ++i)
    if (views[i] < fewest_views(pictures, options))
      reasons[i] = what_is_there_instead(some_pictures(pictures, i, i + 1), options.boards);
  return reasons;
}

}  // namespace rotunda::capture
