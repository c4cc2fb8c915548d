#include "config/rig_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "config/checked_yaml.h"

namespace rotunda::config {
namespace {

namespace fs = std::filesystem;
using Words = std::set<std::string>;

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
const Words kTriggerModes{"action", "software", "line", "freerun"};
const Words kBackdrops{"blue", "green"};
const Words kClocks{"ideal", "realistic"};
const Words kSources{"aravis", "replay", "v4l2"};
const std::vector<std::string> kFindBy{"address", "serial", "user_name", "mac"};

std::string one_of(const Words& words) {
  return fmt::format("one of {}", fmt::join(words, ", "));
}

std::function<bool(const std::string&)> in(const Words& words) {
  return [&words](const std::string& word) { return words.count(word) != 0; };
}

template <class T>
std::function<bool(const T&)> between(T low, T high) {
  return [low, high](const T& value) { return value >= low && value <= high; };
}

// A camera's own win over the same ones of camera_defaults.
void read_controls(CheckedMap& map, CameraConfig& camera) {
  const std::string expected = "control names with a number, true, false or a menu's word each";
  const auto node = map.find("controls");
  if (!node) return;
  if (!node.IsMap()) return map.wrong(node, "controls", expected);
  for (const auto& entry : node) {
    if (!entry.first.IsScalar() || !entry.second.IsScalar()) {
      map.wrong(entry.second, "controls", expected);
      continue;
    }
    const auto name = entry.first.Scalar();
    const auto same = std::find_if(camera.controls.begin(), camera.controls.end(),
                                   [&](const auto& control) { return control.first == name; });
    if (same == camera.controls.end())
      camera.controls.emplace_back(name, entry.second.Scalar());
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

// A camera's own win over the same ones of camera_defaults.
void read_features(CheckedMap& map, CameraConfig& camera) {
  const std::string expected = "GenICam feature names with a number, a word, true or false each";
  const auto node = map.find("features");
  if (!node) return;
  if (!node.IsMap()) return map.wrong(node, "features", expected);
  for (const auto& entry : node) {
    if (!entry.first.IsScalar() || !entry.second.IsScalar()) {
      map.wrong(entry.second, "features", expected);
      continue;
    }
    const auto name = entry.first.Scalar();
    const auto same = std::find_if(camera.features.begin(), camera.features.end(),
                                   [&](const auto& feature) { return feature.first == name; });
    if (same == camera.features.end())
      camera.features.emplace_back(name, entry.second.Scalar());
    else
      same->second = entry.second.Scalar();
  }
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
  read_controls(map, camera);
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
  read_features(map, camera);
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
      if (!cameras[i].device.empty() && cameras[i].device == cameras[j].device)
        tell(cameras[i].find_by, cameras[i].device);
    }
}

void read_cameras(CheckedMap& root, RigConfig& rig, Problems& problems) {
  CameraConfig defaults;
  if (const auto node = root.find("camera_defaults")) {
    CheckedMap map(node, "camera_defaults", problems);
    read_camera_settings(map, defaults, problems);
    map.refuse_unknown_keys();
  }
  root.require("cameras", "a list with one entry a camera");
  const auto list = root.find("cameras");
  if (!list) return;
  if (!list.IsSequence() || list.size() == 0 || list.size() > 64) {
    root.wrong(list, "cameras", "a list of 1 to 64 cameras");
    return;
  }
  for (std::size_t i = 0; i < list.size(); ++i) rig.cameras.push_back(read_camera(list[i], i, defaults, problems));
  refuse_twins(rig.cameras, list, problems);
}

void read_trigger(CheckedMap& root, TriggerConfig& trigger, Problems& problems) {
  const auto node = root.find("trigger");
  if (!node) return;
  CheckedMap map(node, "trigger", problems);
  map.read<std::string>("mode", trigger.mode, one_of(kTriggerModes), in(kTriggerModes));
  map.read<double>("rate_hz", trigger.rate_hz, "a rate of 0.1 to 1000 Hz", between(0.1, 1000.0));
  map.read<int>("lead_periods", trigger.lead_periods, "1 to 100 periods", between(1, 100));
  map.read<std::string>("interface", trigger.interface_address,
                        "the IPv4 address of this machine on the cameras' link");
  map.read<std::uint32_t>("device_key", trigger.device_key, "a 32-bit number");
  map.read<std::uint32_t>("group_key", trigger.group_key, "a 32-bit number");
  map.read<std::uint32_t>("group_mask", trigger.group_mask, "a 32-bit number other than 0",
                          [](std::uint32_t mask) { return mask != 0; });
  map.read<bool>("ptp", trigger.ptp, "true or false");
  map.read<double>("ptp_offset_limit_us", trigger.ptp_offset_limit_us, "0.01 to 1e6 microseconds", between(0.01, 1e6));
  map.read<double>("ptp_wait_s", trigger.ptp_wait_s, "0 to 600 seconds", between(0.0, 600.0));
  map.read<std::string>("box", trigger.box, "a trigger box's serial number");
  map.read<double>("pulse_width_us", trigger.pulse_width_us, "1 to 1e6 microseconds", between(1.0, 1e6));
  map.read<std::vector<double>>(
      "line_delays_us", trigger.line_delays_us, "a list of 1 to 8 delays, 0 to 1e6 microseconds",
      [](const std::vector<double>& delays) {
        return !delays.empty() && delays.size() <= 8 && std::all_of(delays.begin(), delays.end(), between(0.0, 1e6));
      });
  map.refuse_unknown_keys();
}

void read_volume(CheckedMap& root, VolumeConfig& volume, Problems& problems) {
  const auto node = root.find("volume");
  if (!node) return;
  CheckedMap map(node, "volume", problems);
  const auto finite = [](const std::array<double, 3>& corner) {
    return std::all_of(corner.begin(), corner.end(), [](double x) { return std::isfinite(x); });
  };
  map.read<std::array<double, 3>>("min", volume.min, "[x, y, z] in metres", finite);
  map.read<std::array<double, 3>>("max", volume.max, "[x, y, z] in metres", finite);
  map.refuse_unknown_keys();
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (volume.max[axis] <= volume.min[axis]) {
      map.wrong(node, "max", "more than volume.min in x, y and z");
      return;
    }
}

void read_storage(CheckedMap& root, StorageConfig& storage, Problems& problems) {
  const auto node = root.find("storage");
  if (!node) return;
  CheckedMap map(node, "storage", problems);
  std::string takes = storage.takes.string();
  map.read<std::string>("takes", takes, "a folder", [](const std::string& path) { return !path.empty(); });
  storage.takes = takes;
  map.read<double>("reserve_mb", storage.reserve_mb, "0 to 1e9 megabytes", between(0.0, 1e9));
  map.read<int>("queue_frame_sets", storage.queue_frame_sets, "2 to 10000 frame sets", between(2, 10000));
  map.refuse_unknown_keys();
}

void read_simulator(CheckedMap& root, SimulatorConfig& simulator, Problems& problems) {
  const auto node = root.find("simulator");
  if (!node) return;
  CheckedMap map(node, "simulator", problems);
  map.read<std::string>("person", simulator.person, "a person's name");
  map.read<std::string>("act", simulator.act, "an act's name");
  map.read<bool>("travel", simulator.travel, "true or false");
  map.read<std::uint64_t>("seed", simulator.seed, "a number");
  map.read<double>("wear", simulator.wear, "0 to 4", between(0.0, 4.0));
  map.read<double>("unevenness", simulator.unevenness, "1 to 10", between(1.0, 10.0));
  map.read<double>("lateral_colour_px", simulator.lateral_colour_px, "0 to 5 pixels", between(0.0, 5.0));
  map.read<std::string>("clocks", simulator.clocks, one_of(kClocks), in(kClocks));
  std::string faults;
  map.read<std::string>("faults", faults, "the path of a file of faults");
  if (!faults.empty()) simulator.faults = faults;
  map.refuse_unknown_keys();
}

void read_api(CheckedMap& root, RigConfig& rig, Problems& problems) {
  const auto node = root.find("api");
  if (!node) return;
  CheckedMap map(node, "api", problems);
  std::string socket;
  map.read<std::string>("socket", socket, "the path of a Unix socket (107 bytes at most)",
                        [](const std::string& path) { return !path.empty() && path.size() <= 107; });
  if (!socket.empty()) rig.api_socket = socket;
  map.refuse_unknown_keys();
}

void read_rig(const YAML::Node& node, RigConfig& rig, Problems& problems) {
  CheckedMap root(node, "", problems);
  rig.name = rig.file.stem().string();
  root.read<std::string>("name", rig.name, "the rig's name");
  read_cameras(root, rig, problems);
  read_trigger(root, rig.trigger, problems);
  read_volume(root, rig.volume, problems);
  root.read<std::string>("backdrop", rig.backdrop, one_of(kBackdrops), in(kBackdrops));
  read_storage(root, rig.storage, problems);
  read_api(root, rig, problems);
  read_simulator(root, rig.simulator, problems);
  std::string calibration;
  root.read<std::string>("calibration", calibration, "the path of a calibration file");
  if (!calibration.empty()) rig.calibration = calibration;
  root.refuse_unknown_keys();
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::system_error(errno, std::generic_category(), "cannot read the rig file " + file.string());
  return {std::istreambuf_iterator<char>(stream), {}};
}

YAML::Node parse(const fs::path& file) {
  try {
    return YAML::Load(read_text(file));
  } catch (const YAML::Exception& error) {
    throw ConfigError(file, {{error.mark.line + 1, error.mark.column + 1, "", "is not YAML: " + error.msg}});
  }
}

}  // namespace

bool is_camera_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 && name[0] != '-' && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

RigConfig load_rig(const fs::path& file) {
  RigConfig rig;
  rig.file = fs::absolute(file);
  Problems problems;
  read_rig(parse(file), rig, problems);
  const auto place = [](const ConfigProblem& problem) { return std::pair(problem.line, problem.column); };
  std::stable_sort(problems.begin(), problems.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  if (!problems.empty()) throw ConfigError(file, std::move(problems));
  const auto beside_rig_file = [&](const fs::path& path) {
    return fs::weakly_canonical(rig.file.parent_path() / path);
  };
  if (rig.calibration) rig.calibration = beside_rig_file(*rig.calibration);
  if (rig.simulator.faults) rig.simulator.faults = beside_rig_file(*rig.simulator.faults);
  if (rig.storage.takes.is_relative()) rig.storage.takes = fs::absolute(rig.storage.takes);
  return rig;
}

}  // namespace rotunda::config
