#pragma once
// A graphics device that sets modes itself (/dev/dri/cardN), held as its DRM master.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/base/unique_fd.h"
#include "playback/display/kms_choice.h"

namespace rotunda::playback {

// C handles, each with the call that gives it back.
template <auto Free>
struct DrmFree {
  template <class T>
  void operator()(T* object) const noexcept {
    Free(object);
  }
};
template <class T, auto Free>
using DrmPtr = std::unique_ptr<T, DrmFree<Free>>;

class KmsCard {
 public:
  // Throws DeviceError, with what to do: no such device, no permission, it shows nothing, another program holds it.
  explicit KmsCard(const std::filesystem::path& device);

  int fd() const { return fd_.get(); }
  const std::filesystem::path& path() const { return path_; }
  std::string driver() const;
  const std::vector<std::uint32_t>& crtcs() const { return crtcs_; }
  // Asking the displays themselves takes tens of milliseconds each; otherwise it is what the kernel was last told.
  std::vector<ConnectorFacts> connectors(bool ask_displays) const;
  bool become_master() const;

 private:
  std::filesystem::path path_;
  capture::UniqueFd fd_;
  std::vector<std::uint32_t> crtcs_;
};

// The named device; without a name the first that has such a connector (kms_choice.h), connected. Throws DeviceError
// that tells of each why not.
KmsCard open_card(const std::filesystem::path& device, const std::string& connector);

// The value of a property of a connector, CRTC or plane; nothing if it has no such property.
std::optional<std::uint64_t> property_value(int fd, std::uint32_t object, std::uint32_t type, const char* name);

}  // namespace rotunda::playback
