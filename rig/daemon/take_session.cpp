#include "rig/daemon/take_session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "capture/take/take.h"
#include "config/errors.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

// A frame set is closed without its missing frames this long after its trigger. Nothing waits for a take live, so it
// is long enough for any resend and for a machine that is busy elsewhere.
constexpr auto kDeadline = 1s;
// How often the recorder looks for deadlines that have passed and for a stop request.
constexpr auto kRecorderPulse = 20ms;
// Frame sets without pixels (the disk was too slow for them) are small: the queue has room for minutes of them.
constexpr std::size_t kRoomForHoles = 10000;

std::string next_free_name(const std::filesystem::path& takes) {
  for (int number = 1;; ++number) {
    auto name = fmt::format("take{:03}", number);
    if (!std::filesystem::exists(takes / name)) return name;
  }
}

// The cameras a take has files for: all whose picture's size is known, from the rig file or because they once answered.
std::vector<capture::TakeCamera> recorded_cameras(const CameraFleet& fleet) {
  std::vector<capture::TakeCamera> cameras;
  for (const auto& worker : fleet.workers()) {
    const auto description = worker->description();
    const auto& settings = worker->settings();
    const bool answered = description.width > 0;
    capture::TakeCamera camera;
    camera.name = settings.camera;
    camera.width = answered ? description.width : settings.width;
    camera.height = answered ? description.height : settings.height;
    camera.format = answered ? description.format : settings.format;
    if (camera.width > 0 && camera.height > 0) cameras.push_back(camera);
  }
  return cameras;
}

std::vector<capture::CameraId> names_of(const std::vector<capture::TakeCamera>& cameras) {
  std::vector<capture::CameraId> names(cameras.size());
  std::transform(cameras.begin(), cameras.end(), names.begin(), [](const auto& camera) { return camera.name; });
  return names;
}

std::vector<std::string> missing_cameras(const CameraFleet& fleet) {
  std::vector<std::string> missing;
  for (const auto& worker : fleet.workers())
    if (!worker->streaming()) missing.push_back(worker->settings().camera);
  return missing;
}

capture::TriggerMode ready_to_trigger(CameraFleet& fleet) {
  fleet.agree_on_trigger_mode();
  if (fleet.streaming() > 0) return fleet.trigger_mode();
  std::string text = "no camera streams, so there is nothing to record:";
  for (const auto& worker : fleet.workers()) text += "\n  " + worker->status().problem;
  throw DeviceError("rig", text);
}

std::filesystem::path take_folder(const config::RigConfig& rig, const TakeRequest& request) {
  const auto name = request.name.empty() ? next_free_name(rig.storage.takes) : request.name;
  if (!capture::valid_take_name(name))
    throw InvalidInput(
        fmt::format("\"{}\" cannot name a take: it becomes a folder's name; use letters, digits, '-', '_'", name));
  return rig.storage.takes / name;
}

capture::TakeWriterOptions writer_options(const config::RigConfig& rig, const TakeRequest& request,
                                          const CameraFleet& fleet, const std::filesystem::path& folder) {
  capture::TakeWriterOptions options;
  options.folder = folder;
  options.fps = rig.trigger.rate_hz;
  options.note = request.note;
  options.rig = rig.name;
  options.rig_file = rig.file;
  if (rig.calibration) options.calibration_file = *rig.calibration;
  options.reserve_bytes = static_cast<std::uint64_t>(rig.storage.reserve_mb * 1e6);
  options.cameras = recorded_cameras(fleet);
  return options;
}

capture::AssemblerOptions assembler_options(const std::vector<capture::CameraId>& cameras,
                                            const capture::TriggerGrid& grid, std::optional<std::uint64_t> wanted) {
  capture::AssemblerOptions options;
  options.cameras = cameras;
  options.grid = grid;
  options.triggers = wanted;
  options.deadline = std::max<std::chrono::nanoseconds>(kDeadline, 2 * options.grid.period);
  return options;
}

}  // namespace

std::optional<std::uint64_t> wanted_frame_sets(const TakeRequest& request, double rate_hz) {
  if (request.frame_sets > 0) return request.frame_sets;
  if (request.duration_s <= 0.0) return std::nullopt;
  return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(request.duration_s * rate_hz)));
}

TakeSession::TakeSession(const config::RigConfig& rig, const TakeRequest& request, CameraFleet& fleet)
    : fleet_(fleet),
      most_queued_(static_cast<std::size_t>(rig.storage.queue_frame_sets)),
      trigger_(make_take_trigger(rig.trigger, ready_to_trigger(fleet), wanted_frame_sets(request, rig.trigger.rate_hz),
                                 fleet)),
      folder_(take_folder(rig, request)),
      writer_(std::in_place, writer_options(rig, request, fleet, folder_)),
      cameras_(names_of(writer_->info().cameras)),
      grid_(trigger_->plan()),
      assembler_(assembler_options(cameras_, grid_, trigger_->wanted())),
      queue_(most_queued_ + kRoomForHoles) {
  progress_.folder = folder_;
  progress_.name = folder_.filename().string();
  progress_.wanted = trigger_->wanted().value_or(0);
  if (const auto missing = missing_cameras(fleet); !missing.empty())
    progress_.warnings.push_back(fmt::format("recording without {}", fmt::join(missing, ", ")));
  fleet_.set_receiver(this);
  trigger_->start([this](const capture::TriggerGrid& grid) { move_grid(grid); });
  recorder_ = std::jthread([this] { record(); });
}

