#include "rig/cli/calibrate_live.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "capture/calibration/board_detector.h"
#include "capture/calibration/board_walk.h"
#include "capture/picture.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "rig/client.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;

constexpr int kFruitless = 5;  // takes in a row without any picture: something is wrong with the rig

// The pictures of one moment, a camera each; empty where there is none.
struct Moment {
  std::vector<std::string> cameras;
  std::vector<cv::Mat> grey;
  std::vector<cv::Mat> rgb;  // until they are written
};

// A take of one frame set, gone again when its pictures were read.
Moment picture_moment(RigClient& client, const std::stop_token& stop) {
  const TakeRequest request{.frame_sets = 1, .note = "boards for calibration; deleted when they were looked at"};
  const auto take = client.start_take(
      request, [](const TakeProgress&) { return true; }, stop);
  if (!take.failure.empty()) throw DeviceError("rig", take.failure);
  Moment moment;
  {
    const capture::TakeReader reader(take.folder);
    for (const auto& camera : reader.info().cameras) moment.cameras.push_back(camera.name);
    moment.grey.resize(moment.cameras.size());
    moment.rgb.resize(moment.cameras.size());
    if (reader.frame_set_count() > 0) {
      const auto set = reader.read(0);
      for (std::size_t i = 0; i < set.slots.size(); ++i)
        if (const auto picture = capture::picture_of(set.slots[i]); !picture.rgb.empty()) {
          moment.rgb[i] = picture.rgb;
          cv::extractChannel(picture.rgb, moment.grey[i], 1);
        }
    }
  }
  fs::remove_all(take.folder);
  return moment;
}

std::vector<capture::Sighting> look_for_boards(const capture::BoardDetector& detector, const Moment& moment) {
  std::vector<std::vector<capture::FoundBoard>> found(moment.grey.size());
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
    if (!moment.grey[i].empty()) found[i] = detector.detect(moment.grey[i]);
  });
  std::vector<capture::Sighting> sightings;
  for (std::size_t camera = 0; camera < found.size(); ++camera)
    for (auto& board : found[camera])
      sightings.push_back(
          {.camera = camera, .board = board.board, .blur_px = board.blur_px, .corners = std::move(board.corners)});
  return sightings;
}

constexpr std::size_t kToldEvery = 10;  // kept moments

// Redrawn in place on a terminal; else a line a kept moment, and now and then what each camera needs.
class NeedsTable {
 public:
  void show(const capture::BoardWalk& walk, std::size_t seen_now) {
    const auto needs = walk.needs();
    if (isatty(STDERR_FILENO) == 0) {
      if (walk.moments() == told_) return;
      if (told_ / kToldEvery != walk.moments() / kToldEvery || told_ == 0)
        for (const auto& need : needs)
          if (!need.needs.empty()) fmt::print(stderr, "{} needs {}\n", need.camera, need.needs);
      told_ = walk.moments();
      const auto done = std::count_if(needs.begin(), needs.end(), [](const auto& n) { return n.needs.empty(); });
      fmt::print(stderr, "{} moments kept; {} of {} cameras have enough\n", walk.moments(), done, needs.size());
      return;
    }
    if (lines_ > 0) fmt::print(stderr, "\x1b[{}A", lines_);
    for (const auto& need : needs)
      fmt::print(stderr, "\x1b[2K{:<12} {:>3} boards  {}\n", need.camera, need.views,
                 need.needs.empty() ? "enough" : "needs " + need.needs);
    fmt::print(stderr,
               "\x1b[2K{} moments kept; the board is seen by {} cameras now. Hold it still for a moment. Ctrl-C ends\n",
               walk.moments(), seen_now);
    lines_ = needs.size() + 1;
  }

 private:
  std::size_t lines_ = 0, told_ = 0;
};

void keep_pictures(const fs::path& folder, const Moment& moment, std::size_t number) {
  for (std::size_t i = 0; i < moment.cameras.size(); ++i) {
    if (moment.rgb[i].empty()) continue;
    fs::create_directories(folder / moment.cameras[i]);
    capture::write_png(folder / moment.cameras[i] / fmt::format("moment{:04}.png", number), moment.rgb[i]);
  }
}

std::vector<capture::CameraModel> sizes_of(const Moment& moment) {
  std::vector<capture::CameraModel> sizes;
  for (std::size_t i = 0; i < moment.cameras.size(); ++i)
    sizes.push_back({.name = moment.cameras[i], .width = moment.grey[i].cols, .height = moment.grey[i].rows});
  return sizes;
}

}  // namespace

LiveBoards walk_with_board(const fs::path& daemon, const std::vector<capture::Board>& boards, const fs::path& keep,
                           const std::stop_token& stop) {
  RigClient client(daemon_socket(daemon));
  const capture::BoardDetector detector(boards);
  auto kept = std::make_shared<std::vector<Moment>>();
  std::optional<capture::BoardWalk> walk;
  NeedsTable table;
  for (int fruitless = 0; !stop.stop_requested() && !(walk && walk->is_enough());) {
    auto moment = picture_moment(client, stop);
    const bool all = std::none_of(moment.grey.begin(), moment.grey.end(), [](const auto& g) { return g.empty(); });
    if (!walk && all && !moment.grey.empty()) walk.emplace(sizes_of(moment), boards);
    if (!walk && ++fruitless >= kFruitless)
      throw DeviceError("rig", "not every camera sends pictures; rotunda status tells which");
    if (!walk) continue;
    auto found = look_for_boards(detector, moment);
    const std::size_t seen_now = found.size();
    if (walk->add(std::move(found))) {
      if (!keep.empty()) keep_pictures(keep, moment, kept->size());
      moment.rgb.clear();
      kept->push_back(std::move(moment));
    }
    table.show(*walk, seen_now);
  }
  if (kept->empty()) throw InvalidInput("no camera saw the board: is it the one of the board file?");
  LiveBoards live{.enough = walk->is_enough()};
  live.pictures.cameras = kept->front().cameras;
  for (std::size_t i = 0; i < kept->size(); ++i) live.pictures.moments.push_back(fmt::format("moment{:04}", i));
  live.pictures.grey = [kept](std::size_t camera, std::size_t moment) { return (*kept)[moment].grey[camera]; };
  if (!keep.empty())
    live.pictures.file = [keep, names = live.pictures.cameras](std::size_t camera, std::size_t moment) {
      return keep / names[camera] / fmt::format("moment{:04}.png", moment);
    };
  return live;
}

}  // namespace rotunda::rig
