#include "capture/source/aravis_features.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace rotunda::capture {
namespace {

std::int64_t integer_in(const CameraId& camera, const std::string& name, const std::string& text) {
  std::int64_t number = 0;
  const bool hex = text.rfind("0x", 0) == 0;
  const char* begin = text.data() + (hex ? 2 : 0);
  const char* end = text.data() + text.size();
  if (const auto [stop, error] = std::from_chars(begin, end, number, hex ? 16 : 10);
      error == std::errc{} && stop == end)
    return number;
  throw DeviceError(camera, fmt::format("{} takes a whole number, not \"{}\"", name, text));
}

double number_in(const CameraId& camera, const std::string& name, const std::string& text) {
  double number = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc{} && stop == text.data() + text.size() && std::isfinite(number)) return number;
  throw DeviceError(camera, fmt::format("{} takes a number, not \"{}\"", name, text));
}

bool truth_in(const CameraId& camera, const std::string& name, const std::string& text) {
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  throw DeviceError(camera, fmt::format("{} takes true or false, not \"{}\"", name, text));
}

}  // namespace

bool AravisFeatures::has(const std::string& name) {
  ErrorCatcher error;
  const bool there = arv_device_is_feature_available(device_, name.c_str(), error.out()) && !error;
  gone_ = error.is(ARV_DEVICE_ERROR_TIMEOUT);
  return there;
}

ArvGcNode* AravisFeatures::node(const std::string& name) {
  ArvGcNode* node = arv_device_get_feature(device_, name.c_str());
  if (!ARV_IS_GC_FEATURE_NODE(node))
    throw DeviceError(name_,
                      fmt::format("has no feature {}; the camera's manual, or arv-tool-0.8 features, lists those "
                                  "it has",
                                  name));
  return node;
}

void AravisFeatures::check(const ErrorCatcher& error, const std::string& doing) {
  gone_ = error.is(ARV_DEVICE_ERROR_TIMEOUT) || error.is(ARV_DEVICE_ERROR_NOT_CONNECTED);
  if (error) throw DeviceError(name_, fmt::format("{}: {}", doing, error.message()));
}

// An enumeration is an integer too, as Aravis sees it: it comes first.
std::string AravisFeatures::read(const std::string& name) {
  ArvGcNode* found = node(name);
  ErrorCatcher error;
  std::string value;
  if (ARV_IS_GC_ENUMERATION(found))
    value = or_empty(arv_gc_enumeration_get_string_value(ARV_GC_ENUMERATION(found), error.out()));
  else if (ARV_IS_GC_BOOLEAN(found))
    value = arv_gc_boolean_get_value(ARV_GC_BOOLEAN(found), error.out()) ? "true" : "false";
  else if (ARV_IS_GC_FLOAT(found))
    value = fmt::format("{}", arv_gc_float_get_value(ARV_GC_FLOAT(found), error.out()));
  else if (ARV_IS_GC_INTEGER(found))
    value = fmt::format("{}", arv_gc_integer_get_value(ARV_GC_INTEGER(found), error.out()));
  else if (ARV_IS_GC_STRING(found))
    value = or_empty(arv_gc_string_get_value(ARV_GC_STRING(found), error.out()));
  else
    throw DeviceError(name_, name + " has no value to read");
  check(error, "reading " + name);
  return value;
}

void AravisFeatures::write(const std::string& name, const std::string& value) {
  ArvGcNode* found = node(name);
  ErrorCatcher error;
  if (ARV_IS_GC_ENUMERATION(found))
    arv_gc_enumeration_set_string_value(ARV_GC_ENUMERATION(found), value.c_str(), error.out());
  else if (ARV_IS_GC_BOOLEAN(found))
    arv_gc_boolean_set_value(ARV_GC_BOOLEAN(found), truth_in(name_, name, value), error.out());
  else if (ARV_IS_GC_FLOAT(found))
    arv_gc_float_set_value(ARV_GC_FLOAT(found), number_in(name_, name, value), error.out());
  else if (ARV_IS_GC_INTEGER(found))
    arv_gc_integer_set_value(ARV_GC_INTEGER(found), integer_in(name_, name, value), error.out());
  else if (ARV_IS_GC_STRING(found))
    arv_gc_string_set_value(ARV_GC_STRING(found), value.c_str(), error.out());
  else
    throw DeviceError(name_, name + " is no setting");
  check(error, fmt::format("setting {} to {}", name, value));
}

void AravisFeatures::execute(const std::string& name) {
  ArvGcNode* found = node(name);
  if (!ARV_IS_GC_COMMAND(found)) throw DeviceError(name_, name + " is no command");
  ErrorCatcher error;
  arv_gc_command_execute(ARV_GC_COMMAND(found), error.out());
  check(error, name);
}

}  // namespace rotunda::capture
