#include "capture/calibration/board_search.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <set>

#include "capture/calibration/grid_finder.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr std::size_t kLookedAt = 12;  // pictures, to say what is there instead of the board

// Runs `work(camera, moment)` for all pictures, tells progress, ends early if stopped.
void for_each_picture(const std::string& step, std::size_t cameras, std::size_t moments,
                      const CalibrateOptions& options, const std::stop_token& stop,
                      const std::function<void(std::size_t, std::size_t)>& work) {
  std::atomic<std::size_t> done = 0;
  std::mutex telling;
  const std::size_t total = cameras * moments;
  tbb::parallel_for(std::size_t{0}, total, [&](std::size_t i) {
    if (stop.stop_requested()) return;
    work(i / moments, i % moments);
    const std::size_t now = ++done;
    if (!options.progress) return;
    const std::scoped_lock lock(telling);
    options.progress(step, now, total);
  });
  if (stop.stop_requested()) throw InvalidInput("calibration was interrupted; nothing was written");
}

// A camera's size is that of most of its pictures.
cv::Size size_of(const std::vector<cv::Size>& sizes) {
  std::map<std::pair<int, int>, int> counts;
  for (const auto& size : sizes)
    if (!size.empty()) ++counts[{size.width, size.height}];
  cv::Size best;
  int most = 0;
  for (const auto& [size, count] : counts)
    if (count > most) most = count, best = {size.first, size.second};
  return best;
}

std::vector<std::size_t> some_of(std::size_t count) {
  std::vector<std::size_t> some;
  const std::size_t n = std::min(count, kLookedAt);
  for (std::size_t i = 0; i < n; ++i) some.push_back(i * count / n);
  return some;
}

std::vector<cv::Mat> some_pictures(const BoardPictures& pictures) {
  std::vector<cv::Mat> some;
  for (const std::size_t i : some_of(pictures.cameras.size() * pictures.moments.size())) {
    cv::Mat grey = pictures.grey(i / pictures.moments.size(), i % pictures.moments.size());
    if (grey.type() == CV_16UC1) grey.convertTo(grey, CV_8U, 1.0 / 257.0);
    if (!grey.empty()) some.push_back(std::move(grey));
  }
  return some;
}

std::string other_markers(const std::vector<cv::Mat>& pictures, const std::string& expected) {
  std::string best;
  int most = 0;
  for (const auto& name : dictionary_names()) {
    int count = 0;
    for (const auto& picture : pictures) count += count_markers(picture, name);
    if (count <= most || count < 4) continue;
    most = count;
    best = name;
  }
  if (best.empty()) return {};
  if (best == expected)
    return fmt::format(
        "there are markers of {}, but not where the board file says: squares, markers or first_marker "
        "are others",
        best);
  return fmt::format("there are markers of {} instead of {}", best, expected);
}

