#include "rig/camera_portraits.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <thread>

#include "capture/picture.h"
#include "capture/source/source.h"
#include "config/errors.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

constexpr int kPlaceWidth = 480, kPlaceHeight = 400, kCaptionHeight = 64, kMargin = 12;
constexpr int kColumns = 4;
constexpr auto kPictureTime = 5s;
constexpr auto kBlink = 250ms;  // on, and off
constexpr auto kBlinkTime = 2s;
constexpr double kRate_hz = 5.0;

const cv::Scalar kBackground(32, 32, 36), kInk(235, 235, 235), kTrouble(255, 120, 100);

void write_words(cv::Mat& sheet, const std::string& words, cv::Point at, double size, const cv::Scalar& ink) {
  cv::putText(sheet, words, at, cv::FONT_HERSHEY_SIMPLEX, size, ink, 1, cv::LINE_AA);
}

void draw(cv::Mat& sheet, cv::Point corner, const CameraPortrait& portrait) {
  constexpr double kLarge = 0.8, kSmall = 0.5;
  constexpr int kFirstLine = 28, kSecondLine = 52;
  const auto& camera = portrait.camera;
  if (!portrait.picture.empty()) {
    const auto& picture = portrait.picture;
    picture.copyTo(sheet(cv::Rect(corner.x + (kPlaceWidth - picture.cols) / 2,
                                  corner.y + (kPlaceHeight - picture.rows) / 2, picture.cols, picture.rows)));
  } else {
    write_words(sheet, "no picture", corner + cv::Point(kMargin, kPlaceHeight / 2), kLarge, kTrouble);
  }
  const auto caption = corner + cv::Point(0, kPlaceHeight);
  write_words(sheet, camera.name, caption + cv::Point(0, kFirstLine), kLarge, kInk);
  write_words(sheet, fmt::format("{}  {}", camera.serial, camera.address), caption + cv::Point(0, kSecondLine), kSmall,
              camera.problem.empty() ? kInk : kTrouble);
}

cv::Mat contact_sheet(const std::vector<CameraPortrait>& portraits) {
  const int count = static_cast<int>(portraits.size());
  const int columns = std::clamp(count, 1, kColumns);
  const int rows = (count + columns - 1) / columns;
  const int step_x = kPlaceWidth + kMargin, step_y = kPlaceHeight + kCaptionHeight + kMargin;
  cv::Mat sheet(std::max(1, rows) * step_y + kMargin, columns * step_x + kMargin, CV_8UC3, kBackground);
  for (int i = 0; i < count; ++i)
    draw(sheet, {kMargin + i % columns * step_x, kMargin + i / columns * step_y},
         portraits[static_cast<std::size_t>(i)]);
  return sheet;
}

// One frame that a stream thread hands over.
class FirstFrame {
 public:
  void take(capture::Frame&& frame) {
    const std::lock_guard lock(mutex_);
    if (!frame_) frame_ = std::move(frame);
    came_.notify_all();
  }
  std::optional<capture::Frame> wait(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, patience, [this] { return frame_.has_value(); });
    return frame_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::optional<capture::Frame> frame_;
};

// Nobody knows yet what the camera sends: the first format that it takes.
std::unique_ptr<capture::Source> armed_source(capture::SourceSettings settings) {
  using capture::PixelFormat;
  for (const auto format : {PixelFormat::bayer_rg8, PixelFormat::bayer_gr8, PixelFormat::bayer_gb8,
                            PixelFormat::bayer_bg8, PixelFormat::mono8, PixelFormat::rgb8}) {
    settings.format = format;
    auto source = capture::make_source(settings);
    source->open();  // a camera that does not open has no format that helps
    try {
      source->arm();
      return source;
    } catch (const DeviceError&) {
      source->close();
    }
  }
  throw DeviceError(settings.camera,
                    "it takes none of the 8-bit pixel formats; see what it says to: rotundad --rig RIG");
}

