#include "playback/display/kms_card.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <xf86drm.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "config/errors.h"

namespace rotunda::playback {
namespace {

namespace fs = std::filesystem;
using Resources = DrmPtr<drmModeRes, drmModeFreeResources>;
using Connector = DrmPtr<drmModeConnector, drmModeFreeConnector>;
using Encoder = DrmPtr<drmModeEncoder, drmModeFreeEncoder>;
using Properties = DrmPtr<drmModeObjectProperties, drmModeFreeObjectProperties>;
using Property = DrmPtr<drmModePropertyRes, drmModeFreeProperty>;

const char* advice(int error) {
  switch (error) {
    case EACCES:
    case EPERM:
      return "; put this user into group video (usermod -aG video NAME) and log in anew";
    case ENOENT:
    case ENODEV:
      return "; `ls /dev/dri` lists the graphics devices there are";
    default:
      return "";
  }
}

capture::UniqueFd open_device(const fs::path& device) {
  capture::UniqueFd fd(::open(device.c_str(), O_RDWR | O_CLOEXEC));
  if (!fd) throw DeviceError(device.string(), fmt::format("{}{}", std::strerror(errno), advice(errno)));
  return fd;
}

std::uint32_t crtcs_of(int fd, const drmModeConnector& connector) {
  std::uint32_t possible = 0;
  for (int i = 0; i < connector.count_encoders; ++i)
    if (const Encoder encoder{drmModeGetEncoder(fd, connector.encoders[i])}) possible |= encoder->possible_crtcs;
  return possible;
}

ConnectorFacts facts_of(int fd, const drmModeConnector& connector) {
  const char* type = drmModeGetConnectorTypeName(connector.connector_type);
  const Encoder feeding{connector.encoder_id != 0 ? drmModeGetEncoder(fd, connector.encoder_id) : nullptr};
  const auto property = [&](const char* name) {
    return property_value(fd, connector.connector_id, DRM_MODE_OBJECT_CONNECTOR, name).value_or(0);
  };
  return {.id = connector.connector_id,
          .name = fmt::format("{}-{}", type ? type : "Unknown", connector.connector_type_id),
          .connected = connector.connection == DRM_MODE_CONNECTED,
          .desktop = property("non-desktop") == 0,
          .link_bad = property("link-status") == DRM_MODE_LINK_STATUS_BAD,
          .modes = {connector.modes, connector.modes + connector.count_modes},
          .crtcs = crtcs_of(fd, connector),
          .crtc = feeding ? feeding->crtc_id : 0};
}

// In the order of their numbers.
std::vector<fs::path> graphics_devices() {
  std::vector<fs::path> devices;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator("/dev/dri", none))
    if (entry.path().filename().string().starts_with("card")) devices.push_back(entry.path());
  const auto place = [](const fs::path& path) { return std::pair(path.native().size(), path.native()); };
  std::ranges::sort(devices, {}, place);
  return devices;
}

std::string told_connectors(const std::vector<ConnectorFacts>& connectors) {
  std::string told;
  for (const auto& connector : connectors)
    told +=
        fmt::format("{}{} {}", told.empty() ? "" : ", ", connector.name, connector.connected ? "connected" : "free");
  return told.empty() ? "none" : told;
}

// Throws what is the matter if it cannot show a picture there.
KmsCard card_with(const fs::path& device, const std::string& wanted) {
  KmsCard card(device);
  const auto connectors = card.connectors(true);
  const auto chosen = choose_connector(connectors, wanted);
  if (chosen && chosen->connected && !chosen->modes.empty()) return card;
  throw DeviceError(device.string(),
                    fmt::format("{}; connect and switch on a display (connectors: {})",
                                wanted.empty() ? "no display is connected" : "no display at connector " + wanted,
                                told_connectors(connectors)));
}

}  // namespace

KmsCard::KmsCard(const fs::path& device) : path_(device), fd_(open_device(device)) {
  const Resources resources{drmModeGetResources(fd_.get())};
  if (!resources || resources->count_crtcs == 0)
    throw DeviceError(device.string(), "drives no display; name another with --device");
  crtcs_.assign(resources->crtcs, resources->crtcs + resources->count_crtcs);
  if (!become_master())
    throw DeviceError(device.string(),
                      "another program shows something on it: end the desktop, or name another with "
                      "--device");
}

std::string KmsCard::driver() const {
  const DrmPtr<drmVersion, drmFreeVersion> version{drmGetVersion(fd())};
  return version ? std::string(version->name, static_cast<std::size_t>(version->name_len)) : "unknown";
}

bool KmsCard::become_master() const {
  return drmIsMaster(fd()) != 0 || drmSetMaster(fd()) == 0;
}

std::vector<ConnectorFacts> KmsCard::connectors(bool ask_displays) const {
  std::vector<ConnectorFacts> connectors;
  const Resources resources{drmModeGetResources(fd())};
  for (int i = 0; resources && i < resources->count_connectors; ++i) {
    const auto id = resources->connectors[i];
    const Connector connector{ask_displays ? drmModeGetConnector(fd(), id) : drmModeGetConnectorCurrent(fd(), id)};
    if (connector) connectors.push_back(facts_of(fd(), *connector));
  }
  return connectors;
}

KmsCard open_card(const fs::path& device, const std::string& connector) {
  if (!device.empty()) return card_with(device, connector);
  std::string reasons;
  for (const auto& path : graphics_devices()) {
    try {
      return card_with(path, connector);
    } catch (const DeviceError& error) {
      reasons += fmt::format("{}{}", reasons.empty() ? "" : "\n", error.what());
    }
  }
  throw DeviceError("display", reasons.empty() ? "no graphics device (/dev/dri/card*) is there; load its driver, or "
                                                 "draw without one: --picture"
                                               : "no graphics device can show a picture:\n" + reasons);
}

std::optional<std::uint64_t> property_value(int fd, std::uint32_t object, std::uint32_t type, const char* name) {
  const Properties properties{drmModeObjectGetProperties(fd, object, type)};
  for (std::uint32_t i = 0; properties && i < properties->count_props; ++i) {
    const Property property{drmModeGetProperty(fd, properties->props[i])};
    if (property && std::string_view(property->name) == name) return properties->prop_values[i];
  }
  return std::nullopt;
}

}  // namespace rotunda::playback