std::string other_chessboard(const std::vector<cv::Mat>& pictures, const Board& board) {
  const cv::Size wanted(board.columns - 1, board.rows - 1);
  for (const auto& picture : pictures)
    for (int w = std::max(3, wanted.width - 2); w <= wanted.width + 2; ++w)
      for (int h = std::max(3, wanted.height - 2); h <= wanted.height + 2; ++h) {
        if (cv::Size(w, h) == wanted) continue;
        std::vector<cv::Point2f> corners;
        if (cv::findChessboardCorners(
                picture, {w, h}, corners,
                cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK))
          return fmt::format("there is a chessboard of {} x {} inner corners instead of {} x {}", w, h, wanted.width,
                             wanted.height);
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

}  // namespace

BoardSearch search_boards(const BoardPictures& pictures, const BoardDetector& detector, const CalibrateOptions& options,
                          const std::stop_token& stop) {
  const std::size_t cameras = pictures.cameras.size(), moments = pictures.moments.size();
  std::vector<std::vector<FoundBoard>> found(cameras * moments);
  std::vector<std::vector<cv::Size>> sizes(cameras, std::vector<cv::Size>(moments));
  for_each_picture("boards", cameras, moments, options, stop, [&](std::size_t camera, std::size_t moment) {
    const cv::Mat grey = pictures.grey(camera, moment);
    sizes[camera][moment] = grey.size();
    if (!grey.empty()) found[camera * moments + moment] = detector.detect(grey);
  });
  BoardSearch search;
  for (std::size_t camera = 0; camera < cameras; ++camera) {
    const cv::Size size = size_of(sizes[camera]);
    search.sizes.push_back({.name = pictures.cameras[camera], .width = size.width, .height = size.height});
    search.pictures.push_back(0);
    for (std::size_t moment = 0; moment < moments; ++moment) {
      if (sizes[camera][moment].empty()) continue;
      if (sizes[camera][moment] != size) {
        search.troubles.push_back(fmt::format(
            "{}: {} is {} x {}, the others are {} x {}: left out", pictures.cameras[camera], pictures.moments[moment],
            sizes[camera][moment].width, sizes[camera][moment].height, size.width, size.height));
        continue;
      }
      ++search.pictures.back();
      for (auto& board : found[camera * moments + moment])
        search.sightings.push_back({.camera = camera,
                                    .moment = moment,
                                    .board = board.board,
                                    .blur_px = board.blur_px,
                                    .corners = std::move(board.corners)});
    }
  }
  return search;
}

std::vector<Sighting> search_predicted(const BoardPictures& pictures, const BoardDetector& detector,
                                       const RigState& state, std::span<const Sighting> found,
                                       std::span<const std::size_t> source, double reach_px,
                                       const CalibrateOptions& options, const std::stop_token& stop) {
  const std::size_t cameras = source.size(), moments = pictures.moments.size();
  std::map<std::pair<std::size_t, BoardKey>, const Sighting*> known;
  for (const auto& sighting : found) known[{sighting.camera, {sighting.moment, sighting.board}}] = &sighting;
  std::vector<std::vector<Sighting>> seen(cameras * moments);
  for_each_picture("missed boards", cameras, moments, options, stop, [&](std::size_t camera, std::size_t moment) {
    const auto first = state.world_from_board.lower_bound({moment, 0});
    if (first == state.world_from_board.end() || first->first.first != moment) return;
    const cv::Mat grey = pictures.grey(source[camera], moment);
    if (grey.cols != state.cameras[camera].width || grey.rows != state.cameras[camera].height) return;
    const cv::Mat linear = linear_light(grey);
    for (auto pose = first; pose != state.world_from_board.end() && pose->first.first == moment; ++pose) {
      const auto before = known.find({camera, pose->first});
      Sighting which{.camera = camera, .moment = moment, .board = pose->first.second, .predicted = true};
      if (before != known.end()) {
        which.predicted = before->second->predicted;
        which.blur_px = before->second->blur_px;
      }
      auto sighting = look_where_predicted(linear, state, detector.print(which.board), which, {.reach_px = reach_px});
      if (!sighting.corners.empty()) seen[camera * moments + moment].push_back(std::move(sighting));
    }
  });
  std::vector<Sighting> all;
  for (auto& some : seen) std::move(some.begin(), some.end(), std::back_inserter(all));
  return all;
}

std::string what_is_there_instead(const BoardPictures& pictures, std::span<const Board> boards) {
  const auto some = some_pictures(pictures);
  if (some.empty()) return "there is no picture that can be read";
  for (const auto& board : boards) {
    if (board.type == BoardType::charuco && mirrored_markers(some, board.dictionary))
      return "the pictures are mirrored: markers are found once they are turned about";
    const auto text =
        board.type == BoardType::charuco ? other_markers(some, board.dictionary) : other_chessboard(some, board);
    if (!text.empty()) return text;
  }
  return {};
}

}  // namespace rotunda::capture
