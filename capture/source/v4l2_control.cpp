#include "capture/source/v4l2_control.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr int kMostControls = 1024;  // a driver that never comes to an end is given up here
constexpr std::int64_t kMostChoices = 256;
constexpr double kExposureUnitUs = 100.0;  // of V4L2_CID_EXPOSURE_ABSOLUTE

bool holds_a_number(std::uint32_t type) {
  switch (type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_BOOLEAN:
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_BUTTON:
    case V4L2_CTRL_TYPE_INTEGER64:
    case V4L2_CTRL_TYPE_BITMASK:
    case V4L2_CTRL_TYPE_INTEGER_MENU:
      return true;
    default:
      return false;
  }
}

std::string bounded_text(const void* text, std::size_t size) {
  const auto* begin = static_cast<const char*>(text);
  return {begin, strnlen(begin, size)};
}

void read_choices(const V4l2Node& node, V4l2Control& control) {
  if (control.type != V4L2_CTRL_TYPE_MENU && control.type != V4L2_CTRL_TYPE_INTEGER_MENU) return;
  const std::int64_t last = std::min(control.maximum, control.minimum + kMostChoices);
  for (std::int64_t index = std::max<std::int64_t>(control.minimum, 0); index <= last; ++index) {
    v4l2_querymenu item{};
    item.id = control.id;
    item.index = static_cast<std::uint32_t>(index);
    if (!node.ask(VIDIOC_QUERYMENU, item)) continue;  // menus may have gaps
    control.choices.push_back({index, control.type == V4L2_CTRL_TYPE_MENU ? bounded_text(item.name, sizeof item.name)
                                                                          : std::to_string(item.value)});
  }
}

V4l2Control control_from(const V4l2Node& node, const v4l2_query_ext_ctrl& told) {
  V4l2Control control{.id = told.id,
                      .name = control_name(bounded_text(told.name, sizeof told.name)),
                      .type = told.type,
                      .flags = told.flags,
                      .minimum = told.minimum,
                      .maximum = static_cast<std::int64_t>(told.maximum),
                      .choices = {}};
  read_choices(node, control);
  return control;
}

// Older drivers know the older call alone.
bool query(const V4l2Node& node, v4l2_query_ext_ctrl& told) {
  if (node.ask(VIDIOC_QUERY_EXT_CTRL, told)) return true;
  if (errno != ENOTTY) return false;
  v4l2_queryctrl old{};
  old.id = told.id;
  if (!node.ask(VIDIOC_QUERYCTRL, old)) return false;
  told = {};
  told.id = old.id;
  told.type = old.type;
  std::memcpy(told.name, old.name, sizeof old.name);
  told.minimum = old.minimum;
  told.maximum = old.maximum;
  told.flags = old.flags;
  return true;
}

std::string in_words(const V4l2Control& control, std::int64_t value) {
  for (const auto& choice : control.choices)
    if (choice.value == value) return choice.name;
  if (control.type == V4L2_CTRL_TYPE_BOOLEAN) return value != 0 ? "true" : "false";
  return std::to_string(value);
}

std::string what_it_takes(const V4l2Control& control) {
  if (control.type == V4L2_CTRL_TYPE_BOOLEAN) return "true or false";
  if (control.choices.empty()) return fmt::format("{} to {}", control.minimum, control.maximum);
  std::vector<std::string> names;
  for (const auto& choice : control.choices) names.push_back(choice.name);
  return "one of " + fmt::format("{}", fmt::join(names, ", "));
}

std::optional<std::int64_t> number_in(std::string_view text) {
  std::int64_t number = 0;
  const int base = text.substr(0, 2) == "0x" ? 16 : 10;
  if (base == 16) text.remove_prefix(2);
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number, base);
  const bool whole = read.ec == std::errc{} && read.ptr == text.data() + text.size();
  return whole ? std::optional(number) : std::nullopt;
}

// A menu's word, true or false, or a number.
std::optional<std::int64_t> value_in(const V4l2Control& control, const std::string& text) {
  for (const auto& choice : control.choices)
    if (control_name(choice.name) == control_name(text)) return choice.value;
  if (control.type == V4L2_CTRL_TYPE_BOOLEAN || control.type == V4L2_CTRL_TYPE_BUTTON) {
    if (text == "true") return 1;
    if (text == "false") return 0;
  }
  return number_in(text);
}

std::string known_names(const std::vector<V4l2Control>& controls) {
  if (controls.empty()) return "it has none";
  std::vector<std::string> names;
  for (const auto& control : controls) names.push_back(control.name);
  return "it has " + fmt::format("{}", fmt::join(names, ", "));
}

std::string apply(const V4l2Node& node, const SourceSettings& settings, const std::vector<V4l2Control>& controls,
                  const CameraControl& wanted) {
  const auto control = std::find_if(controls.begin(), controls.end(),
                                    [&](const auto& candidate) { return candidate.name == control_name(wanted.name); });
  if (control == controls.end())
    throw DeviceError(settings.camera,
                      fmt::format("{} has no control {}; {}", settings.device, wanted.name, known_names(controls)));
  const auto value = value_in(*control, wanted.value);
  if (!value)
    throw DeviceError(settings.camera, fmt::format("control {} takes {}, not \"{}\"", control->name,
                                                   what_it_takes(*control), wanted.value));
  write_control(node, settings.camera, *control, *value);
  if (control->type == V4L2_CTRL_TYPE_BUTTON) return "";
  const auto answer = read_control(node, *control);
  if (!answer || *answer == *value) return "";
  return fmt::format("control {} is {} where {} was asked (it takes {})", control->name, in_words(*control, *answer),
                     in_words(*control, *value), what_it_takes(*control));
}

