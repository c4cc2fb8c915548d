#include "capture/source/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "capture/source/aravis_opening.h"
#include "capture/source/aravis_source.h"
#include "capture/source/replay_source.h"
#include "capture/source/v4l2_source.h"
#include "config/errors.h"

namespace rotunda::capture {

namespace {

struct SourceKind {
  std::string_view name;
  std::unique_ptr<Source> (*make)(const SourceSettings&);
  std::vector<DiscoveredCamera> (*discover)();
};

constexpr std::array source_table{
    SourceKind{"aravis", make_aravis_source, discover_aravis_cameras},
    SourceKind{"replay", make_replay_source, discover_replay_cameras},
    SourceKind{"v4l2", make_v4l2_source, discover_v4l2_cameras},
};

}  // namespace

std::string_view to_string(SourceState state) {
  switch (state) {
    case SourceState::closed:
      return "closed";
    case SourceState::open:
      return "open";
    case SourceState::armed:
      return "armed";
    case SourceState::streaming:
      return "streaming";
    case SourceState::lost:
      return "lost";
  }
  return "?";
}

std::string_view to_string(TriggerMode mode) {
  switch (mode) {
    case TriggerMode::freerun:
      return "freerun";
    case TriggerMode::software:
      return "software";
    case TriggerMode::action:
      return "action";
    case TriggerMode::line:
      return "line";
  }
  return "?";
}

bool may_follow(SourceState from, SourceState to) {
  switch (to) {
    case SourceState::closed:
      return true;
    case SourceState::open:
      return from == SourceState::closed;
    case SourceState::armed:
      return from == SourceState::open || from == SourceState::streaming;
    case SourceState::streaming:
      return from == SourceState::armed;
    case SourceState::lost:
      return from != SourceState::closed;
  }
  return false;
}

SourceState checked_transition(SourceState from, SourceState to, const CameraId& camera) {
  if (!may_follow(from, to))
    throw InvalidInput(fmt::format("{}: a camera that is {} cannot become {}", camera, to_string(from), to_string(to)));
  return to;
}

std::unique_ptr<Source> make_source(const SourceSettings& settings) {
  for (const SourceKind& kind : source_table)
    if (kind.name == settings.kind) return kind.make(settings);
  throw InvalidInput(fmt::format("{}: there is no camera source of the kind \"{}\"; expected one of: {}",
                                 settings.camera, settings.kind, fmt::join(source_kinds(), ", ")));
}

std::vector<std::string> source_kinds() {
  std::vector<std::string> names;
  for (const SourceKind& kind : source_table) names.emplace_back(kind.name);
  return names;
}

std::vector<DiscoveredCamera> discover_cameras() {
  std::vector<DiscoveredCamera> cameras;
  for (const SourceKind& kind : source_table)
    for (auto& camera : kind.discover()) cameras.push_back(std::move(camera));
  std::sort(cameras.begin(), cameras.end(), [](const auto& a, const auto& b) {
    return std::tie(a.kind, a.address, a.serial) < std::tie(b.kind, b.address, b.serial);
  });
  return cameras;
}

}  // namespace rotunda::capture
