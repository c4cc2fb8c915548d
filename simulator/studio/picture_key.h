#pragma once
// Everything that determines the pixels of an act's pictures, as text: the key under which they are kept once rendered.
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "capture/frame.h"
#include "simulator/people/performance.h"
#include "simulator/studio/painted_room.h"
#include "simulator/studio/sensor.h"

namespace rotunda::simulator {

struct PictureKey {
  std::string text;    // JSON, for people to read
  std::string digest;  // of it: 32 hexadecimal digits
};

// `performance`: Performance::fingerprint() or fingerprint_of(). The program that runs is part of the key: another
// build renders anew.
PictureKey picture_key(const std::string& performance, const std::vector<capture::CameraModel>& cameras,
                       const SensorOptions& sensor, capture::PixelFormat format, const BackdropOptions& backdrop = {});

// What Performance::fingerprint() stands for without making the performance, which takes seconds; nothing where files
// have a say in it.
std::optional<std::string> fingerprint_of(const PerformanceOptions& options);

}  // namespace rotunda::simulator
