#include "capture/take/take_recovery.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "capture/take/take_lock.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

TakeInfo info_from_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".mkv") files.push_back(entry.path());
  if (files.empty())
    throw InvalidInput(folder.string() + " is not a take: it has neither take.yaml nor a camera's file");
  std::sort(files.begin(), files.end());
  TakeInfo info;
  info.slate = folder.filename().string();
  for (const auto& file : files) {
    const CameraFileHeader header = read_camera_file_header(file);
    info.cameras.push_back(header.camera);
    info.fps = header.fps;
  }
  return info;
}

void ensure_take_info(const fs::path& folder) {
  const fs::path file = folder / "take.yaml";
  if (fs::exists(file)) {
    try {
      read_take_info(folder);
      return;
    } catch (const ConfigError&) {
      fs::copy_file(file, folder / "take.yaml.broken", fs::copy_options::overwrite_existing);
    }
  }
  write_take_info(folder, info_from_files(folder));
}

}  // namespace

TakeReport recover_take(const std::filesystem::path& folder, const Progress& progress, std::stop_token stop) {
  const TakeLock lock(folder);
  ensure_take_info(folder);
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
