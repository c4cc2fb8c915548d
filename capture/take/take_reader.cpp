#include "capture/take/take_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

// Longer than any take (46 days at 25 Hz): a trigger further off is damage that slipped through a record's CRC.
constexpr std::uint64_t kMostFrameSets = 100'000'000;

std::uint64_t trigger_of(const StoredFrame& frame) {
  return frame.record->trigger;
}

bool earlier(const StoredFrame& a, const StoredFrame& b) {
  return trigger_of(a) < trigger_of(b);
}
bool same(const StoredFrame& a, const StoredFrame& b) {
  return trigger_of(a) == trigger_of(b);
}

// Frames whose records hold, by trigger, the first of each.
std::vector<StoredFrame> with_records(std::vector<StoredFrame> frames) {
  frames.erase(std::remove_if(frames.begin(), frames.end(), [](const auto& frame) { return !frame.record; }),
               frames.end());
  std::stable_sort(frames.begin(), frames.end(), earlier);
  frames.erase(std::unique(frames.begin(), frames.end(), same), frames.end());
  return frames;
}

}  // namespace

TakeReader::TakeReader(const fs::path& folder)
    : folder_(folder),
      info_(read_take_info(folder)),
      journal_(read_take_journal(folder)),
      problems_(journal_.problems) {
  files_.reserve(info_.cameras.size());
  for (const auto& camera : info_.cameras) {
    files_.emplace_back(camera_file(folder, camera.name), camera);
    if (!files_.back().problem().empty()) problems_.push_back(camera.name + ": " + files_.back().problem());
  }
  place_frames();
  count();
}

void TakeReader::place_frames() {
  for (const auto& file : files_) {
    placed_.push_back(with_records(file.frames()));
    const auto& frames = file.frames();
    unplaced_.push_back(static_cast<std::size_t>(
        std::count_if(frames.begin(), frames.end(), [](const auto& frame) { return !frame.record; })));
  }
}

// A closed take says in take.yaml which triggers it spans, also if the first or last frames are missing everywhere;
// that of a killed writer spans what is there.
void TakeReader::count() {
  std::uint64_t first = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t last = 0;
  Timestamp first_time = info_.start;
  for (const auto& frames : placed_) {
    if (frames.empty()) continue;
    if (trigger_of(frames.front()) < first) {
      first = trigger_of(frames.front());
      first_time = frames.front().record->trigger_time;
    }
    last = std::max(last, trigger_of(frames.back()));
  }
  const bool any = first <= last;
  const bool told = info_.state != TakeState::recording && info_.frame_sets > 0;
  if (!told) {
    info_.first_trigger = any ? first : 0;
    info_.frame_sets = any ? last - first + 1 : 0;
    info_.start = first_time;
    count_reasons();
  }
  if (info_.frame_sets > kMostFrameSets)
    throw CorruptData(fmt::format("{}: triggers {} to {} cannot be one take", folder_.string(), first, last));
  const auto outside = [&](const StoredFrame& frame) {
    return trigger_of(frame) - info_.first_trigger >= info_.frame_sets;
  };
  std::vector<std::uint64_t> triggers_of_all;
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    auto& frames = placed_[i];
    frames.erase(std::remove_if(frames.begin(), frames.end(), outside), frames.end());
    info_.cameras[i].frames = frames.size();
    info_.cameras[i].missing = info_.frame_sets - frames.size();
  }
  info_.complete_sets = static_cast<std::size_t>(
      std::count_if(placed_.front().begin(), placed_.front().end(), [&](const StoredFrame& frame) {
        return std::all_of(placed_.begin(), placed_.end(), [&](const auto& frames) {
          return std::binary_search(frames.begin(), frames.end(), frame, earlier);
        });
      }));
}

void TakeReader::count_reasons() {
  for (auto& camera : info_.cameras) {
    camera.missing_because.clear();
    for (const auto& [trigger, missing] : journal_.missing)
      if (const auto why = missing.find(camera.name);
          why != missing.end() && trigger - info_.first_trigger < info_.frame_sets)
        ++camera.missing_because[why->second];
  }
}

const StoredFrame* TakeReader::find(std::size_t index, std::size_t camera) const {
  const auto& frames = placed_.at(camera);
  const std::uint64_t trigger = info_.first_trigger + index;
  const auto place =
      std::lower_bound(frames.begin(), frames.end(), trigger,
                       [](const StoredFrame& frame, std::uint64_t wanted) { return trigger_of(frame) < wanted; });
  return place != frames.end() && trigger_of(*place) == trigger ? &*place : nullptr;
}

HoleReason TakeReader::why_missing(std::size_t index, std::size_t camera) const {
  const auto set = journal_.missing.find(info_.first_trigger + index);
  if (set == journal_.missing.end()) return HoleReason::not_recorded;
  const auto reason = set->second.find(info_.cameras[camera].name);
  return reason == set->second.end() ? HoleReason::not_recorded : reason->second;
}

FrameSlot TakeReader::read(std::size_t index, std::size_t camera) const {
  if (index >= info_.frame_sets || camera >= files_.size())
    throw InvalidInput(fmt::format("take {} has {} frame sets of {} cameras; frame set {} of camera {} was asked for",
                                   info_.name, info_.frame_sets, files_.size(), index, camera));
  const StoredFrame* stored = find(index, camera);
  if (stored == nullptr) return {.frame = std::nullopt, .missing_because = why_missing(index, camera)};
  auto frame = files_[camera].read(*stored);
  if (!frame) return {.frame = std::nullopt, .missing_because = HoleReason::corrupt};
  return {.frame = std::move(frame), .missing_because = std::nullopt};
}

FrameSet TakeReader::read(std::size_t index) const {
  FrameSet set;
  set.trigger = info_.first_trigger + index;
  set.time = time_of(index);
  for (std::size_t camera = 0; camera < files_.size(); ++camera) set.slots.push_back(read(index, camera));
  return set;
}

Timestamp TakeReader::time_of(std::size_t index) const {
  for (std::size_t camera = 0; camera < files_.size(); ++camera)
    if (const StoredFrame* stored = find(index, camera)) return stored->record->trigger_time;
  const double since_start = static_cast<double>(index) / info_.fps * 1e9;
  return info_.start + std::chrono::nanoseconds(std::llround(since_start));
}

}  // namespace rotunda::capture
