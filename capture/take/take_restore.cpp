#include "capture/take/take_restore.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>
#include <string_view>
#include <system_error>
#include <utility>

#include "capture/base/sha256.h"
#include "capture/take/archive_manifest.h"
#include "capture/take/archived_files.h"
#include "capture/take/take_lock.h"
#include "capture/take/workplace.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEdited = "take.yaml";  // notes are written into archived takes too

// The camera whose file this is, if its pixels were taken out of it.
const TakeCamera* compressed_camera(const fs::path& archive, const TakeInfo& info, const std::string& file) {
  const auto camera = std::find_if(info.cameras.begin(), info.cameras.end(),
                                   [&](const auto& candidate) { return candidate.name + ".mkv" == file; });
  return camera == info.cameras.end() || !fs::exists(rest_file(archive, camera->name)) ? nullptr : &*camera;
}

// One way back, shared likewise; keeps what is wrong, so that all of it is told at once.
class Restoring {
 public:
  Restoring(const TakeInfo& info, fs::path archive, fs::path part, SharedProgress& progress)
      : info_(info), archive_(std::move(archive)), part_(std::move(part)), progress_(progress) {}

  void everything() {
    const auto sums = read_sums(recorded_sums(archive_));
    const std::vector<std::pair<std::string, std::string>> files(sums.begin(), sums.end());
    std::size_t frames = 0;
    for (const auto& camera : info_.cameras)
      if (fs::exists(rest_file(archive_, camera.name)))
        frames += CameraFileReader(camera_file(archive_, camera.name), camera).frames().size();
    progress_.expect(frames);
    for (const auto& [file, sum] : files) fs::create_directories((part_ / file).parent_path());
    tbb::parallel_for(std::size_t{0}, files.size(), [&](std::size_t i) { one(files[i].first, files[i].second); });
    refuse_if_any();
  }

 private:
  void one(const std::string& file, const std::string& sum) {
    progress_.throw_if_stopped();
    try {
      if (made_again(file) != sum && file != kEdited) note(file + " is not what was archived");
    } catch (const CorruptData& error) {
      note(error.what());
    } catch (const std::system_error& error) {
      if (error.code() != std::errc::no_such_file_or_directory) throw;
      note(error.what());
    }
  }

  // Returns its SHA-256.
  std::string made_again(const std::string& file) {
    const TakeCamera* camera = compressed_camera(archive_, info_, file);
    if (camera == nullptr) return copy_file_hashed(archive_ / file, part_ / file);
    return write_hashed(part_ / file, [&](const ByteSink& all) {
      put_camera_file_together(archive_, *camera, all, [&] { progress_.step(); });
    });
  }

  void note(const std::string& problem) {
    const std::lock_guard lock(mutex_);
    problems_.push_back(problem);
  }

  void refuse_if_any() {
    if (problems_.empty()) return;
    std::sort(problems_.begin(), problems_.end());
    throw CorruptData(
        fmt::format("the archive {} is damaged:\n  {}\nframes that are whole can still be had: rotunda take "
                    "trim {} 0:{} -o NAME",
                    archive_.string(), fmt::join(problems_, "\n  "), archive_.string(), info_.frame_sets));
  }

  const TakeInfo& info_;
  fs::path archive_, part_;
  SharedProgress& progress_;
  std::mutex mutex_;  // guards problems_
  std::vector<std::string> problems_;
};

}  // namespace

TakeInfo restore_take(const fs::path& archive, const fs::path& folder, const Progress& progress, std::stop_token stop) {
  if (!is_archive(archive)) throw InvalidInput(archive.string() + " is no archived take");
  const TakeLock nobody_changes(archive);
  const TakeInfo info = read_take_info(archive);
  const auto name = new_take_name(folder);
  SharedProgress shared(progress, std::move(stop), "restoring " + info.name);
  Workplace workplace(folder.parent_path() / ("." + name + ".restoring"));
  const auto part = workplace.folder() / name;
  Restoring(info, archive, part, shared).everything();
  workplace.keep_as(part, folder);
  return read_take_info(folder);
}

std::vector<std::string> archive_problems(const fs::path& archive) {
  std::vector<std::string> problems;
  try {
    for (const auto& [file, sum] : read_sums(archive_sums(archive)))
      if (!fs::exists(archive / file))
        problems.push_back(file + " is missing from the archive");
      else if (file != kEdited && sha256_of(archive / file) != sum)
        problems.push_back(file + " is not what was archived");
  } catch (const CorruptData& error) {
    problems.emplace_back(error.what());
  }
  return problems;
}

}  // namespace rotunda::capture
