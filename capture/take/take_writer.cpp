#include "capture/take/take_writer.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <set>
#include <system_error>
#include <utility>

#include "capture/take/atomic_file.h"
#include "capture/take/camera_file_writer.h"
#include "capture/take/take_lock.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kClosingReserve = 1 << 20;  // bytes: seek indices and take.yaml
constexpr std::chrono::seconds kSyncInterval{1};

void check_cameras(const std::vector<TakeCamera>& cameras) {
  if (cameras.empty()) throw InvalidInput("a take needs at least one camera");
  std::set<CameraId> names;
  for (const auto& camera : cameras) {
    if (!valid_take_name(camera.name)) throw InvalidInput("camera name '" + camera.name + "' cannot be a file name");
    if (!names.insert(camera.name).second) throw InvalidInput("there are two cameras named " + camera.name);
    if (camera.width <= 0 || camera.height <= 0) throw InvalidInput(camera.name + ": the size of its frames is 0");
  }
}

void require_room(const fs::path& folder, std::uint64_t needed) {
  const auto free = fs::space(folder).available;
  if (free >= needed) return;
  throw std::system_error(std::make_error_code(std::errc::no_space_on_device),
                          fmt::format("{} has {} bytes free, {} are needed: delete takes or record elsewhere",
                                      folder.string(), free, needed));
}

fs::path existing_ancestor(fs::path folder) {
  folder = fs::absolute(folder);
  while (!fs::exists(folder) && folder.has_relative_path()) folder = folder.parent_path();
  return folder;
}

TakeInfo begin(const TakeWriterOptions& options) {
  TakeInfo info;
  info.name = options.folder.filename().string();
  info.state = TakeState::recording;
  info.fps = options.fps;
  info.start = RigClock::now();
  info.recorded = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  info.scene = options.scene;
  info.shot = options.shot;
  info.take_number = options.take_number;
  info.slate = options.slate;
  if (info.slate.empty()) info.slate = slate_text(info.scene, info.shot, info.take_number);
  if (info.slate.empty()) info.slate = info.name;
  info.note = options.note;
  info.rig = options.rig;
  info.cameras = options.cameras;
  for (auto& camera : info.cameras) {
    camera.frames = camera.missing = 0;
    camera.missing_because.clear();
  }
  return info;
}

void copy_if_given(const fs::path& from, const fs::path& to) {
  if (!from.empty()) fs::copy_file(from, to);
}

void copy_backgrounds(const TakeWriterOptions& options) {
  if (options.background_folder.empty()) return;
  for (const auto& camera : options.cameras) {
    const auto from = options.background_folder / (camera.name + ".png");
    if (!fs::exists(from)) continue;
    const auto to = background_file(options.folder, camera.name);
    fs::create_directories(to.parent_path());
    fs::copy_file(from, to);
  }
}

}  // namespace

TakeWriter::TakeWriter(const TakeWriterOptions& options)
    : folder_(options.folder), info_(begin(options)), sync_statistics_(options.cameras.size()) {
  if (!valid_take_name(info_.name)) throw InvalidInput("'" + info_.name + "' cannot be the name of a take");
  check_cameras(options.cameras);
  if (!(options.fps > 0.0)) throw InvalidInput("a take needs a rate above 0 frame sets a second");
  if (fs::exists(folder_)) throw InvalidInput(folder_.string() + " exists already: choose another name for the take");
  require_room(existing_ancestor(folder_), options.reserve_bytes);
  begin_folder();
  try {
    fill_folder(options);
  } catch (...) {
    files_.clear();
    journal_.reset();
    std::error_code best_effort;
    fs::remove_all(folder_, best_effort);
    throw;
  }
  sync_thread_ = std::jthread([this](const std::stop_token& stop) { sync_every_second(stop); });
}

TakeWriter::~TakeWriter() = default;

// Under a hidden name until it has its take.yaml: whoever kills this process finds a take, or nothing.
void TakeWriter::begin_folder() {
  const auto unborn = folder_.parent_path() / ("." + info_.name + ".new");
  fs::create_directories(unborn);
  lock_ = std::make_unique<TakeLock>(unborn);
  try {
    write_take_info(unborn, info_);
    fs::rename(unborn, folder_);
  } catch (...) {
    std::error_code best_effort;
    fs::remove_all(unborn, best_effort);
    throw;
  }
}

