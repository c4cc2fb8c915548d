#include "config/rig_cameras.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace rotunda::config {
namespace {

const Words kFormats{"Mono8",
                     "BayerRG8",
                     "BayerGR8",
                     "BayerGB8",
                     "BayerBG8",
                     "RGB8",
                     "BayerRG12p",
                     "BayerRG10",
                     "BayerGR10",
                     "BayerGB10",
                     "BayerBG10",
                     "BayerRG12",
                     "BayerGR12",
                     "BayerGB12",
                     "BayerBG12",
                     "BayerRG10_CSI2P",
                     "BayerGR10_CSI2P",
                     "BayerGB10_CSI2P",
                     "BayerBG10_CSI2P",
                     "BayerRG12_CSI2P",
                     "BayerGR12_CSI2P",
                     "BayerGB12_CSI2P",
                     "BayerBG12_CSI2P",
                     "YUYV",
                     "UYVY",
                     "NV12",
                     "MJPEG"};
const Words kSources{"aravis", "replay", "v4l2"};
const std::vector<std::string> kFindBy{"address", "serial", "user_name", "mac"};

using NamedValues = std::vector<std::pair<std::string, std::string>>;

// A camera's own win over the same ones of camera_defaults.
void read_named_values(CheckedMap& map, const std::string& key, const std::string& expected, NamedValues& values) {
  const auto node = map.find(key);
  if (!node) return;
  if (!node.IsMap()) return map.wrong(node, key, expected);
  for (const auto& entry : node) {
    if (!entry.first.IsScalar() || !entry.second.IsScalar()) {
      map.wrong(entry.second, key, expected);
      continue;
    }
    const auto name = entry.first.Scalar();
    const auto same =
        std::find_if(values.begin(), values.end(), [&](const auto& value) { return value.first == name; });
    if (same == values.end())
      values.emplace_back(name, entry.second.Scalar());
    else
      same->second = entry.second.Scalar();
  }
}

// `auto_once`, or a ratio for red and for blue.
void read_white_balance(CheckedMap& map, CameraConfig& camera, Problems& problems) {
  const auto node = map.find("white_balance");
  if (!node) return;
  WhiteBalanceConfig balance;
  if (node.IsMap()) {
    CheckedMap ratios(node, map.path_of("white_balance"), problems);
    for (const auto* colour : {"red", "blue"}) ratios.require(colour, "a ratio against green, 0.05 to 20");
    ratios.read<double>("red", balance.red, "a ratio of 0.05 to 20", between(0.05, 20.0));
    ratios.read<double>("blue", balance.blue, "a ratio of 0.05 to 20", between(0.05, 20.0));
    ratios.refuse_unknown_keys();
  } else if (node.IsScalar() && node.Scalar() == "auto_once") {
    balance.auto_once = true;
  } else {
    map.wrong(node, "white_balance", "auto_once, or { red: 1.5, blue: 1.8 }");
  }
  camera.white_balance = balance;
}

void read_camera_settings(CheckedMap& map, CameraConfig& camera, Problems& problems) {
  map.read<std::string>("source", camera.source, one_of(kSources), in(kSources));
  map.read<int>("width", camera.width, "a width of 16 to 16384 pixels", between(16, 16384));
  map.read<int>("height", camera.height, "a height of 16 to 16384 pixels", between(16, 16384));
  map.read<std::string>("pixel_format", camera.pixel_format, one_of(kFormats), in(kFormats));
  map.read<double>("resend_budget_percent", camera.resend_budget_percent, "0 to 100 percent", between(0.0, 100.0));
  map.read<int>("packet_size", camera.packet_size, "0 (automatic) or 576 to 65535 bytes",
                [](int bytes) { return bytes == 0 || (bytes >= 576 && bytes <= 65535); });
  double number = 0.0;
  if (map.find("exposure_us")) {
    map.read<double>("exposure_us", number, "1 to 10000000 microseconds", between(1.0, 1e7));
    camera.exposure_us = number;
  }
  if (map.find("gain_db")) {
    map.read<double>("gain_db", number, "-20 to 60 decibels", between(-20.0, 60.0));
    camera.gain_db = number;
  }
  read_named_values(map, "controls", "control names with a number, true, false or a menu's word each", camera.controls);
  const auto read_offset = [&](const char* key, std::optional<int>& into) {
    int offset = 0;
    if (!map.find(key)) return;
    map.read<int>(key, offset, "0 to 16384 pixels", between(0, 16384));
    into = offset;
  };
  read_offset("offset_x", camera.offset_x);
  read_offset("offset_y", camera.offset_y);
  map.read<std::string>("user_set", camera.user_set, "the name of a user set, such as UserSet1");
  read_white_balance(map, camera, problems);
  read_named_values(map, "features", "GenICam feature names with a number, a word, true or false each",
                    camera.features);
}

// What a kind of source cannot have. camera_defaults may hold it for the cameras of other kinds.
void refuse_what_the_source_lacks(CheckedMap& map, const CameraConfig& camera) {
  if (camera.source == "v4l2") {
    for (const auto* way : {"user_name", "mac"})
      if (const auto node = map.find(way))
        map.wrong(node, way, "address (/dev/video0, /dev/v4l/by-path/...) or serial for a v4l2 camera");
    if (const auto node = map.find("gain_db"))
      map.wrong(node, "gain_db", "no decibels for a v4l2 camera: set its gain under controls, in its own units");
  } else if (const auto node = map.find("controls")) {
    map.wrong(node, "controls", "controls only where source is v4l2");
  }
}

void read_identity(CheckedMap& map, CameraConfig& camera, const YAML::Node& node) {
  const std::string name_rule = "a name of letters, digits, '-' and '_', such as cam00";
  map.require("name", name_rule);
  map.read<std::string>("name", camera.name, name_rule, is_camera_name);
  for (const auto& way : kFindBy) {
    const auto found = map.find(way);
    if (!found) continue;
    if (!camera.find_by.empty()) map.wrong(found, way, "only one of " + fmt::format("{}", fmt::join(kFindBy, ", ")));
    camera.find_by = way;
    map.read<std::string>(way, camera.device, "a word", [](const std::string& word) { return !word.empty(); });
  }
  if (camera.find_by.empty())
    map.wrong(node, "address", fmt::format("how to find the camera: one of {}", fmt::join(kFindBy, ", ")));
}

CameraConfig read_camera(const YAML::Node& node, std::size_t index, const CameraConfig& defaults, Problems& problems) {
  CheckedMap map(node, fmt::format("cameras[{}]", index), problems);
  CameraConfig camera = defaults;
  if (node.IsMap()) read_identity(map, camera, node);
  read_camera_settings(map, camera, problems);
  refuse_what_the_source_lacks(map, camera);
  map.refuse_unknown_keys();
  return camera;
}

void refuse_twins(const std::vector<CameraConfig>& cameras, const YAML::Node& list, Problems& problems) {
  for (std::size_t i = 0; i < cameras.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const auto mark = list[i].Mark();
      const auto tell = [&](const std::string& key, const std::string& value) {
        problems.push_back({mark.line + 1, mark.column + 1, fmt::format("cameras[{}].{}", i, key),
                            fmt::format("\"{}\" is cameras[{}] already; every camera has its own", value, j)});
      };
      if (!cameras[i].name.empty() && cameras[i].name == cameras[j].name) tell("name", cameras[i].name);
      const bool of_one_take = cameras[i].source == "replay" && cameras[j].source == "replay";  // told apart by name
      if (!cameras[i].device.empty() && cameras[i].device == cameras[j].device && !of_one_take)
        tell(cameras[i].find_by, cameras[i].device);
    }
}

}  // namespace

bool is_camera_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 && name[0] != '-' && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

std::vector<CameraConfig> read_cameras(CheckedMap& root, Problems& problems) {
  CameraConfig defaults;
  if (const auto node = root.find("camera_defaults")) {
    CheckedMap map(node, "camera_defaults", problems);
    read_camera_settings(map, defaults, problems);
    map.refuse_unknown_keys();
  }
  root.require("cameras", "a list with one entry a camera");
  const auto list = root.find("cameras");
  if (!list) return {};
  if (!list.IsSequence() || list.size() == 0 || list.size() > 64) {
    root.wrong(list, "cameras", "a list of 1 to 64 cameras");
    return {};
  }
  std::vector<CameraConfig> cameras;
  for (std::size_t i = 0; i < list.size(); ++i) cameras.push_back(read_camera(list[i], i, defaults, problems));
  refuse_twins(cameras, list, problems);
  return cameras;
}

}  // namespace rotunda::config
