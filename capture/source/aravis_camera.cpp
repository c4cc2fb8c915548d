#include "capture/source/aravis_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/source/aravis_features.h"
#include "capture/source/camera_settings.h"
#include "capture/source/stream_socket.h"

namespace rotunda::capture {

namespace {

constexpr int jumbo_packet = 8900;         // fits a 9000-byte MTU, and is the quickest on loopback
constexpr int packet_socket_below = 4000;  // larger packets gain nothing from a packet socket's batches
constexpr int default_mtu = 1500;

[[noreturn]] void fail(const SourceSettings& settings, const std::string& doing, const ErrorCatcher& error) {
  if (error.is(ARV_DEVICE_ERROR_NOT_CONTROLLER) || error.is(ARV_DEVICE_ERROR_PROTOCOL_ERROR_ACCESS_DENIED))
    throw DeviceError(settings.camera, fmt::format("{} is controlled by another program ({}: {}); close that first",
                                                   settings.device, doing, error.message()));
  if (error.is(ARV_DEVICE_ERROR_TIMEOUT) || error.is(ARV_DEVICE_ERROR_NOT_CONNECTED))
    throw CameraGone(settings.camera,
                     fmt::format("{} no longer answers ({}); check its cable and power", settings.device, doing));
  throw DeviceError(settings.camera, fmt::format("{}: {}: {}", settings.device, doing, error.message()));
}

// Calls an Aravis function that takes a GError** last; throws what it reports.
template <class Call>
auto ask(const SourceSettings& settings, const std::string& doing, Call call) {
  ErrorCatcher error;
  if constexpr (std::is_void_v<decltype(call(error.out()))>) {
    call(error.out());
    if (error) fail(settings, doing, error);
  } else {
    auto answer = call(error.out());
    if (error) fail(settings, doing, error);
    return answer;
  }
}

bool has_feature(ArvCamera* camera, const char* name) {
  ErrorCatcher error;
  return arv_camera_is_feature_available(camera, name, error.out()) && !error;
}

void require_feature(ArvCamera* camera, const SourceSettings& settings, const char* name, const char* cure) {
  if (!has_feature(camera, name))
    throw DeviceError(settings.camera, fmt::format("{} has no feature {}; {}", settings.device, name, cure));
}

std::string known_formats(ArvCamera* camera) {
  ErrorCatcher error;
  guint count = 0;
  const std::unique_ptr<const char*, GFree> names(
      arv_camera_dup_available_pixel_formats_as_strings(camera, &count, error.out()));
  return names ? fmt::format("{}", fmt::join(names.get(), names.get() + count, ", ")) : "none it would tell";
}

PixelFormat set_pixel_format(ArvCamera* camera, const SourceSettings& settings) {
  const std::string wanted(to_string(settings.format));
  ErrorCatcher error;
  arv_camera_set_pixel_format_from_string(camera, wanted.c_str(), error.out());
  const std::string found = or_empty(arv_camera_get_pixel_format_as_string(camera, nullptr));
  if (error || found != wanted)
    throw DeviceError(settings.camera,
                      fmt::format("{} does not send {} (it stays at {}{}); set pixel_format to one of: {}",
                                  settings.device, wanted, found.empty() ? "an unknown format" : found,
                                  error ? ": " + error.message() : "", known_formats(camera)));
  return settings.format;
}

struct Region {
  int x = 0, y = 0, width = 0, height = 0;
};

Region read_region(ArvCamera* camera, const SourceSettings& settings) {
  Region region;
  ask(settings, "reading the image size",
      [&](GError** e) { arv_camera_get_region(camera, &region.x, &region.y, &region.width, &region.height, e); });
  return region;
}

// Writes only what differs: some cameras have fixed offsets or sizes and refuse even the value they have.
void set_size(ArvCamera* camera, const SourceSettings& settings, SourceDescription& description) {
  Region region = read_region(camera, settings);
  const int width = settings.width > 0 ? settings.width : region.width;
  const int height = settings.height > 0 ? settings.height : region.height;
  ErrorCatcher refused;
  if (region.width != width || region.height != height) {
    const int keep = -1;
    arv_camera_set_region(camera, region.x == 0 ? keep : 0, region.y == 0 ? keep : 0, width, height, refused.out());
    region = read_region(camera, settings);
  }
  if (region.width != width || region.height != height)
    throw DeviceError(settings.camera,
                      fmt::format("{} does not send {} x {} pixels but {} x {}{}; set width and height to what it can, "
                                  "or to 0 to take it as it is",
                                  settings.device, width, height, region.width, region.height,
                                  refused ? " (" + refused.message() + ")" : ""));
  description.width = width;
  description.height = height;
}

// Where the region lies; a camera may have it in steps of its own, which is told.
void set_offset(ArvCamera* camera, const SourceSettings& settings, SourceDescription& description) {
  AravisFeatures features(camera, settings.camera);
  std::vector<CameraControl> offsets;
  if (settings.offset_x) offsets.push_back({"OffsetX", std::to_string(*settings.offset_x)});
  if (settings.offset_y) offsets.push_back({"OffsetY", std::to_string(*settings.offset_y)});
  for (const auto& difference : set_features(features, settings.camera, offsets))
    description.warnings.push_back(to_string(difference));
}

// A value the camera rounds to its own steps is fine, and told; one it clamps is not.
void check_taken(const SourceSettings& settings, const char* what, double wanted, double found, const char* unit,
                 SourceDescription& description) {
  const SettingDifference difference{what, fmt::format("{} {}", wanted, unit), fmt::format("{} {}", found, unit)};
  if (!is_same_setting(fmt::format("{}", wanted), fmt::format("{}", found)))
    description.warnings.push_back(to_string(difference));
  if (std::abs(found - wanted) > 0.02 * std::abs(wanted) + 0.1)
    throw DeviceError(settings.camera, fmt::format("{} has {} {} {} where {} was asked; choose a value it can take",
                                                   settings.device, what, found, unit, wanted));
}

void set_exposure_and_gain(ArvCamera* camera, const SourceSettings& settings, SourceDescription& description) {
  if (settings.exposure_us) {
    if (has_feature(camera, "ExposureAuto"))
      ask(settings, "ExposureAuto", [&](GError** e) { arv_camera_set_exposure_time_auto(camera, ARV_AUTO_OFF, e); });
    ask(settings, "setting the exposure",
        [&](GError** e) { arv_camera_set_exposure_time(camera, *settings.exposure_us, e); });
  }
  ErrorCatcher untold;
  if (arv_camera_is_exposure_time_available(camera, untold.out()) && !untold) {
    const double us =
        ask(settings, "reading the exposure", [&](GError** e) { return arv_camera_get_exposure_time(camera, e); });
    if (settings.exposure_us) check_taken(settings, "an exposure of", *settings.exposure_us, us, "us", description);
    description.exposure = std::chrono::nanoseconds(std::llround(us * 1e3));
  }
  if (settings.gain_db) {
    if (has_feature(camera, "GainAuto"))
      ask(settings, "GainAuto", [&](GError** e) { arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, e); });
    ask(settings, "setting the gain", [&](GError** e) { arv_camera_set_gain(camera, *settings.gain_db, e); });
    const double db = ask(settings, "reading the gain", [&](GError** e) { return arv_camera_get_gain(camera, e); });
    check_taken(settings, "a gain of", *settings.gain_db, db, "dB", description);
  }
}

void set_action_keys(ArvCamera* camera, const SourceSettings& settings) {
  const auto set = [&](const char* name, std::int64_t value) {
    require_feature(camera, settings, name, "it knows no action commands: set trigger.mode to software");
    ask(settings, name, [&](GError** e) { arv_camera_set_integer(camera, name, value, e); });
  };
  ErrorCatcher error;  // cameras with one action signal may have no selector, or count from 0
  std::int64_t first = 1, last = 1;
  arv_camera_get_integer_bounds(camera, "ActionSelector", &first, &last, error.out());
  if (!error) set("ActionSelector", std::clamp<std::int64_t>(1, first, last));
  set("ActionDeviceKey", settings.device_key);
  set("ActionGroupKey", settings.group_key);
  set("ActionGroupMask", settings.group_mask);
}

void set_trigger(ArvCamera* camera, const SourceSettings& settings) {
  if (settings.trigger == TriggerMode::freerun) {
    ask(settings, "TriggerMode", [&](GError** e) { arv_camera_clear_triggers(camera, e); });
    if (settings.frame_rate_hz)
      ask(settings, "setting the frame rate",
          [&](GError** e) { arv_camera_set_frame_rate(camera, *settings.frame_rate_hz, e); });
    return;
  }
  const char* source = settings.trigger == TriggerMode::action ? "Action1"
                       : settings.trigger == TriggerMode::line ? "Line0"
                                                               : "Software";
  if (settings.trigger == TriggerMode::action) set_action_keys(camera, settings);
  ask(settings, fmt::format("setting the trigger source {}", source),
      [&](GError** e) { arv_camera_set_trigger(camera, source, e); });
}

std::string address_of(GSocketAddress* socket_address) {
  if (!socket_address || !G_IS_INET_SOCKET_ADDRESS(socket_address)) return "";
  GInetAddress* inet = g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(socket_address));
  const std::unique_ptr<char, GFree> text(g_inet_address_to_string(inet));
  return or_empty(text.get());
}

