#include "capture/calibration/board_search.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <opencv2/core.hpp>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

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

}  // namespace rotunda::capture
