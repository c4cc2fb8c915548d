#pragma once
// Which cameras the simulated studio serves, and where: from a rig file, or by number alone.
#include <filesystem>
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "simulator/gige/camera_options.h"
#include "simulator/gige/device_registers.h"
#include "simulator/people/performance.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/painted_room.h"
#include "simulator/studio/re_exposure.h"
#include "simulator/studio/sensor.h"

namespace rotunda::simulator {

struct ServedStudio {
  std::vector<GigeCameraOptions> devices;     // one a camera
  std::vector<capture::CameraModel> cameras;  // the same order
  PerformanceOptions performance;
  BackdropOptions backdrop;
  double lateral_colour_px = SensorOptions{}.lateral_colour_px;
  bool has_realistic_clocks = false;
  std::filesystem::path faults;  // a script; none if empty
  SensorOptions sensor() const;  // the devices' exposures, the performance's seed
};
// Each camera gets a clock that errs like a real one's.
void use_realistic_clocks(ServedStudio& studio, std::uint64_t seed);

// As registers hold them, in physical units.
ExposureSettings exposure_settings(const ImageSettings& written);

// Those whose pictures do not hold the whole stage of 3 x 2 x 2 m, which performers who travel go through.
std::vector<std::string> narrow_cameras(const std::vector<capture::CameraModel>& cameras);
std::vector<std::string> names_of(const std::vector<capture::CameraModel>& cameras);

// The cameras of a rig file where its calibration says they stand. Throws ConfigError for a bad file and InvalidInput
// for one that does not describe GigE Vision cameras on this machine: no calibration, a camera missing from it or of
// another size, an address that is not of 127.0.0.0/8, different pixel formats.
ServedStudio studio_of_rig(const std::filesystem::path& rig_file);

// camera_layout's cameras on 127.0.0.1 upwards.
ServedStudio studio_of_layout(const LayoutOptions& layout,
                              capture::PixelFormat format = capture::PixelFormat::bayer_rg8);

}  // namespace rotunda::simulator
