#include "capture/source/camera_settings.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kRounding = 1e-3;  // of the value: what cameras' own steps come to

std::optional<double> number_in(const std::string& text) {
  if (text == "true") return 1.0;
  if (text == "false") return 0.0;
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc{} && end == text.data() + text.size()) return number;
  if (text.rfind("0x", 0) != 0) return std::nullopt;
  std::int64_t hex = 0;
  const auto [stop, wrong] = std::from_chars(text.data() + 2, text.data() + text.size(), hex, 16);
  if (wrong != std::errc{} || stop != text.data() + text.size()) return std::nullopt;
  return static_cast<double>(hex);
}

void set(FeatureAccess& camera, const std::string& feature, const std::string& value,
         std::vector<SettingDifference>& differences) {
  camera.write(feature, value);
  if (auto got = camera.read(feature); !is_same_setting(value, got))
    differences.push_back({feature, value, std::move(got)});
}

std::string need(FeatureAccess& camera, const CameraId& name, std::initializer_list<const char*> names,
                 const std::string& cure) {
  auto feature = first_of(camera, names);
  if (feature.empty()) throw DeviceError(name, fmt::format("has no feature {}; {}", *names.begin(), cure));
  return feature;
}

}  // namespace

std::string to_string(const SettingDifference& difference) {
  return fmt::format("{}: asked {}, the camera has {}", difference.feature, difference.asked, difference.got);
}

bool is_same_setting(const std::string& asked, const std::string& got) {
  if (asked == got) return true;
  const auto a = number_in(asked), b = number_in(got);
  return a && b && std::abs(*a - *b) <= kRounding * std::abs(*a);
}

void load_user_set(FeatureAccess& camera, const CameraId& name, const std::string& user_set) {
  const std::string cure = "leave user_set out of the rig file";
  const auto selector = need(camera, name, {"UserSetSelector"}, cure);
  const auto load = need(camera, name, {"UserSetLoad"}, cure);
  camera.write(selector, user_set);
  camera.execute(load);
}

// Ratios are against green, which stays where it is.
std::vector<SettingDifference> set_white_balance(FeatureAccess& camera, const CameraId& name,
                                                 const WhiteBalance& balance) {
  std::vector<SettingDifference> differences;
  const auto automatic = first_of(camera, {"BalanceWhiteAuto"});
  if (balance.auto_once) {
    need(camera, name, {"BalanceWhiteAuto"}, "give white_balance as { red: 1.5, blue: 1.8 }");
    camera.write(automatic, "Once");  // it is Off again, and its ratios stay, once enough pictures have passed
    return differences;
  }
  if (!automatic.empty()) set(camera, automatic, "Off", differences);
  const std::string cure = "leave white_balance out of the rig file";
  const auto selector = need(camera, name, {"BalanceRatioSelector"}, cure);
  const auto ratio = need(camera, name, {"BalanceRatio", "BalanceRatioAbs"}, cure);
  for (const auto& [colour, value] : {std::pair("Red", balance.red), std::pair("Blue", balance.blue)}) {
    camera.write(selector, colour);
    std::vector<SettingDifference> of_colour;
    set(camera, ratio, fmt::format("{}", value), of_colour);
    for (auto& difference : of_colour)
      differences.push_back({fmt::format("{}[{}]", ratio, colour), difference.asked, difference.got});
  }
  return differences;
}

std::vector<SettingDifference> set_features(FeatureAccess& camera, const CameraId& name,
                                            const std::vector<CameraControl>& features) {
  std::vector<SettingDifference> differences;
  for (const auto& [feature, value] : features) {
    if (!camera.has(feature))
      throw DeviceError(name, fmt::format("has no feature {} (or not with the settings before it); see the camera's "
                                          "manual, and features in the rig file",
                                          feature));
    set(camera, feature, value, differences);
  }
  return differences;
}

}  // namespace rotunda::capture
