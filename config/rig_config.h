#pragma once
// The rig file: which cameras, how they are triggered, where takes go. docs/rig-file.md lists every key.
// A struct's defaults are the file's defaults. Lengths in metres, world frame (z up, origin on the studio floor).
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace rotunda::config {

struct WhiteBalanceConfig {
  bool auto_once = false;        // the camera finds its ratios itself when it starts
  double red = 1.0, blue = 1.0;  // against green
};

// How one camera is found and set. `find_by` says which of its names `device` is.
struct CameraConfig {
  std::string name;               // "cam00": letters, digits, '-' and '_'; also its file name in a take
  std::string source = "aravis";  // aravis | v4l2
  std::string find_by;            // address | serial | user_name | mac
  std::string device;
  int width = 0;  // pixels; 0: as the camera has it
  int height = 0;
  std::string pixel_format = "BayerRG8";
  std::optional<double> exposure_us;
  std::optional<double> gain_db;
  std::vector<std::pair<std::string, std::string>> controls;  // v4l2: name and value, in the file's order
  std::optional<int> offset_x, offset_y;                      // of the region on the sensor, pixels
  std::optional<WhiteBalanceConfig> white_balance;
  std::string user_set;                                       // of the camera, loaded first; empty: none
  std::vector<std::pair<std::string, std::string>> features;  // GenICam name and value, in the file's order
  double resend_budget_percent = 25.0;                        // of its packets a camera may be asked for again
  int packet_size = 0;  // bytes with IP and UDP headers; 0: what the link's MTU takes, 8900 at most
};

struct TriggerConfig {
  std::string mode = "action";  // action | software | line | freerun
  double rate_hz = 25.0;
  int lead_periods = 2;                         // an action is sent this many periods ahead; 0: carried out on arrival
  std::string interface_address = "127.0.0.1";  // of the link the cameras hang on
  std::uint32_t device_key = 0x524f5455;
  std::uint32_t group_key = 1;
  std::uint32_t group_mask = 1;
  std::string box;                     // serial number of the trigger box in mode `line`; empty: the only one
  double pulse_width_us = 1000.0;      // of its pulses
  bool ptp = true;                     // cameras that can follow a PTP master do
  double ptp_offset_limit_us = 100.0;  // a camera further from its master is told
  double ptp_wait_s = 12.0;            // for a camera's clock, before it streams
  std::vector<double> line_delays_us;  // of each of its lines after the trigger's moment; missing ones are 0
};

struct VolumeConfig {
  std::array<double, 3> min{-1.5, -1.0, 0.0};
  std::array<double, 3> max{1.5, 1.0, 2.0};
};

struct StorageConfig {
  std::filesystem::path takes = "takes";  // absolute after loading
  double reserve_mb = 2048.0;             // recording does not start with less free than this
  int queue_frame_sets = 50;              // held in memory while the disk is slow
};

struct SimulatorConfig {
  std::string person = "alex";
  std::string act = "walk";
  bool travel = false;  // through the volume instead of on the spot
  std::uint64_t seed = 1;
  double wear = 1.0;                            // of the painted studio: seams, scuffs, tape; 0 none
  double unevenness = 2.0;                      // of the light on it, brightest to darkest
  double lateral_colour_px = 0.25;              // of the lenses, in the picture's corner
  std::string clocks = "ideal";                 // | realistic: the cameras' clocks err
  std::optional<std::filesystem::path> faults;  // what goes wrong; absolute after loading
};

struct RigConfig {
  std::filesystem::path file;
  std::string name;
  std::vector<CameraConfig> cameras;
  TriggerConfig trigger;
  VolumeConfig volume;
  std::string backdrop = "blue";  // blue | green
  StorageConfig storage;
  std::optional<std::filesystem::path> calibration;  // absolute after loading
  std::optional<std::filesystem::path> api_socket;
  SimulatorConfig simulator;
};

// Reads and checks a rig file. Throws ConfigError with every mistake at once, each with line, column, key, what was
// expected and, for an unknown key, the nearest known one; std::system_error if the file cannot be read.
RigConfig load_rig(const std::filesystem::path& file);

// The text of a rig file that load_rig accepts, for `rotunda rig init`: what each key does stands beside it. `remarks`,
// in the cameras' order, become comments: one line each.
std::string rig_file_text(const RigConfig& rig, std::span<const std::string> remarks = {});
// Letters, digits, '-' and '_', not first '-', at most 64.
bool is_camera_name(const std::string& name);

}  // namespace rotunda::config