bool is_manual(std::int64_t mode) {  // the exposure time stays as set
  return mode == V4L2_EXPOSURE_MANUAL || mode == V4L2_EXPOSURE_SHUTTER_PRIORITY;
}

// Some cameras offer one of the two only.
void set_manual(const V4l2Node& node, const SourceSettings& settings, const V4l2Control& mode) {
  const auto offers = [&](std::int64_t value) {
    return std::any_of(mode.choices.begin(), mode.choices.end(), [&](const auto& c) { return c.value == value; });
  };
  write_control(node, settings.camera, mode,
                offers(V4L2_EXPOSURE_MANUAL) ? V4L2_EXPOSURE_MANUAL : V4L2_EXPOSURE_SHUTTER_PRIORITY);
}

}  // namespace

std::string control_name(std::string_view driver_name) {
  std::string name;
  for (const char letter : driver_name) {
    const auto byte = static_cast<unsigned char>(letter);
    if (std::isalnum(byte) != 0)
      name += static_cast<char>(std::tolower(byte));
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

std::vector<V4l2Control> list_controls(const V4l2Node& node) {
  std::vector<V4l2Control> controls;
  v4l2_query_ext_ctrl told{};
  told.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  for (int i = 0; i < kMostControls && query(node, told); ++i) {
    if (holds_a_number(told.type) && (told.flags & V4L2_CTRL_FLAG_DISABLED) == 0)
      controls.push_back(control_from(node, told));
    const std::uint32_t next = told.id | V4L2_CTRL_FLAG_NEXT_CTRL;
    told = {};
    told.id = next;
  }
  return controls;
}

std::optional<V4l2Control> find_control(const V4l2Node& node, std::uint32_t id) {
  v4l2_query_ext_ctrl told{};
  told.id = id;
  if (!query(node, told) || (told.flags & V4L2_CTRL_FLAG_DISABLED) != 0) return std::nullopt;
  return control_from(node, told);
}

std::optional<std::int64_t> read_control(const V4l2Node& node, const V4l2Control& control) {
  v4l2_ext_control value{};
  value.id = control.id;
  v4l2_ext_controls list{};
  list.which = V4L2_CTRL_WHICH_CUR_VAL;
  list.count = 1;
  list.controls = &value;
  if (node.ask(VIDIOC_G_EXT_CTRLS, list)) return control.type == V4L2_CTRL_TYPE_INTEGER64 ? value.value64 : value.value;
  v4l2_control old{.id = control.id, .value = 0};
  if (errno == ENOTTY && node.ask(VIDIOC_G_CTRL, old)) return old.value;
  return std::nullopt;
}

void write_control(const V4l2Node& node, const CameraId& camera, const V4l2Control& control, std::int64_t wanted) {
  v4l2_ext_control value{};
  value.id = control.id;
  if (control.type == V4L2_CTRL_TYPE_INTEGER64)
    value.value64 = wanted;
  else
    value.value = static_cast<std::int32_t>(std::clamp<std::int64_t>(wanted, INT32_MIN, INT32_MAX));
  v4l2_ext_controls list{};
  list.which = V4L2_CTRL_WHICH_CUR_VAL;
  list.count = 1;
  list.controls = &value;
  if (node.ask(VIDIOC_S_EXT_CTRLS, list)) return;
  v4l2_control old{.id = control.id, .value = value.value};
  if (errno == ENOTTY && node.ask(VIDIOC_S_CTRL, old)) return;
  const int error = errno;
  throw DeviceError(camera, fmt::format("control {} is not taken ({}); it takes {}{}", control.name,
                                        std::strerror(error), what_it_takes(control),
                                        error == EACCES || error == EBUSY
                                            ? ", but is read-only or held by an automatic mode now: set that first"
                                            : ""));
}

std::vector<std::string> apply_controls(const V4l2Node& node, const SourceSettings& settings) {
  std::vector<std::string> differences;
  if (settings.controls.empty()) return differences;
  const auto controls = list_controls(node);
  for (const auto& wanted : settings.controls)
    if (auto difference = apply(node, settings, controls, wanted); !difference.empty())
      differences.push_back(std::move(difference));
  return differences;
}

std::optional<std::chrono::nanoseconds> apply_exposure(const V4l2Node& node, const SourceSettings& settings,
                                                       std::vector<std::string>& warnings) {
  const auto mode = find_control(node, V4L2_CID_EXPOSURE_AUTO);
  const auto time = find_control(node, V4L2_CID_EXPOSURE_ABSOLUTE);
  if (settings.exposure_us && !time)
    throw DeviceError(settings.camera,
                      fmt::format("{} has no exposure in microseconds; take exposure_us out and set its own control "
                                  "under controls ({})",
                                  settings.device, known_names(list_controls(node))));
  if (!time) return std::nullopt;
  if (settings.exposure_us) {
    if (mode) set_manual(node, settings, *mode);
    write_control(node, settings.camera, *time, std::llround(*settings.exposure_us / kExposureUnitUs));
  }
  const auto automatic = mode ? read_control(node, *mode) : std::nullopt;
  const auto units = read_control(node, *time);
  if (!units || (automatic && !is_manual(*automatic))) return std::nullopt;
  const double exposure_us = static_cast<double>(*units) * kExposureUnitUs;
  if (settings.exposure_us && std::abs(exposure_us - *settings.exposure_us) >= 1.0)
    warnings.push_back(fmt::format("exposure is {} us where {} was asked (it counts in {} us)", exposure_us,
                                   *settings.exposure_us, kExposureUnitUs));
  return std::chrono::nanoseconds(std::llround(exposure_us * 1e3));
}

}  // namespace rotunda::capture
