// The text that `rotunda rig init` writes: every key that people set, what it does, in which unit, sensible values.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "config/rig_config.h"

namespace rotunda::config {
namespace {

// Of YAML: whatever the word holds it stays a word.
std::string quoted(const std::string& word) {
  std::string text = "\"";
  for (const char letter : word) {
    const auto byte = static_cast<unsigned char>(letter);
    if (letter == '"' || letter == '\\') text += '\\';
    if (byte < ' ')
      text += fmt::format("\\x{:02x}", byte);
    else
      text += letter;
  }
  return text + "\"";
}

std::string head(const RigConfig& rig) {
  const auto calibration = rig.calibration ? "calibration: " + quoted(rig.calibration->string())
                                           : std::string("# calibration: calibration.yaml");
  return fmt::format(
      "# A rig: its cameras, how they are triggered, where takes go. Only cameras must be here.\n"
      "# Check it, and this machine for it, with: rotundad --rig FILE --check\n"
      "name: {}\n\n"
      "# From this file's folder. Where every camera stands and how its lens draws; each take keeps a copy. Recording\n"
      "# works without, reconstruction does not.\n"
      "{}\n\n",
      quoted(rig.name), calibration);
}

std::string trigger_text(const TriggerConfig& trigger) {
  return fmt::format(
      "trigger:\n"
      "  # action: scheduled GigE Vision commands, all cameras at the same moment (their clocks must follow PTP)\n"
      "  # line: the USB trigger box pulses every camera's Line0\n"
      "  # software: one command after the other, milliseconds apart; freerun: cameras run by themselves\n"
      "  mode: {}\n"
      "  # Frame sets a second, 0.1 to 1000. Ten 720 x 576 cameras at 25 fill a 1 Gbit/s link.\n"
      "  rate_hz: {}\n"
      "  # A scheduled action is sent so many periods ahead, 1 to 100; more for a busy network. 0: at the moment "
      "itself.\n"
      "  lead_periods: {}\n"
      "  # IPv4 address of this machine on the cameras' link.\n"
      "  interface: {}\n\n",
      trigger.mode, trigger.rate_hz, trigger.lead_periods, trigger.interface_address);
}

std::string stage_text(const RigConfig& rig) {
  return fmt::format(
      "# The box in which performers move: metres, world frame (z up, origin on the studio floor). What stands "
      "outside\n"
      "# is not reconstructed; a box that is too large costs time.\n"
      "volume:\n  min: [{}]\n  max: [{}]\n\n"
      "# What the key takes away: blue | green\n"
      "backdrop: {}\n\n",
      fmt::join(rig.volume.min, ", "), fmt::join(rig.volume.max, ", "), rig.backdrop);
}

std::string storage_text(const StorageConfig& storage) {
  return fmt::format(
      "storage:\n"
      "  # Folder of the takes; a relative one counts from where the daemon is started. rotundad --takes wins.\n"
      "  takes: {}\n"
      "  # Recording does not start with less free disk than this, megabytes.\n"
      "  reserve_mb: {}\n"
      "  # Frame sets held in memory while the disk is slow, 2 to 10000. 50 sets of ten 720 x 576 cameras are 210 MB.\n"
      "  queue_frame_sets: {}\n\n",
      quoted(storage.takes.string()), storage.reserve_mb, storage.queue_frame_sets);
}

// A setting that the rig does not make stands as a comment, with a value to start from.
template <class T>
std::string setting(const char* key, const T& value, bool is_set) {
  return fmt::format("  {}{}: {}\n", is_set ? "" : "# ", key, value);
}

std::string camera_text(const CameraConfig& common) {
  return fmt::format(
             "# Settings of all cameras; one that a camera has of its own below wins.\n"
             "camera_defaults:\n"
             "  # As the camera names it: Mono8, BayerRG8, BayerRG12p, ...; of video cameras YUYV, UYVY, NV12, MJPEG\n"
             "  pixel_format: {}\n"
             "  # Pixels, 16 to 16384. Without: as the camera has it.\n",
             common.pixel_format) +
         setting("width", common.width > 0 ? common.width : 720, common.width > 0) +
         setting("height", common.height > 0 ? common.height : 576, common.height > 0) +
         "  # Microseconds. A hand at 5 m/s blurs over 25 mm in 5000. Without: as the camera has it.\n" +
         setting("exposure_us", common.exposure_us.value_or(5000.0), common.exposure_us.has_value()) +
         "  # Decibels; as little as the light allows. Without: as the camera has it.\n" +
         setting("gain_db", common.gain_db.value_or(0.0), common.gain_db.has_value()) +
         "  # Bytes with IP and UDP headers; 0: what the link's MTU takes, 8900 at most.\n" +
         setting("packet_size", common.packet_size, common.packet_size > 0) + "\n";
}

std::string camera_entry(const CameraConfig& camera, const CameraConfig& common, const std::string& remark) {
  const auto format = camera.pixel_format == common.pixel_format ? "" : ", pixel_format: " + camera.pixel_format;
  const auto source = camera.source == CameraConfig{}.source ? "" : ", source: " + camera.source;
  return fmt::format("  - {{ name: {}, {}: {}{}{} }}{}\n", camera.name, camera.find_by, quoted(camera.device), source,
                     format, remark.empty() ? "" : "  # " + remark);
}

}  // namespace

std::string rig_file_text(const RigConfig& rig, std::span<const std::string> remarks) {
  const auto common = rig.cameras.empty() ? CameraConfig{} : rig.cameras.front();
  auto text =
      head(rig) + trigger_text(rig.trigger) + stage_text(rig) + storage_text(rig.storage) + camera_text(common) +
      "# In the order that takes keep. Each has a name (its file's in a take) and one way to be found: serial,\n"
      "# address, user_name or mac. Which is which: rotunda cameras identify\n"
      "cameras:\n";
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    text += camera_entry(rig.cameras[i], common, i < remarks.size() ? remarks[i] : "");
  return text;
}

}  // namespace rotunda::config
