#include "rig/daemon/plate_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "capture/base/bounded_queue.h"
#include "capture/matte/empty_studio.h"
#include "capture/picture.h"
#include "config/errors.h"
#include "rig/daemon/frame_set_stream.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr auto kDeadline = 500ms;
constexpr auto kPulse = 10ms;
constexpr std::size_t kQueued = 50;  // frame sets; pictures beyond are let go, an average does not miss them

using Averages = std::map<capture::CameraId, capture::EmptyStudioAverage>;

Averages average(FrameSetStream& stream) {
  Averages averages;
  capture::BoundedQueue<capture::FrameSet> queue(kQueued);
  stream.start([&queue](capture::FrameSet&& set) { queue.try_push(std::move(set)); });
  for (bool more = true; more || queue.size() > 0;) {
    more = stream.advance();
    while (const auto set = queue.wait_pop(kPulse))
      for (const auto& slot : set->slots)
        if (const auto picture = capture::picture_of(slot); !picture.rgb.empty())
          averages[slot.frame->camera].add(picture.rgb);
  }
  return averages;
}

CameraPlate keep(const fs::path& folder, const capture::CameraId& camera, const capture::EmptyStudio& studio) {
  const auto file = folder / (camera + ".png");
  const auto part = folder / ("." + camera + ".new.png");
  capture::write_png(part, studio.picture);
  fs::rename(part, file);
  return {.camera = camera,
          .file = file,
          .pictures = studio.pictures,
          .noise = studio.noise,
          .moving_share = studio.moving_share};
}

}  // namespace

fs::path plate_folder(const fs::path& takes) {
  return takes / ".plate";
}

PlateReport record_plate(const config::RigConfig& rig, CameraFleet& fleet, std::uint64_t frame_sets) {
  FrameSetStreamOptions options{.trigger = rig.trigger, .wanted = frame_sets, .cameras = {}, .deadline = kDeadline};
  for (const auto& camera : rig.cameras) options.cameras.push_back(camera.name);
  FrameSetStream stream(options, fleet);
  const auto averages = average(stream);
  const auto folder = plate_folder(rig.storage.takes);
  fs::create_directories(folder);
  PlateReport report{.folder = folder};
  for (const auto& camera : rig.cameras) {
    const auto found = averages.find(camera.name);
    if (found != averages.end() && found->second.pictures() >= 2)
      report.cameras.push_back(keep(folder, camera.name, found->second.result()));
    else
      report.missing.push_back(camera.name);
  }
  if (report.cameras.empty()) throw DeviceError("rig", "no camera sent pictures of the empty studio");
  return report;
}

}  // namespace rotunda::rig
