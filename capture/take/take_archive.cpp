#include "capture/take/take_archive.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <system_error>
#include <utility>

#include "capture/base/crc32c.h"
#include "capture/base/sha256.h"
#include "capture/take/archive_manifest.h"
#include "capture/take/archived_files.h"
#include "capture/take/camera_file_rest.h"
#include "capture/take/camera_file_writer.h"
#include "capture/take/ffv1_picture.h"
#include "capture/take/new_file.h"
#include "capture/take/take_lock.h"
#include "capture/take/workplace.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

void require_archivable(const fs::path& take, const TakeInfo& info) {
  if (is_archive(take)) throw InvalidInput(take.string() + " is an archive already");
  if (fs::exists(take / "archive"))
    throw InvalidInput((take / "archive").string() + " stands where the archive's own files would");
  if (info.state == TakeState::recording)
    throw InvalidInput(fmt::format("take {} was never closed; first: rotunda take recover {}", info.name, info.name));
}

// What is to be done for one camera: its frames compressed, or its file copied (JPEGs, FFV1 already, no frame at all).
struct CameraWork {
  TakeCamera camera;
  fs::path file;
  std::vector<StoredFrame> frames;  // to compress; none: copied
};

CameraWork work_for(const fs::path& take, const TakeCamera& camera) {
  CameraWork work{.camera = camera, .file = camera_file(take, camera.name), .frames = {}};
  const CameraFileReader reader(work.file, camera);
  if (ffv1_layout(camera) != Ffv1Layout::none && !reader.lossless())
    work.frames = separable_frames(reader, image_bytes(camera.width, camera.height, camera.format));
  return work;
}

// One archiving, shared by the threads that each do one camera.
class Archiving {
 public:
  Archiving(const TakeInfo& info, fs::path take, fs::path part, SharedProgress& progress)
      : info_(info), take_(std::move(take)), part_(std::move(part)), progress_(progress) {}

  void everything(const std::vector<std::string>& files) {
    fs::create_directories(part_ / "archive");
    std::vector<CameraWork> cameras;
    for (const auto& camera : info_.cameras)
      if (fs::exists(camera_file(take_, camera.name))) cameras.push_back(work_for(take_, camera));
    for (const auto& work : cameras) frames_ += work.frames.size();
    progress_.expect(2 * frames_);
    std::vector<std::string> copied = files;
    for (const auto& work : cameras)
      if (!work.frames.empty()) copied.erase(std::find(copied.begin(), copied.end(), work.file.filename().string()));
    for (const auto& file : copied) copy(file);
    tbb::parallel_for(std::size_t{0}, cameras.size(), [&](std::size_t i) {
      if (!cameras[i].frames.empty()) compress(cameras[i]);
    });
    write_sums(recorded_sums(part_), recorded_);
    sum_the_archive();
  }

  std::size_t frames() const { return frames_; }
  std::size_t damaged() const { return damaged_; }

 private:
  void copy(const std::string& file) {
    progress_.throw_if_stopped();
    const auto sum = copy_file_hashed(take_ / file, part_ / file);
    bring_to_disk(part_ / file);
    if (sha256_of(part_ / file) != sum) throw_changed(file);
    note(file, sum);
  }

  void compress(const CameraWork& work) {
    const auto name = work.file.filename().string();
    const std::string sum = write_compressed(work);
    Sha256 again;
    put_camera_file_together(
        part_, work.camera, [&](auto bytes) { again.add(bytes); }, [&] { progress_.step(); });
    if (again.hex() != sum) throw_changed(name);
    note(name, sum);
  }

  // Returns the SHA-256 of the file as it was recorded.
  std::string write_compressed(const CameraWork& work) {
    const TakeCamera& camera = work.camera;
    CameraFileWriter writer(camera_file(part_, camera.name), camera, info_.fps, CameraFileCoding::lossless);
    Sha256 sum;
    const auto write = [&](std::size_t i, std::vector<std::uint8_t> pixels) {
      const FrameRecord& record = *work.frames[i].record;
      if (crc32c(pixels) != record.pixels_crc) ++damaged_;
      writer.write(make_image(camera.width, camera.height, camera.format, std::move(pixels), camera.ycbcr), record,
                   record.trigger_time - info_.start);
      progress_.step();
    };
    const auto rest = take_apart(work.file, work.frames, image_bytes(camera.width, camera.height, camera.format), write,
                                 [&](auto bytes) { sum.add(bytes); });
    writer.close();
    write_rest(rest_file(part_, camera.name), rest);
    bring_to_disk(rest_file(part_, camera.name));
    return sum.hex();
  }

  // Last: from here on it is an archive.
  void sum_the_archive() {
    FileSums sums;
    for (const auto& file : files_of_take(part_)) sums[file] = sha256_of(part_ / file);
    for (const auto& entry : fs::directory_iterator(part_ / "archive"))
      sums["archive/" + entry.path().filename().string()] = sha256_of(entry.path());
    write_sums(archive_sums(part_), sums);
  }

  void note(const std::string& file, const std::string& sum) {
    const std::lock_guard lock(mutex_);
    recorded_[file] = sum;
  }

  [[noreturn]] void throw_changed(const std::string& file) const {
    throw CorruptData(fmt::format("{} read back from {} is not what was written: this disk cannot be trusted", file,
                                  part_.parent_path().parent_path().string()));
  }

  const TakeInfo& info_;
  fs::path take_, part_;
  SharedProgress& progress_;
  std::size_t frames_ = 0;
  std::atomic<std::size_t> damaged_ = 0;
  std::mutex mutex_;  // guards recorded_
  FileSums recorded_;
};

}  // namespace

TakeArchiveResult archive_take(const fs::path& take, const fs::path& archive, const Progress& progress,
                               std::stop_token stop) {
  const TakeLock nobody_changes(take);
  const TakeInfo info = read_take_info(take);
  require_archivable(take, info);
  const auto name = new_take_name(archive);
  const auto files = files_of_take(take);
  SharedProgress shared(progress, std::move(stop), "archiving " + info.name);
  Workplace workplace(archive.parent_path() / ("." + name + ".archiving"));
  const auto part = workplace.folder() / name;
  Archiving archiving(info, take, part, shared);
  archiving.everything(files);
  workplace.keep_as(part, archive);
  return {.frames = archiving.frames(),
          .damaged = archiving.damaged(),
          .bytes_before = bytes_of_take(take),
          .bytes_after = bytes_of_take(archive)};
}

}  // namespace rotunda::capture
