#include "capture/take/take_verify.h"

#include <system_error>

#include "capture/take/archive_manifest.h"
#include "capture/take/take_reader.h"
#include "capture/take/take_restore.h"

namespace rotunda::capture {
namespace {

TakeReport begin(const TakeReader& take) {
  TakeReport report;
  report.name = take.info().name;
  report.state = take.info().state;
  report.first_trigger = take.info().first_trigger;
  report.frame_sets = take.frame_set_count();
  report.problems = take.problems();
  if (is_archive(take.folder())) {
    const auto more = archive_problems(take.folder());
    report.problems.insert(report.problems.end(), more.begin(), more.end());
  }
  for (std::size_t i = 0; i < take.info().cameras.size(); ++i)
    report.cameras.push_back({.name = take.info().cameras[i].name, .corrupt = take.unplaced_frames(i)});
  return report;
}

// The set before `trigger` may have begun this camera's gap already.
void extend_gap(std::vector<FrameGap>& gaps, std::vector<std::size_t>& last_gap, std::size_t camera,
                const CameraId& name, std::uint64_t trigger) {
  const std::size_t last = last_gap[camera];
  if (last < gaps.size() && gaps[last].first_trigger + gaps[last].frames == trigger) {
    ++gaps[last].frames;
    return;
  }
  last_gap[camera] = gaps.size();
  gaps.push_back({.camera = name, .first_trigger = trigger, .frames = 1});
}

}  // namespace

bool TakeReport::whole() const {
  return state != TakeState::recording && incomplete == 0 && frame_sets > 0 && problems.empty();
}

TakeReport verify_take(const std::filesystem::path& folder, const Progress& progress, std::stop_token stop) {
  const TakeReader take(folder);
  TakeReport report = begin(take);
  std::vector<std::size_t> last_gap(report.cameras.size(), static_cast<std::size_t>(-1));
  for (std::size_t index = 0; index < report.frame_sets; ++index) {
    if (stop.stop_requested())
      throw std::system_error(std::make_error_code(std::errc::operation_canceled), "verifying " + report.name);
    const FrameSet set = take.read(index);
    ++(set.complete() ? report.complete : report.incomplete);
    for (std::size_t camera = 0; camera < set.slots.size(); ++camera) {
      auto& counts = report.cameras[camera];
      if (set.slots[camera].frame) {
        ++counts.frames;
        continue;
      }
      ++counts.missing;
      if (set.slots[camera].missing_because == HoleReason::corrupt) ++counts.corrupt;
      extend_gap(report.gaps, last_gap, camera, counts.name, set.trigger);
    }
    if (progress) progress(index + 1, report.frame_sets);
  }
  return report;
}

}  // namespace rotunda::capture
