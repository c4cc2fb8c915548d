// rotunda screen: the blue-screen meter, for whoever sets the lights.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/matte/chroma_key.h"
#include "capture/matte/screen_meter.h"
#include "capture/matte/screen_overlay.h"
#include "capture/picture.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/rig_config.h"
#include "rig/cli/command_line.h"
#include "rig/client.h"
#include "rig/daemon/plate_recording.h"

namespace rotunda::rig {
namespace {

using capture::Backdrop;
using capture::ScreenReading;
using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::uint64_t kLivePictures = 10;  // averaged of each camera

struct ScreenRequest {
  std::string take;  // empty: plates or --images
  std::size_t frame = 0;
  fs::path images;
  bool live = false;
  std::string backdrop;  // empty: the take's rig file's, else blue
  fs::path overlay;
};

// One camera's pictures, the first to be measured; its matte where there is a performer.
struct CameraScreen {
  std::string camera;
  std::vector<cv::Mat> pictures;
  cv::Mat alpha;
};

std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto ending = entry.path().extension().string();
    if (entry.is_regular_file() && (ending == ".png" || ending == ".jpg" || ending == ".jpeg"))
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// DIR/<camera>.png, and DIR/<camera>/*.png of which two are enough.
std::vector<CameraScreen> from_folder(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InvalidInput(folder.string() + " is not a folder");
  std::map<std::string, CameraScreen> cameras;
  for (const auto& file : pictures_in(folder)) cameras[file.stem().string()].pictures = {capture::read_rgb(file)};
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (!entry.is_directory()) continue;
    const auto files = pictures_in(entry.path());
    for (std::size_t i = 0; i < std::min<std::size_t>(2, files.size()); ++i)
      cameras[entry.path().filename().string()].pictures.push_back(capture::read_rgb(files[i]));
  }
  std::vector<CameraScreen> result;
  for (auto& [name, camera] : cameras) {
    camera.camera = name;
    result.push_back(std::move(camera));
  }
  if (result.empty())
    throw InvalidInput(folder.string() + " holds no pictures: expected <camera>.png, or <camera>/*.png");
  return result;
}

std::vector<CameraScreen> from_plates(const CommandLine& line, bool live) {
  if (live) return from_folder(RigClient(daemon_socket(line.daemon)).record_plate(kLivePictures).folder);
  const auto folder = plate_folder(takes_folder(line));
  if (!fs::is_directory(folder))
    throw InvalidInput("no plate of the empty studio is kept in " + takes_folder(line).string() +
                       ": record one (rotunda plate, or rotunda screen --live), or name a take or --images DIR");
  return from_folder(folder);
}

Backdrop backdrop_of(const ScreenRequest& request, const fs::path& rig_file) {
  if (!request.backdrop.empty()) return request.backdrop == "green" ? Backdrop::green : Backdrop::blue;
  if (!fs::exists(rig_file)) return Backdrop::blue;
  return config::load_rig(rig_file).backdrop == "green" ? Backdrop::green : Backdrop::blue;
}

std::vector<CameraScreen> from_take(const capture::TakeReader& take, std::size_t frame, Backdrop backdrop) {
  const auto count = take.info().frame_sets;
  if (frame >= count) throw InvalidInput(fmt::format("{} has no frame {}: it has {}", take.info().name, frame, count));
  std::vector<CameraScreen> cameras(take.info().cameras.size());
  for (std::size_t f = frame; f < std::min<std::size_t>(frame + 2, count); ++f) {
    const auto set = take.read(f);
    for (std::size_t i = 0; i < cameras.size(); ++i)
      if (auto picture = capture::picture_of(set.slots[i]); !picture.rgb.empty())
        cameras[i].pictures.push_back(std::move(picture.rgb));
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    cameras[i].camera = take.info().cameras[i].name;
    if (cameras[i].pictures.empty()) continue;
    const auto plate = capture::background_file(take.folder(), cameras[i].camera);
    cameras[i].alpha = capture::chroma_key(cameras[i].pictures[0], {.backdrop = backdrop},
                                           fs::exists(plate) ? capture::read_rgb(plate) : cv::Mat())
                           .alpha;
  }
  return cameras;
}

json to_json(const std::string& camera, const ScreenReading& r) {
  return {{"name", camera},
          {"share", r.share},
          {"unevenness", r.unevenness},
          {"saturation", r.saturation},
          {"least_saturation", r.least_saturation},
          {"clipped", r.clipped},
          {"noise", r.noise},
          {"headroom", r.headroom},
          {"spill", r.spill ? json(*r.spill) : json(nullptr)},
          {"brightest", r.brightest},
          {"darkest", r.darkest},
          {"advice", r.advice}};
}

void tell(const std::string& camera, const ScreenReading& r) {
  fmt::print("{:<10} {:>7.0f} {:>8.2f} {:>6.2f} {:>6.2f} {:>6.1f} {:>9.0f} {:>9.2f} {:>6}\n", camera, 100 * r.share,
             r.unevenness, r.saturation, r.least_saturation, r.noise, r.headroom, 100 * r.clipped,
             r.spill ? fmt::format("{:.0f}", *r.spill) : "-");
}

int measure(const std::vector<CameraScreen>& cameras, Backdrop backdrop, const fs::path& overlay, bool as_json) {
  json list = json::array();
  std::vector<std::string> advice;
  if (!overlay.empty()) fs::create_directories(overlay);
  if (!as_json)
    fmt::print("{:<10} {:>7} {:>8} {:>6} {:>6} {:>6} {:>9} {:>9} {:>6}\n", "camera", "screen%", "uneven:1", "satur.",
               "least", "noise", "headroom", "clipped%", "spill");
  for (const auto& camera : cameras) {
    if (camera.pictures.empty()) {
      advice.push_back(camera.camera + ": has no picture");
      continue;
    }
    const auto reading = capture::measure_screen(camera.pictures, backdrop, camera.alpha);
    list.push_back(to_json(camera.camera, reading));
    if (!as_json) tell(camera.camera, reading);
    for (const auto& sentence : reading.advice) advice.push_back(camera.camera + ": " + sentence);
    if (!overlay.empty())
      capture::write_png(overlay / (camera.camera + ".png"),
                         capture::screen_overlay({camera.pictures[0], camera.alpha, camera.camera}, backdrop, reading));
  }
  if (as_json) fmt::print("{}\n", json{{"cameras", list}, {"advice", advice}}.dump(2));
  for (const auto& sentence : advice) fmt::print(stderr, "{}\n", sentence);
  if (!as_json && !overlay.empty()) fmt::print("pictures in {}\n", overlay.string());
  return advice.empty() ? kDone : kDoneWithLoss;
}

int run(const CommandLine& line, const ScreenRequest& request) {
  if (request.take.empty()) {
    const auto cameras = request.images.empty() ? from_plates(line, request.live) : from_folder(request.images);
    return measure(cameras, backdrop_of(request, {}), request.overlay, line.json);
  }
  const capture::TakeReader take(find_take(line, request.take));
  const auto backdrop = backdrop_of(request, take.folder() / "rig.yaml");
  return measure(from_take(take, request.frame, backdrop), backdrop, request.overlay, line.json);
}

}  // namespace

