#include "playback/display/kms_choice.h"

#include <algorithm>
#include <tuple>

namespace rotunda::playback {
namespace {

bool shows(const ConnectorFacts& connector) {
  return connector.connected && connector.desktop && !connector.modes.empty();
}

auto rank(const drmModeModeInfo& mode) {
  const bool progressive = (mode.flags & DRM_MODE_FLAG_INTERLACE) == 0;
  const bool preferred = (mode.type & DRM_MODE_TYPE_PREFERRED) != 0;
  return std::tuple(progressive, preferred, mode.hdisplay * mode.vdisplay, mode.vrefresh);
}

}  // namespace

std::optional<ConnectorFacts> choose_connector(std::span<const ConnectorFacts> connectors, const std::string& name) {
  const auto found = std::ranges::find_if(
      connectors, [&](const auto& connector) { return name.empty() ? shows(connector) : connector.name == name; });
  return found == connectors.end() ? std::nullopt : std::optional(*found);
}

std::optional<drmModeModeInfo> choose_mode(std::span<const drmModeModeInfo> modes) {
  const auto best = std::ranges::max_element(modes, {}, rank);
  return best == modes.end() ? std::nullopt : std::optional(*best);
}

std::optional<std::size_t> choose_crtc(const ConnectorFacts& connector, std::span<const ConnectorFacts> all,
                                       std::span<const std::uint32_t> crtcs) {
  const auto is_free = [&](std::uint32_t crtc) {
    return std::ranges::none_of(all, [&](const auto& other) { return other.crtc == crtc; });
  };
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < crtcs.size(); ++i) {
    if ((connector.crtcs >> i & 1U) == 0) continue;
    if (crtcs[i] == connector.crtc) return i;
    if (!best || (is_free(crtcs[i]) && !is_free(crtcs[*best]))) best = i;
  }
  return best;
}

bool same_mode(const drmModeModeInfo& a, const drmModeModeInfo& b) {
  const auto timing = [](const drmModeModeInfo& mode) {
    return std::tuple(mode.clock, mode.hdisplay, mode.htotal, mode.vdisplay, mode.vtotal, mode.flags);
  };
  return timing(a) == timing(b);
}

}  // namespace rotunda::playback
