#include "recon/take_plates.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "capture/matte/learnt_plate.h"
#include "capture/picture.h"
#include "config/errors.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostPictures = 16;  // of a camera; enough for a median, and little to hold at once

// Of as many frames from all over the take.
std::vector<cv::Mat> pictures_of(const capture::TakeReader& take, std::size_t camera, std::size_t most) {
  const auto count = std::min(take.frame_set_count(), most);
  std::vector<cv::Mat> pictures;
  for (std::size_t i = 0; i < count; ++i) {
    auto picture = capture::picture_of(take.read((2 * i + 1) * take.frame_set_count() / (2 * count), camera));
    if (!picture.rgb.empty()) pictures.push_back(std::move(picture.rgb));
  }
  return pictures;
}

bool is_grey(const cv::Mat& rgb) {
  std::vector<cv::Mat> channels;
  cv::split(rgb, channels);
  return cv::norm(channels[0], channels[1], cv::NORM_INF) == 0.0 &&
         cv::norm(channels[1], channels[2], cv::NORM_INF) == 0.0;
}

struct Outcome {
  bool wanted = false, grey = false, screen = false;
};

Outcome learn(const capture::TakeReader& take, std::size_t camera, StudioViews& studio) {
  const auto& name = take.info().cameras[camera].name;
  if (!studio.backgrounds[camera].empty() || fs::exists(capture::matte_file(take.folder(), name, 0))) return {};
  const auto pictures = pictures_of(take, camera, kMostPictures);
  if (pictures.empty()) return {};
  Outcome outcome{.wanted = true, .grey = std::all_of(pictures.begin(), pictures.end(), is_grey)};
  outcome.screen = std::any_of(pictures.begin(), pictures.end(), [&](const cv::Mat& picture) {
    return !capture::fit_plate(picture, studio.backdrop).empty();
  });
  if (!outcome.screen) return outcome;
  const auto learnt = capture::learn_plate(pictures, studio.backdrop);
  if (learnt.picture.empty()) return outcome;
  const auto file = learnt_plate_file(take.folder(), name);
  fs::create_directories(file.parent_path());
  capture::write_png(file, learnt.picture);
  studio.backgrounds[camera] = learnt.picture;
  return outcome;
}

void refuse_hopeless(const capture::TakeReader& take, const std::vector<Outcome>& outcomes,
                     capture::Backdrop backdrop) {
  std::string grey;
  bool any_wanted = false, any_screen = false;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    any_wanted = any_wanted || outcomes[i].wanted;
    any_screen = any_screen || outcomes[i].screen || !outcomes[i].wanted;
    if (outcomes[i].grey) grey += (grey.empty() ? "" : ", ") + take.info().cameras[i].name;
  }
  constexpr const char* kRemedy =
      "record the empty studio before the take (rotunda plate), or import with --background DIR or --mattes DIR";
  if (!grey.empty())
    throw InvalidInput(
        fmt::format("{}: grey pictures, and none of the empty studio to tell the performer by; {}", grey, kRemedy));
  if (any_wanted && !any_screen)
    throw InvalidInput(
        fmt::format("no camera of take {} shows a {} screen, and there is no picture of the empty studio "
                    "to tell the performer by; {}",
                    take.info().name, backdrop == capture::Backdrop::blue ? "blue" : "green", kRemedy));
}

}  // namespace

fs::path learnt_plate_file(const fs::path& take, const capture::CameraId& camera) {
  return take / "recon" / "plates" / (camera + ".png");
}

void learn_missing_plates(const capture::TakeReader& take, StudioViews& studio) {
  std::vector<Outcome> outcomes(studio.backgrounds.size());
  tbb::parallel_for(std::size_t{0}, outcomes.size(), [&](std::size_t i) { outcomes[i] = learn(take, i, studio); });
  refuse_hopeless(take, outcomes, studio.backdrop);
}

void make_live_keys(const capture::TakeReader& take, StudioViews& studio) {
  const auto make = [&](std::size_t i) -> std::optional<capture::LiveKey> {
    cv::Mat plate = studio.backgrounds[i];
    if (plate.empty())
      if (const auto first = pictures_of(take, i, 1); !first.empty())
        plate = capture::fit_plate_picture(first.front(), studio.backdrop);
    const cv::Mat stage = i < studio.stages.size() ? studio.stages[i] : cv::Mat();
    if (plate.empty() || !capture::is_before_screen(plate, studio.backdrop, stage)) return std::nullopt;
    return capture::LiveKey(plate, take.info().cameras[i].format, {studio.backdrop, stage});
  };
  studio.live_keys.resize(studio.cameras.size());
  tbb::parallel_for(std::size_t{0}, studio.cameras.size(), [&](std::size_t i) { studio.live_keys[i] = make(i); });
}

}  // namespace rotunda::recon
