#include "capture/source/aravis_opening.h"

#include <fmt/format.h>
#include <pthread.h>

#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "capture/source/genicam_description.h"
#include "capture/source/gvcp_memory.h"
#include "capture/source/user_name.h"
#include "config/errors.h"

namespace rotunda::capture {

namespace {

// How Aravis knows a camera, and its address if it is a GigE Vision one.
struct KnownCamera {
  std::string id, address;
};

// Cameras go by address; by MAC, user name, serial number or Aravis' own id those are found that answer a search, which
// takes a second.
KnownCamera find_camera(const std::string& device) {
  if (g_hostname_is_ip_address(device.c_str())) return {device, device};
  KnownCamera known{device, ""};
  with_device_list([&](unsigned i) {
    const std::string address =
        or_empty(arv_get_device_protocol(i)) == "GigEVision" ? or_empty(arv_get_device_address(i)) : "";
    for (const char* name : {arv_get_device_id(i), arv_get_device_serial_nbr(i), arv_get_device_physical_id(i)})
      if (device == or_empty(name)) known = {or_empty(arv_get_device_id(i)), address};
    if (!address.empty() && device == read_user_name(address)) known = {or_empty(arv_get_device_id(i)), address};
  });
  return known;
}

[[noreturn]] void fail_unanswered(const SourceSettings& settings, const std::string& why) {
  throw DeviceError(settings.camera, fmt::format("no camera answers at {} ({}); check its cable, power and address, or "
                                                 "see which do with: rotunda cameras --discover",
                                                 settings.device, why));
}

[[noreturn]] void fail_unopened(const SourceSettings& settings, const std::string& why) {
  throw DeviceError(settings.camera,
                    fmt::format("what answers at {} cannot be opened as a camera ({}): its description "
                                "cannot be read, or it stopped answering; switch it off and on, and see "
                                "that its firmware is whole",
                                settings.device, why));
}

[[noreturn]] void refuse_description(const SourceSettings& settings, const std::string& problem) {
  throw DeviceError(settings.camera, fmt::format("what answers at {} is refused: its description {}; see that it is a "
                                                 "camera, and that its firmware is whole",
                                                 settings.device, problem));
}

// A second place is only looked at if there is nothing at the first. Makers write web pages and files of their discs
// there, which nobody here finds; one that is found is this machine's.
bool is_file_here(const std::string& url) {
  const std::unique_ptr<char, GFree> file(g_filename_from_uri(url.c_str(), nullptr, nullptr));
  return file && g_file_test(file.get(), G_FILE_TEST_EXISTS);
}

// Before Aravis follows what the camera says.
void require_sound_place_of_description(const SourceSettings& settings, const std::string& address) {
  constexpr std::uint32_t kFirstUrl = 0x200, kSecondUrl = 0x400;  // GigE Vision bootstrap registers
  constexpr std::uint16_t kUrlBytes = 512;
  const auto first = read_gvcp_memory(address, kFirstUrl, kUrlBytes);
  if (!first && answers_gvcp(address))
    throw DeviceError(settings.camera,
                      fmt::format("{} does not let its description be read: another program may hold it for itself "
                                  "alone; close that first",
                                  settings.device));
  if (!first) fail_unanswered(settings, "not found");
  if (const auto problem = url_problem(text_in(*first)); !problem.empty()) refuse_description(settings, problem);
  const auto second = text_in(read_gvcp_memory(address, kSecondUrl, kUrlBytes).value_or(""));
  if (is_file_here(second)) refuse_description(settings, "lies in a file of this machine: " + second);
}

// Before Aravis evaluates it.
void require_sound_description(const SourceSettings& settings, ArvDevice* device) {
  std::size_t bytes = 0;
  const char* xml = arv_device_get_genicam_xml(device, &bytes);
  if (!xml) return;  // then there is nothing to evaluate
  if (const auto problem = description_problem({xml, bytes}); !problem.empty()) refuse_description(settings, problem);
}

}  // namespace

void with_device_list(const std::function<void(unsigned)>& each) {
  static std::mutex list_mutex;  // Aravis keeps one list a process and hands out places in it
  const std::lock_guard lock(list_mutex);
  arv_update_device_list();
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) each(i);
}

std::vector<DiscoveredCamera> discover_aravis_cameras() {
  std::vector<DiscoveredCamera> cameras;
  with_device_list([&](unsigned i) {
    const bool gige = or_empty(arv_get_device_protocol(i)) == "GigEVision";
    const std::string address = or_empty(arv_get_device_address(i));
    cameras.push_back({"aravis", address, or_empty(arv_get_device_serial_nbr(i)), gige ? read_user_name(address) : "",
                       or_empty(arv_get_device_vendor(i)), or_empty(arv_get_device_model(i)),
                       or_empty(arv_get_device_physical_id(i)), ""});
  });
  return cameras;
}

GRef<ArvCamera> open_camera(const SourceSettings& settings) {
  const auto known = find_camera(settings.device);
  if (!known.address.empty()) require_sound_place_of_description(settings, known.address);
  ErrorCatcher error;
  const GRef<ArvDevice> device(arv_open_device(known.id.c_str(), error.out()));
  if (!device && !known.address.empty()) fail_unopened(settings, error.message());
  if (!device) fail_unanswered(settings, error ? error.message() : "not found");
  require_sound_description(settings, device.get());
  GRef<ArvCamera> camera(arv_camera_new_with_device(device.get(), error.out()));
  if (!camera) fail_unanswered(settings, error ? error.message() : "not found");
  if (arv_camera_is_gv_device(camera.get()) &&
      !arv_gv_device_is_controller(ARV_GV_DEVICE(arv_camera_get_device(camera.get()))))
    throw DeviceError(settings.camera,
                      fmt::format("{} is controlled by another program; close that first", settings.device));
  arv_camera_set_range_check_policy(camera.get(), ARV_RANGE_CHECK_POLICY_ENABLE);
  return camera;
}

void close_camera(GRef<ArvCamera> camera, GRef<ArvStream> stream, std::shared_ptr<void> user_data,
                  bool is_gone) noexcept {
  if (is_gone) try {
      std::thread([gone = std::move(camera), last = std::move(stream), tie = std::move(user_data)]() mutable {
        pthread_setname_np(pthread_self(), "farewell");
        last.reset();
        gone.reset();
      }).detach();
    } catch (const std::system_error&) {  // no thread to be had: wait here
    }
  stream.reset();
  camera.reset();
}

}  // namespace rotunda::capture
