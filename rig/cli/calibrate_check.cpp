#include "rig/cli/calibrate_check.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "capture/calibration/board_folder.h"
#include "capture/calibration/board_search.h"
#include "capture/calibration/camera_watch.h"
#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "config/exit_code.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr double kBoardShiftTold = 1.0;  // pixels; boards held by hand and the calibration itself make a few tenths
constexpr std::size_t kFrameSetsTried = 25;

struct Checked {
  std::string camera;
  std::optional<double> shift_px;
  bool moved = false;
  std::string how;  // "61 features", "not told: no background"
};

cv::Mat green_of(const cv::Mat& rgb) {
  cv::Mat green;
  cv::extractChannel(rgb, green, 1);
  return green;
}

// The first picture of the camera among the take's first frame sets.
cv::Mat first_picture(const capture::TakeReader& take, std::size_t camera) {
  for (std::size_t i = 0; i < std::min(kFrameSetsTried, take.frame_set_count()); ++i)
    if (const auto picture = capture::picture_of(take.read(i, camera)); !picture.rgb.empty())
      return green_of(picture.rgb);
  return {};
}

Checked compare(const std::string& camera, const fs::path& background, const cv::Mat& now) {
  Checked checked{.camera = camera};
  if (now.empty() || !fs::exists(background)) {
    checked.how = now.empty() ? "not told: there is no picture" : "not told: there is no " + background.string();
    return checked;
  }
  const cv::Mat before = green_of(capture::read_rgb(background));
  if (before.size() != now.size()) {
    checked.how = fmt::format("not told: {} is of another size", background.string());
    return checked;
  }
  const auto shift = capture::background_shift(before, now);
  if (!shift) {
    checked.how = "not told: too little of the background is to be recognised";
    return checked;
  }
  checked.shift_px = shift->shift_px;
  checked.moved = capture::has_moved(*shift);
  checked.how = fmt::format("{} features", shift->features);
  return checked;
}

std::vector<Checked> check_take(const CheckRequest& request) {
  const capture::TakeReader take(request.take);
  std::vector<Checked> all;
  for (std::size_t i = 0; i < take.info().cameras.size(); ++i) {
    const auto& name = take.info().cameras[i].name;
    const fs::path before = request.background.empty() ? capture::background_file(take.folder(), name)
                                                       : request.background / (name + ".png");
    all.push_back(compare(name, before, first_picture(take, i)));
  }
  return all;
}

std::vector<Checked> check_boards_seen(const CheckRequest& request, const std::stop_token& stop) {
  if (request.boards.empty() || request.calibration.empty())
    throw InvalidInput("to check with pictures of boards give --board FILE and --calibration FILE as well");
  std::vector<capture::Board> boards;
  for (const auto& file : request.boards) {
    const auto some = capture::read_boards(file);
    boards.insert(boards.end(), some.begin(), some.end());
  }
  const auto cameras = capture::read_calibration(request.calibration);
  const auto folder = capture::read_board_folder(request.images);
  const capture::BoardDetector detector(boards);
  auto search = capture::search_boards(folder.pictures, detector, {.boards = boards}, stop);
  std::vector<capture::Sighting> known;
  for (auto& sighting : search.sightings)
    for (std::size_t i = 0; i < cameras.size(); ++i)
      if (cameras[i].name == search.sizes[sighting.camera].name &&
          cameras[i].width == search.sizes[sighting.camera].width) {
        auto& renumbered = known.emplace_back(sighting);
        renumbered.camera = i;
      }
  const auto shifts = capture::board_shifts(cameras, known, boards);
  std::vector<Checked> all;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    Checked checked{.camera = cameras[i].name, .how = "not told: it saw no board together with another camera"};
    if (shifts[i].corners > 0) {
      checked.shift_px = shifts[i].shift_px;
      checked.moved = shifts[i].shift_px > kBoardShiftTold;
      checked.how = fmt::format("{} corners", shifts[i].corners);
    }
    all.push_back(std::move(checked));
  }
  return all;
}

int tell(const std::vector<Checked>& all, bool as_json) {
  json list = json::array();
  bool good = true;
  for (const auto& one : all) {
    good = good && one.shift_px && !one.moved;
    json entry{{"camera", one.camera}, {"moved", one.moved}, {"how", one.how}};
    if (one.shift_px) entry["shift_px"] = *one.shift_px;
    list.push_back(entry);
    if (as_json) continue;
    const auto shift = one.shift_px ? fmt::format("{:.2f} px", *one.shift_px) : "-";
    fmt::print("{:<12} {:>9}  {:<6} {}\n", one.camera, shift, one.moved ? "MOVED" : "", one.how);
  }
  if (as_json) fmt::print("{}\n", list.dump(2));
  return good ? kDone : kDoneWithLoss;
}

}  // namespace

int check_cameras(const CheckRequest& request, bool as_json, const std::stop_token& stop) {
  if (!request.take.empty()) return tell(check_take(request), as_json);
  return tell(check_boards_seen(request, stop), as_json);
}

}  // namespace rotunda::rig
