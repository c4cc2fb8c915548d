#include "capture/calibration/take_watch.h"

#include <fmt/format.h>

#include <exception>
#include <opencv2/core.hpp>

#include "capture/calibration/camera_watch.h"
#include "capture/picture.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFrameSetsTried = 25;

cv::Mat green_of(const cv::Mat& rgb) {
  cv::Mat green;
  cv::extractChannel(rgb, green, 1);
  return green;
}

// The first picture of the camera among the take's first frame sets.
cv::Mat first_picture(const TakeReader& take, std::size_t camera) {
  for (std::size_t i = 0; i < std::min(kFrameSetsTried, take.frame_set_count()); ++i)
    if (const auto picture = picture_of(take.read(i, camera)); !picture.rgb.empty()) return green_of(picture.rgb);
  return {};
}

CameraMove compare(const std::string& camera, const fs::path& background, const cv::Mat& now) {
  CameraMove move{.camera = camera};
  const auto not_told = [&](const std::string& why) {
    move.how = "not told: " + why;
    return move;
  };
  if (now.empty()) return not_told("there is no picture");
  if (!fs::exists(background)) return not_told("there is no " + background.string());
  const cv::Mat before = green_of(read_rgb(background));
  if (before.size() != now.size()) return not_told(background.string() + " is of another size");
  const auto shift = background_shift(before, now);
  if (!shift) return not_told("too little of the background is to be recognised");
  move.shift_px = shift->shift_px;
  move.moved = has_moved(*shift);
  move.how = fmt::format("{} features", shift->features);
  return move;
}

}  // namespace

std::vector<CameraMove> camera_moves(const TakeReader& take, const fs::path& background) {
  std::vector<CameraMove> moves;
  for (std::size_t i = 0; i < take.info().cameras.size(); ++i) {
    const auto& name = take.info().cameras[i].name;
    const auto before = background.empty() ? background_file(take.folder(), name) : background / (name + ".png");
    moves.push_back(compare(name, before, first_picture(take, i)));
  }
  return moves;
}

std::vector<std::string> moves_in_words(const fs::path& folder) {
  std::vector<std::string> words;
  try {
    const TakeReader take(folder);
    for (const auto& move : camera_moves(take))
      if (move.moved)
        words.push_back(
            fmt::format("{} has moved by {:.1f} px since the empty studio was recorded: fasten it, record the "
                        "empty studio and calibrate anew (rotunda calibrate --check {} tells of all cameras)",
                        move.camera, *move.shift_px, take.info().name));
  } catch (const std::exception& error) {
    words.push_back(std::string("whether cameras have moved cannot be told: ") + error.what());
  }
  return words;
}

}  // namespace rotunda::capture