int packet_size_for(ArvCamera* camera, const SourceSettings& settings, int mtu) {
  if (settings.packet_size > mtu)
    throw DeviceError(settings.camera, fmt::format("packet_size {} does not fit the link to {}, whose MTU is {}; raise "
                                                   "the MTU or set packet_size to 0",
                                                   settings.packet_size, settings.device, mtu));
  std::int64_t least = 0, most = 0, step = 1;
  ErrorCatcher error;
  arv_camera_get_integer_bounds(camera, "GevSCPSPacketSize", &least, &most, error.out());
  ErrorCatcher no_step;
  if (const auto s = arv_camera_get_integer_increment(camera, "GevSCPSPacketSize", no_step.out()); !no_step && s > 0)
    step = s;
  std::int64_t size = settings.packet_size > 0 ? settings.packet_size : std::min(mtu, jumbo_packet);
  if (!error && most > 0) size = std::min(size, most);
  return static_cast<int>(size - size % step);
}

}  // namespace

SourceDescription configure_camera(ArvCamera* camera, const SourceSettings& settings) {
  SourceDescription description;
  description.vendor = or_empty(arv_camera_get_vendor_name(camera, nullptr));
  description.model = or_empty(arv_camera_get_model_name(camera, nullptr));
  description.serial = or_empty(arv_camera_get_device_serial_number(camera, nullptr));
  if (arv_camera_is_gv_device(camera))
    description.address = address_of(arv_gv_device_get_device_address(ARV_GV_DEVICE(arv_camera_get_device(camera))));
  AravisFeatures features(camera, settings.camera);
  if (!settings.user_set.empty()) load_user_set(features, settings.camera, settings.user_set);
  set_size(camera, settings, description);
  set_offset(camera, settings, description);
  description.format = set_pixel_format(camera, settings);
  set_exposure_and_gain(camera, settings, description);
  if (has_feature(camera, "AcquisitionMode"))
    ask(settings, "AcquisitionMode",
        [&](GError** e) { arv_camera_set_acquisition_mode(camera, ARV_ACQUISITION_MODE_CONTINUOUS, e); });
  std::vector<SettingDifference> differences;
  if (settings.white_balance) differences = set_white_balance(features, settings.camera, *settings.white_balance);
  set_trigger(camera, settings);
  for (auto& difference : set_features(features, settings.camera, settings.features))
    differences.push_back(std::move(difference));
  for (const auto& difference : differences) description.warnings.push_back(to_string(difference));
  return description;
}