void add_screen_command(CommandLine& line) {
  auto* screen = line.app.add_subcommand("screen", "the blue-screen meter: evenness, colour, noise, spill by camera");
  auto request = std::make_shared<ScreenRequest>();
  auto* take = screen->add_option("take", request->take, "a take (else the plate that rotunda plate recorded last)");
  auto* images =
      screen->add_option("--images", request->images, "DIR/<camera>.png or DIR/<camera>/*.png")->excludes(take);
  screen->add_flag("--live", request->live, "have the daemon record the empty studio now, and measure that")
      ->excludes(take)
      ->excludes(images);
  screen->add_option("--frame", request->frame, "of the take")->needs(take);
  screen->add_option("--backdrop", request->backdrop, "blue or green (else the take's rig file's, else blue)")
      ->check(CLI::IsMember({"blue", "green"}));
  screen->add_option("--overlay", request->overlay,
                     "write DIR/<camera>.png: loud colours where the screen is bad, with figures");
  screen->footer(
      "uneven: brightest to darkest part; saturation 0 to 1 and where it is least; noise and spill in grey levels;\n"
      "headroom: deviations of noise between the screen and what the key calls performer. Exit code 1 if something\n"
      "should be changed.\nExample:\n  rotunda screen --live --overlay screens\n  rotunda screen demo --frame 12");
  screen->callback([&line, request] { line.run = [&line, request](std::stop_token) { return run(line, *request); }; });
}

}  // namespace rotunda::rig
