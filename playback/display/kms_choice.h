#pragma once
// Which connector of a graphics device a picture goes out by, in which mode, and through which CRTC. Plain values, no
// device. Terms are the kernel's (Documentation/gpu/drm-kms.rst).
#include <xf86drmMode.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace rotunda::playback {

struct ConnectorFacts {
  std::uint32_t id = 0;
  std::string name;  // as the kernel's log has it: "HDMI-A-1"
  bool connected = false;
  bool desktop = true;                 // false: a head-mounted display, which wants no plain picture
  bool link_bad = false;               // the link broke down: its mode must be set anew
  std::vector<drmModeModeInfo> modes;  // as its display tells them, best first
  std::uint32_t crtcs = 0;             // bit i: the device's i-th CRTC can feed it
  std::uint32_t crtc = 0;              // that feeds it now; 0: none
};

// The named one, connected or not; with no name the first that is connected and has a mode. Nothing if there is none.
std::optional<ConnectorFacts> choose_connector(std::span<const ConnectorFacts> connectors, const std::string& name);

// The one the display prefers, else the largest and then quickest; progressive before interlaced.
std::optional<drmModeModeInfo> choose_mode(std::span<const drmModeModeInfo> modes);

// Of the device's CRTCs, whose ids are given in its order: the one that feeds the connector already (no flicker), else
// one that feeds no other of its connectors, else any that can; its place among them.
std::optional<std::size_t> choose_crtc(const ConnectorFacts& connector, std::span<const ConnectorFacts> all,
                                       std::span<const std::uint32_t> crtcs);

bool same_mode(const drmModeModeInfo& a, const drmModeModeInfo& b);

}  // namespace rotunda::playback