StreamChannel configure_stream_channel(ArvCamera* camera, const SourceSettings& settings) {
  if (!arv_camera_is_gv_device(camera)) return {};
  const std::string interface =
      address_of(arv_gv_device_get_interface_address(ARV_GV_DEVICE(arv_camera_get_device(camera))));
  const int mtu = mtu_of_interface(interface);
  StreamChannel channel;
  const auto link = link_with_address(interface);
  channel.link = link.name;
  channel.link_bits_per_second = link.bits_per_second;
  channel.on_loopback = interface.rfind("127.", 0) == 0;
  const int size = packet_size_for(camera, settings, mtu > 0 ? mtu : default_mtu);
  ask(settings, fmt::format("setting packets of {} bytes", size),
      [&](GError** e) { arv_camera_gv_set_packet_size(camera, size, e); });
  channel.packet_size = static_cast<int>(
      ask(settings, "reading the packet size", [&](GError** e) { return arv_camera_gv_get_packet_size(camera, e); }));
  channel.packet_socket = channel.packet_size < packet_socket_below && may_open_packet_socket();
  // A real link may carry less than our end's MTU promises: let Aravis send test packets and shrink.
  arv_camera_gv_set_packet_size_adjustment(
      camera, channel.on_loopback ? ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER : ARV_GV_PACKET_SIZE_ADJUSTMENT_ON_FAILURE);
  arv_camera_gv_set_stream_options(camera, ARV_GV_STREAM_OPTION_NONE);
  if (!channel.packet_socket) forgo_packet_socket(camera);
  return channel;
}

