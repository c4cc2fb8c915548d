#pragma once
// What a simulated GigE Vision camera is: fixed while its studio lives.
#include <array>
#include <cstdint>
#include <string>

#include "capture/frame.h"
#include "simulator/gige/camera_clock.h"

namespace rotunda::simulator {

struct GigeCameraOptions {
  std::string name = "cam00";                                  // user name, at most 15 characters
  std::string serial = "RS0000";                               // at most 15 characters
  std::string address = "127.0.0.1";                           // of this machine; all of 127/8 is
  std::array<std::uint8_t, 6> mac{0x02, 0x52, 0x54, 0, 0, 1};  // locally administered
  int width = 720, height = 576;                               // pixels
  capture::PixelFormat format = capture::PixelFormat::bayer_rg8;
  double exposure_us = 5000.0;  // at power-up; clients may change it
  CameraClockOptions clock;
};

}  // namespace rotunda::simulator