std::optional<capture::Frame> picture_of(capture::Source& source, CameraPortrait& portrait, bool blink,
                                         const std::stop_token& stop) {
  FirstFrame first;
  source.start([&first](capture::Frame&& frame) { first.take(std::move(frame)); });
  bool lit = true;
  portrait.camera.blinked = blink && source.show_light(lit);
  const auto begun = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return std::chrono::steady_clock::now() - begun; };
  std::optional<capture::Frame> frame;
  while (!stop.stop_requested() && elapsed() < (frame ? (portrait.camera.blinked ? kBlinkTime : 0s) : kPictureTime)) {
    if (frame)
      std::this_thread::sleep_for(kBlink);
    else
      frame = first.wait(kBlink);
    if (portrait.camera.blinked) source.show_light(lit = !lit);
  }
  if (portrait.camera.blinked) source.show_light(false);
  source.stop();
  return frame;
}

CameraPortrait portrait_of(const capture::DiscoveredCamera& found, bool blink, const std::stop_token& stop) {
  CameraPortrait portrait;
  portrait.camera.name = found.user_name.empty() ? found.serial : found.user_name;
  portrait.camera.serial = found.serial;
  portrait.camera.address = found.address;
  portrait.camera.model = fmt::format("{} {}", found.vendor, found.model);
  try {
    const auto source = armed_source({.camera = portrait.camera.name,
                                      .kind = found.kind,
                                      .device = found.address.empty() ? found.serial : found.address,
                                      .frame_rate_hz = kRate_hz,
                                      .trigger = capture::TriggerMode::freerun});
    if (const auto frame = picture_of(*source, portrait, blink, stop))
      portrait.picture = portrait_picture(capture::to_rgb(frame->image));
    else
      portrait.camera.problem = fmt::format("no picture came within {} s", kPictureTime.count());
    source->close();
  } catch (const std::exception& error) {
    portrait.camera.problem = error.what();
  }
  return portrait;
}

bool is_called(const capture::DiscoveredCamera& camera, const std::string& name) {
  return name.empty() || name == camera.user_name || name == camera.serial || name == camera.address;
}

}  // namespace

cv::Mat portrait_picture(const cv::Mat& rgb) {
  const double scale =
      std::min({1.0, static_cast<double>(kPlaceWidth) / rgb.cols, static_cast<double>(kPlaceHeight) / rgb.rows});
  cv::Mat small;
  cv::resize(rgb, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

std::vector<IdentifiedCamera> write_contact_sheet(const std::filesystem::path& file,
                                                  const std::vector<CameraPortrait>& portraits) {
  if (file.extension() != ".png") throw InvalidInput(file.string() + ": a contact sheet is a FILE.png");
  auto part = file;
  part.replace_extension(".part.png");
  capture::write_png(part, contact_sheet(portraits));
  std::filesystem::rename(part, file);
  std::vector<IdentifiedCamera> cameras;
  for (const auto& portrait : portraits) {
    cameras.push_back(portrait.camera);
    cameras.back().pictured = !portrait.picture.empty();
  }
  return cameras;
}

std::vector<CameraPortrait> portraits_by_opening(const std::string& name, bool blink, std::stop_token stop) {
  std::vector<CameraPortrait> portraits;
  std::vector<std::string> others;
  for (const auto& camera : capture::discover_cameras()) {
    if (stop.stop_requested()) break;
    if (is_called(camera, name))
      portraits.push_back(portrait_of(camera, blink, stop));
    else
      others.push_back(camera.user_name.empty() ? camera.serial : camera.user_name);
  }
  if (portraits.empty() && !name.empty())
    throw InvalidInput(fmt::format("no camera called {} answers; there are: {}", name,
                                   others.empty() ? "none" : fmt::format("{}", fmt::join(others, ", "))));
  if (portraits.empty()) throw DeviceError("cameras", "none answers; check power, cables and addresses");
  return portraits;
}

}  // namespace rotunda::rig
