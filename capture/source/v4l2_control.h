#pragma once
// The controls of a V4L2 camera, found and set by name, each read back. Names compare by letters and digits alone:
// "White Balance, Automatic" of the driver, v4l2-ctl's white_balance_automatic and White-Balance Automatic are one.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "capture/source/source.h"
#include "capture/source/v4l2_system.h"

namespace rotunda::capture {

struct V4l2Control {
  struct Choice {
    std::int64_t value = 0;
    std::string name;
  };
  std::uint32_t id = 0;
  std::string name;         // as v4l2-ctl writes it
  std::uint32_t type = 0;   // V4L2_CTRL_TYPE_...
  std::uint32_t flags = 0;  // V4L2_CTRL_FLAG_...
  std::int64_t minimum = 0;
  std::int64_t maximum = 0;
  std::vector<Choice> choices;  // of menus
};

std::string control_name(std::string_view driver_name);  // "White Balance, Automatic" -> "white_balance_automatic"

// Those that hold one number; none from a driver that knows no controls.
std::vector<V4l2Control> list_controls(const V4l2Node& node);
std::optional<V4l2Control> find_control(const V4l2Node& node, std::uint32_t id);

// Nothing if the driver does not tell; the write's errno is thrown as DeviceError with what the control takes.
std::optional<std::int64_t> read_control(const V4l2Node& node, const V4l2Control& control);
void write_control(const V4l2Node& node, const CameraId& camera, const V4l2Control& control, std::int64_t value);

// Writes settings.controls in order. Returns what differs from what was asked, in words; throws DeviceError for a
// control the camera has not (naming the nearest), a word its menu has not, or a value it refuses.
std::vector<std::string> apply_controls(const V4l2Node& node, const SourceSettings& settings);

// settings.exposure_us by the camera class' manual exposure (steps of 100 us), then whatever exposure is in force;
// nothing if the camera sets it itself or does not tell. Adds to `warnings` what differs.
std::optional<std::chrono::nanoseconds> apply_exposure(const V4l2Node& node, const SourceSettings& settings,
                                                       std::vector<std::string>& warnings);

}  // namespace rotunda::capture
