#include "simulator/served_studio.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/calibration_file.h"
#include "config/errors.h"
#include "config/rig_config.h"

namespace rotunda::simulator {
namespace {

GigeCameraOptions numbered_device(std::size_t number) {
  GigeCameraOptions device;
  device.serial = fmt::format("RS{:04}", number);
  device.address = fmt::format("127.0.0.{}", number + 1);
  device.mac.back() = static_cast<std::uint8_t>(number + 1);
  return device;
}

capture::PixelFormat format_of(const config::CameraConfig& camera) {
  const auto format = capture::pixel_format_from(camera.pixel_format);
  if (!format)
    throw InvalidInput(fmt::format("{}: the simulator does not send pixel_format {}; set BayerRG8, Mono8 or RGB8",
                                   camera.name, camera.pixel_format));
  return *format;
}

std::array<std::uint8_t, 6> mac_from(const config::CameraConfig& camera) {
  std::array<unsigned, 6> bytes{};
  if (std::sscanf(camera.device.c_str(), "%2x:%2x:%2x:%2x:%2x:%2x", &bytes[0], &bytes[1], &bytes[2], &bytes[3],
                  &bytes[4], &bytes[5]) != 6)
    throw InvalidInput(fmt::format("{}: '{}' is not a MAC address like 02:52:54:00:00:01", camera.name, camera.device));
  std::array<std::uint8_t, 6> mac{};
  std::transform(bytes.begin(), bytes.end(), mac.begin(), [](unsigned b) { return static_cast<std::uint8_t>(b); });
  return mac;
}

GigeCameraOptions device_of(const config::CameraConfig& camera, std::size_t number) {
  GigeCameraOptions device = numbered_device(number);
  device.name = camera.name;
  device.format = format_of(camera);
  if (camera.exposure_us) device.exposure_us = *camera.exposure_us;
  if (camera.find_by == "address") device.address = camera.device;
  if (camera.find_by == "serial") device.serial = camera.device;
  if (camera.find_by == "user_name") device.name = camera.device;
  if (camera.find_by == "mac") device.mac = mac_from(camera);
  if (device.address.rfind("127.", 0) != 0)
    throw InvalidInput(fmt::format("{}: the simulator serves cameras on this machine, on 127.0.0.1 and up, not on {}",
                                   camera.name, device.address));
  return device;
}

const capture::CameraModel& model_of(const config::CameraConfig& camera, const std::filesystem::path& file,
                                     const std::vector<capture::CameraModel>& models) {
  const auto model = std::find_if(models.begin(), models.end(), [&](const auto& m) { return m.name == camera.name; });
  if (model == models.end())
    throw InvalidInput(fmt::format("{}: the rig's camera {} is not in it; add it or take it out of the rig",
                                   file.string(), camera.name));
  if ((camera.width && camera.width != model->width) || (camera.height && camera.height != model->height))
    throw InvalidInput(fmt::format("{}: {} is calibrated for {} x {} pixels, the rig asks for {} x {}", file.string(),
                                   camera.name, model->width, model->height, camera.width, camera.height));
  return *model;
}

}  // namespace

SensorOptions ServedStudio::sensor() const {
  SensorOptions options;
  options.seed = performance.seed;
  options.lateral_colour_px = lateral_colour_px;
  for (const auto& device : devices) options.cameras.push_back({.exposure_s = 1e-6 * device.exposure_us});
  return options;
}

void use_realistic_clocks(ServedStudio& studio, std::uint64_t seed) {
  std::uint64_t camera = 0;
  for (auto& device : studio.devices) device.clock = realistic_clock(1000 * seed + camera++);
}

ExposureSettings exposure_settings(const ImageSettings& written) {
  ExposureSettings settings{.exposure_s = 1e-9 * written.exposure_ns, .gain_db = 0.01 * written.gain, .balance = {}};
  for (std::size_t c = 0; c < 3; ++c) settings.balance[c] = 1e-4 * written.balance_ratio[c];
  return settings;
}

std::vector<std::string> narrow_cameras(const std::vector<capture::CameraModel>& cameras) {
  std::vector<std::string> names;
  for (const auto& camera : cameras)
    if (!holds(camera, kStageVolume)) names.push_back(camera.name);
  return names;
}

std::vector<std::string> names_of(const std::vector<capture::CameraModel>& cameras) {
  std::vector<std::string> names;
  for (const auto& camera : cameras) names.push_back(camera.name);
  return names;
}

ServedStudio studio_of_rig(const std::filesystem::path& rig_file) {
  const auto rig = config::load_rig(rig_file);
  if (!rig.calibration)
    throw InvalidInput(
        fmt::format("{}: the simulator must know where the cameras stand; add 'calibration: FILE' "
                    "(rotunda-sim layout writes one)",
                    rig_file.string()));
  const auto models = capture::read_calibration(*rig.calibration);
  ServedStudio studio;
  studio.performance.person = rig.simulator.person;
  studio.performance.act = rig.simulator.act;
  studio.performance.travel = rig.simulator.travel;
  studio.performance.seed = static_cast<std::uint32_t>(rig.simulator.seed);
  studio.backdrop.paint = rig.backdrop == "green" ? ScreenPaint::green : ScreenPaint::blue;
  studio.backdrop.wear = rig.simulator.wear;
  studio.backdrop.unevenness = rig.simulator.unevenness;
  studio.lateral_colour_px = rig.simulator.lateral_colour_px;
  studio.has_realistic_clocks = rig.simulator.clocks == "realistic";
  studio.faults = rig.simulator.faults.value_or("");
  for (const auto& camera : rig.cameras) {
    if (camera.source != "aravis") continue;  // not for GigE Vision
    const auto& model = model_of(camera, *rig.calibration, models);
    auto device = device_of(camera, studio.devices.size());
    device.width = model.width;
    device.height = model.height;
    if (!studio.devices.empty() && device.format != studio.devices.front().format)
      throw InvalidInput(
          fmt::format("{}: all simulated cameras send one pixel format; {} differs", rig_file.string(), camera.name));
    studio.devices.push_back(device);
    studio.cameras.push_back(model);
  }
  if (studio.devices.empty())
    throw InvalidInput(fmt::format("{}: no camera with 'source: aravis' to simulate", rig_file.string()));
  return studio;
}

ServedStudio studio_of_layout(const LayoutOptions& layout, capture::PixelFormat format) {
  ServedStudio studio;
  studio.cameras = camera_layout(layout);
  for (std::size_t i = 0; i < studio.cameras.size(); ++i) {
    auto& device = studio.devices.emplace_back(numbered_device(i));
    device.name = studio.cameras[i].name;
    device.width = studio.cameras[i].width;
    device.height = studio.cameras[i].height;
    device.format = format;
  }
  return studio;
}

}  // namespace rotunda::simulator
