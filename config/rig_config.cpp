#include "config/rig_config.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "config/checked_yaml.h"
#include "config/rig_cameras.h"

namespace rotunda::config {
namespace {

namespace fs = std::filesystem;

const Words kTriggerModes{"action", "software", "line", "freerun"};
const Words kBackdrops{"blue", "green"};
const Words kClocks{"ideal", "realistic"};
void read_trigger(CheckedMap& root, TriggerConfig& trigger, Problems& problems) {
  const auto node = root.find("trigger");
  if (!node) return;
  CheckedMap map(node, "trigger", problems);
  map.read<std::string>("mode", trigger.mode, one_of(kTriggerModes), in(kTriggerModes));
  map.read<double>("rate_hz", trigger.rate_hz, "a rate of 0.1 to 1000 Hz", between(0.1, 1000.0));
  map.read<int>("lead_periods", trigger.lead_periods, "0 (at the moment itself) to 100 periods", between(0, 100));
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
  rig.cameras = read_cameras(root, problems);
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