TakeSession::~TakeSession() {
  request_stop();
  if (recorder_.joinable()) recorder_.join();
  trigger_.reset();  // its thread may still tell of the grid
}

void TakeSession::request_stop() {
  stop_requested_ = true;
}

void TakeSession::move_grid(const capture::TriggerGrid& grid) {
  const std::lock_guard lock(assembler_mutex_);
  grid_ = grid;
  assembler_.set_grid(grid);
}

bool TakeSession::records(const capture::CameraId& camera) const {
  return std::find(cameras_.begin(), cameras_.end(), camera) != cameras_.end();
}

void TakeSession::take_frame(capture::Frame&& frame) {
  if (!records(frame.camera)) return;
  const std::lock_guard lock(assembler_mutex_);
  enqueue(assembler_.add(std::move(frame), capture::RigClock::now()));
}

void TakeSession::take_incomplete(const capture::IncompleteFrame& incomplete) {
  if (!records(incomplete.camera)) return;
  const std::lock_guard lock(assembler_mutex_);
  enqueue(assembler_.add_loss(incomplete.camera, incomplete.exposure_start, capture::RigClock::now()));
}

void TakeSession::enqueue(std::vector<capture::FrameSet> sets) {
  for (auto& set : sets) {
    if (queue_.size() >= most_queued_)
      for (auto& slot : set.slots) slot = {.frame = std::nullopt, .missing_because = "disk too slow"};
    queue_.try_push(std::move(set));
  }
}

std::optional<std::uint64_t> TakeSession::triggers_to_record() const {
  const auto counts = trigger_->counts();
  if (counts.finished) return counts.fired + counts.skipped;
  return trigger_->wanted();
}

void TakeSession::close_due_sets() {
  const std::lock_guard lock(assembler_mutex_);
  auto now = capture::RigClock::now();
  for (const auto& worker : fleet_.workers())
    if (records(worker->settings().camera))
      enqueue(assembler_.set_absent(worker->settings().camera, !worker->streaming(), now));
  if (const auto triggers = triggers_to_record())
    now = std::min(now, grid_.time_of(*triggers));  // sets of triggers that were never fired stay unborn
  if (now == capture::Timestamp{}) return;
  enqueue(assembler_.advance(now));
}

bool TakeSession::all_sets_queued() const {
  const auto triggers = triggers_to_record();
  const std::lock_guard lock(assembler_mutex_);
  return triggers && assembler_.next_trigger() >= *triggers;
}

void TakeSession::record() {
  pthread_setname_np(pthread_self(), "recorder");
  while (!all_sets_queued() || queue_.size() > 0) {
    if (const auto set = queue_.wait_pop(kRecorderPulse)) write(*set);
    if (stop_requested_) trigger_->stop();
    close_due_sets();
  }
  fleet_.set_receiver(nullptr);
  close();
}

void TakeSession::write(const capture::FrameSet& set) {
  if (!writer_) return;
  try {
    writer_->write(set);
  } catch (const std::exception& error) {
    return give_up(error.what());
  }
  const std::lock_guard lock(progress_mutex_);
  ++progress_.frame_sets;
  if (set.complete()) ++progress_.complete;
  changed_.notify_all();
}

void TakeSession::give_up(const std::string& failure) {
  spdlog::error("take {}: {}", progress_.name, failure);
  stop_requested_ = true;
  const std::lock_guard lock(progress_mutex_);
  if (progress_.failure.empty()) progress_.failure = failure;
}

void TakeSession::close() {
  if (const auto failure = trigger_->failure(); !failure.empty()) give_up(failure);
  try {
    writer_->finish(capture::TakeState::complete);
  } catch (const std::exception& error) {
    give_up(error.what());
  }
  writer_.reset();
  const std::lock_guard lock(progress_mutex_);
  progress_.closed = true;
  spdlog::info("take {}: {} frame sets, {} complete", progress_.name, progress_.frame_sets, progress_.complete);
  changed_.notify_all();
}

TakeProgress TakeSession::progress() const {
  const std::lock_guard lock(progress_mutex_);
  return progress_;
}

TakeProgress TakeSession::wait_for_change(const TakeProgress& seen, std::chrono::milliseconds timeout) const {
  std::unique_lock lock(progress_mutex_);
  changed_.wait_for(lock, timeout, [&] { return progress_.closed || progress_.frame_sets != seen.frame_sets; });
  return progress_;
}

std::uint64_t TakeSession::late_triggers() const {
  const auto counts = trigger_->counts();
  return counts.late + counts.skipped;
}

std::uint64_t TakeSession::late_frames() const {
  const std::lock_guard lock(assembler_mutex_);
  std::uint64_t late = 0;
  for (const auto& camera : assembler_.counts().cameras) late += camera.late;
  return late;
}

}  // namespace rotunda::rig
