#include "capture/take/take_recovery.h"

#include <utility>

#include "capture/take/take_lock.h"
#include "capture/take/take_reader.h"

namespace rotunda::capture {

TakeReport recover_take(const std::filesystem::path& folder, const Progress& progress, std::stop_token stop) {
  const TakeLock lock(folder);
  TakeReport report = verify_take(folder, progress, std::move(stop));
  if (report.state == TakeState::complete) return report;
  TakeInfo info = TakeReader(folder).info();
  info.state = report.state = TakeState::recovered;
  info.complete_sets = report.complete;
  for (std::size_t i = 0; i < info.cameras.size(); ++i) {
    info.cameras[i].frames = report.cameras[i].frames;
    info.cameras[i].missing = report.cameras[i].missing;
  }
  write_take_info(folder, info);
  return report;
}

}  // namespace rotunda::capture