void TakeWriter::fill_folder(const TakeWriterOptions& options) {
  copy_if_given(options.rig_file, folder_ / "rig.yaml");
  copy_if_given(options.calibration_file, capture::calibration_file(folder_));
  copy_backgrounds(options);
  files_.reserve(info_.cameras.size());
  for (const auto& camera : info_.cameras) files_.emplace_back(camera_file(folder_, camera.name), camera, info_.fps);
  journal_.emplace(folder_);
}

// Before anything is written or counted: all of it can be.
void TakeWriter::require_writable(const FrameSet& set) const {
  if (set.slots.size() != files_.size())
    throw InvalidInput(fmt::format("a frame set of {} cameras in a take of {}", set.slots.size(), files_.size()));
  const std::uint64_t next = info_.first_trigger + info_.frame_sets;
  if (info_.frame_sets > 0 && set.trigger < next)
    throw InvalidInput(fmt::format("trigger {} came after trigger {}", set.trigger, next - 1));
  std::uint64_t needed = kClosingReserve;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    if (!set.slots[i].frame) continue;
    files_[i].require_shape(set.slots[i].frame->image);
    needed += set.slots[i].frame->image.size_bytes();
  }
  require_room(folder_, needed);
}

void TakeWriter::write(const FrameSet& set) {
  throw_sync_failure();
  require_writable(set);
  if (info_.frame_sets == 0) {
    info_.first_trigger = set.trigger;
    info_.start = set.time;
  }
  info_.frame_sets = set.trigger - info_.first_trigger + 1;
  const TriggerTime time{.moment = set.time, .in_take = set.time - info_.start};
  for (std::size_t i = 0; i < files_.size(); ++i) {
    if (!set.slots[i].frame) continue;
    files_[i].write(*set.slots[i].frame, time);
    ++info_.cameras[i].frames;
  }
  if (set.complete())
    ++info_.complete_sets;
  else
    count_holes(set);
  sync_statistics_.add(set);
  for (auto& camera : info_.cameras) camera.missing = info_.frame_sets - camera.frames;
}

// What its reason is not known of is missing all the same, and counted so.
void TakeWriter::count_holes(const FrameSet& set) {
  std::map<CameraId, HoleReason> missing;
  for (std::size_t i = 0; i < set.slots.size(); ++i)
    if (const auto why = set.slots[i].missing_because) {
      missing[info_.cameras[i].name] = *why;
      ++info_.cameras[i].missing_because[*why];
    }
  journal_->missing(set.trigger, missing);
}

std::uint64_t TakeWriter::last_trigger() const {
  return info_.first_trigger + std::max<std::size_t>(info_.frame_sets, 1) - 1;
}

void TakeWriter::mark(const std::string& text) {
  journal_->mark({last_trigger(), text});
}

void TakeWriter::incident(const std::string& text) {
  journal_->incident({last_trigger(), text});
}

TakeInfo TakeWriter::finish(TakeState state) {
  sync_thread_ = {};
  throw_sync_failure();
  for (auto& file : files_) file.close();
  journal_->sync();
  info_.sync = sync_statistics_.summary();
  for (auto& camera : info_.cameras) camera.missing = info_.frame_sets - camera.frames;
  info_.state = state;
  write_take_info(folder_, info_);
  lock_.reset();
  return info_;
}

void TakeWriter::sync_every_second(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "take sync");
  std::unique_lock lock(sync_mutex_);
  while (!stop.stop_requested() && !sync_failure_) {
    sync_wakes_.wait_for(lock, stop, kSyncInterval, [] { return false; });
    lock.unlock();
    std::exception_ptr failure;
    try {
      for (const auto& file : files_) file.sync();
      journal_->sync();
    } catch (const std::system_error&) {
      failure = std::current_exception();
    }
    lock.lock();
    sync_failure_ = failure;
  }
}

// A failed fsync means lost pages; trying again would report success (the kernel forgets): the take is not complete.
void TakeWriter::throw_sync_failure() {
  const std::lock_guard lock(sync_mutex_);
  if (sync_failure_) std::rethrow_exception(sync_failure_);
}

}  // namespace rotunda::capture