void forgo_packet_socket(ArvCamera* camera) {
  arv_camera_gv_set_stream_options(camera, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
}

// In ticks of the camera's clock, both.
void configure_pacing(ArvCamera* camera, const SourceSettings& settings, const StreamPacing& pacing) {
  if (!arv_camera_is_gv_device(camera)) return;
  ask(settings, "setting the packet delay (GevSCPD)",
      [&](GError** e) { arv_camera_gv_set_packet_delay(camera, pacing.packet_delay.count(), e); });
  if (!has_feature(camera, "GevSCFTD")) return;
  ErrorCatcher untold;
  const auto hertz =
      arv_gv_device_get_timestamp_tick_frequency(ARV_GV_DEVICE(arv_camera_get_device(camera)), untold.out());
  const double ticks =
      static_cast<double>(pacing.start_delay.count()) * (hertz > 0 ? static_cast<double>(hertz) : 1e9) * 1e-9;
  ask(settings, "setting the start delay (GevSCFTD)",
      [&](GError** e) { arv_camera_set_integer(camera, "GevSCFTD", std::llround(ticks), e); });
}

void start_acquisition(ArvCamera* camera, const SourceSettings& settings) {
  ask(settings, "AcquisitionStart", [&](GError** e) { arv_camera_start_acquisition(camera, e); });
}

void stop_acquisition(ArvCamera* camera, const SourceSettings& settings) {
  ask(settings, "AcquisitionStop", [&](GError** e) { arv_camera_stop_acquisition(camera, e); });
}

bool set_indicator_light(ArvCamera* camera, bool on) {
  if (!has_feature(camera, "DeviceIndicatorMode")) return false;
  ErrorCatcher refused;
  arv_camera_set_string(camera, "DeviceIndicatorMode", on ? "Active" : "Inactive", refused.out());
  return !refused;
}

void fire_software_trigger(ArvCamera* camera, const SourceSettings& settings) {
  ask(settings, "TriggerSoftware", [&](GError** e) { arv_camera_software_trigger(camera, e); });
}

// Buffers are made of it: a camera that asks for more than any picture with its chunks is not believed.
std::size_t payload_bytes(ArvCamera* camera, const SourceSettings& settings, const SourceDescription& description) {
  constexpr std::size_t kBesidesPixels = 8 << 20;
  const std::size_t asked = ask(settings, "PayloadSize", [&](GError** e) { return arv_camera_get_payload(camera, e); });
  const std::size_t pixels = image_bytes(description.width, description.height, description.format);
  if (asked <= 2 * pixels + kBesidesPixels) return asked;
  throw DeviceError(settings.camera,
                    fmt::format("{} says that a picture takes {} bytes (PayloadSize); {} x {} {} are {}. It cannot be "
                                "recorded; load its default user set, or renew its firmware",
                                settings.device, asked, description.width, description.height,
                                to_string(description.format), pixels));
}

GRef<ArvStream> create_stream(ArvCamera* camera, const SourceSettings& settings, ArvStreamCallback callback,
                              void* user_data) {
  return GRef<ArvStream>(ask(settings, "opening the stream",
                             [&](GError** e) { return arv_camera_create_stream(camera, callback, user_data, e); }));
}

}  // namespace rotunda::capture
