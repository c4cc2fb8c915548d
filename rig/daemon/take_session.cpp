#include "rig/daemon/take_session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "capture/take/take.h"
#include "capture/take/take_edit.h"
#include "config/errors.h"
#include "rig/daemon/plate_recording.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

// A frame set is closed without its missing frames this long after its trigger. Nothing waits for a take live, so it
// is long enough for any resend and for a machine that is busy elsewhere.
constexpr auto kDeadline = 1s;
// How often the recorder looks for deadlines that have passed and for a stop request.
constexpr auto kRecorderPulse = capture::kLookForSilence;
// Frame sets without pixels (the disk was too slow for them) are small: the queue has room for minutes of them.
constexpr std::size_t kRoomForHoles = 10000;

// "take001", or of a slate "12B-03" as the clapperboard will say.
std::string next_free_name(const std::filesystem::path& takes, const TakeRequest& request) {
  const bool slated = !request.scene.empty() || !request.shot.empty();
  int number = slated ? capture::next_take_number(takes, request.scene, request.shot) : 1;
  for (;; ++number) {
    auto name =
        slated ? fmt::format("{}{}-{:02}", request.scene, request.shot, number) : fmt::format("take{:03}", number);
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
    camera.ycbcr = description.ycbcr;
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

std::filesystem::path take_folder(const config::RigConfig& rig, const TakeRequest& request) {
  const auto name = request.name.empty() ? next_free_name(rig.storage.takes, request) : request.name;
  if (!capture::valid_take_name(name))
    throw InvalidInput(
        fmt::format("\"{}\" cannot name a take: it becomes a folder's name; use letters, digits, '-', '_'", name));
  return rig.storage.takes / name;
}

capture::TakeWriterOptions writer_options(const config::RigConfig& rig, const TakeRequest& request,
                                          const std::vector<capture::TakeCamera>& cameras,
                                          const std::filesystem::path& folder) {
  capture::TakeWriterOptions options;
  options.folder = folder;
  options.fps = rig.trigger.rate_hz;
  options.note = request.note;
  options.scene = request.scene;
  options.shot = request.shot;
  if (!request.scene.empty() || !request.shot.empty())
    options.take_number = capture::next_take_number(rig.storage.takes, request.scene, request.shot);
  options.rig = rig.name;
  options.rig_file = rig.file;
  if (rig.calibration) options.calibration_file = *rig.calibration;
  options.background_folder = plate_folder(rig.storage.takes);
  options.reserve_bytes = static_cast<std::uint64_t>(rig.storage.reserve_mb * 1e6);
  options.cameras = cameras;
  return options;
}

FrameSetStreamOptions stream_options(const config::RigConfig& rig, const TakeRequest& request,
                                     const std::vector<capture::TakeCamera>& cameras) {
  return {.trigger = rig.trigger,
          .wanted = wanted_frame_sets(request, rig.trigger.rate_hz),
          .cameras = names_of(cameras),
          .deadline = kDeadline};
}

}  // namespace

std::optional<std::uint64_t> wanted_frame_sets(const TakeRequest& request, double rate_hz) {
  if (request.frame_sets > 0) return request.frame_sets;
  if (request.duration_s <= 0.0) return std::nullopt;
  return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(request.duration_s * rate_hz)));
}

TakeSession::TakeSession(const config::RigConfig& rig, const TakeRequest& request, CameraFleet& fleet,
                         Onlooker onlooker)
    : onlooker_(std::move(onlooker)),
      folder_(take_folder(rig, request)),
      cameras_(recorded_cameras(fleet)),
      most_queued_(static_cast<std::size_t>(rig.storage.queue_frame_sets)),
      queue_(most_queued_ + kRoomForHoles),
      stream_(stream_options(rig, request, cameras_), fleet),
      writer_(std::in_place, writer_options(rig, request, cameras_, folder_)) {
  progress_.folder = folder_;
  progress_.name = folder_.filename().string();
  progress_.slate = writer_->info().slate;
  progress_.scene = request.scene;
  progress_.shot = request.shot;
  progress_.note = request.note;
  progress_.wanted = stream_.wanted().value_or(0);
  if (const auto missing = missing_cameras(fleet); !missing.empty())
    progress_.warnings.push_back(fmt::format("recording without {}", fmt::join(missing, ", ")));
  for (auto& problem : capture::ptp_domain_problems(fleet.clocks())) progress_.warnings.push_back(std::move(problem));
  stream_.start([this](capture::FrameSet&& set) { enqueue(std::move(set)); });
  recorder_ = std::jthread([this] { record(); });
}

TakeSession::~TakeSession() {
  request_stop();
  if (recorder_.joinable()) recorder_.join();
}

void TakeSession::request_stop() {
  stop_requested_ = true;
}

void TakeSession::enqueue(capture::FrameSet&& set) {
  onlooker_(set, stream_.cameras());
  if (queue_.size() >= most_queued_) leave_out(set);
  queue_.try_push(std::move(set));
}

void TakeSession::leave_out(capture::FrameSet& set) {
  const std::lock_guard lock(progress_mutex_);
  for (auto& slot : set.slots) {
    if (!slot.frame) continue;
    ++too_slow_for_[slot.frame->camera];
    slot = {.frame = std::nullopt, .missing_because = capture::HoleReason::disk_too_slow};
  }
}

std::map<capture::CameraId, std::uint64_t> TakeSession::too_slow_for() const {
  const std::lock_guard lock(progress_mutex_);
  return too_slow_for_;
}

void TakeSession::record() {
  pthread_setname_np(pthread_self(), "recorder");
  while (stream_.advance() || queue_.size() > 0) {
    if (const auto set = queue_.wait_pop(kRecorderPulse)) write(*set);
    tell_clock_step();
    tell_cameras();
    if (stop_requested_) stream_.stop();
  }
  close();
}

// The rig's own clock goes on evenly; whoever compares the take with this machine's later must know.
void TakeSession::tell_clock_step() {
  const auto step = clock_steps_.look();
  if (!step || !writer_) return;
  const auto text =
      fmt::format("this machine's clock was set {} by {:.3f} s; the take's times go on evenly",
                  step->count() > 0 ? "forward" : "back", std::abs(std::chrono::duration<double>(*step).count()));
  tell(text);
  const std::lock_guard lock(progress_mutex_);
  progress_.warnings.push_back(text);
}

// When not one camera is left the take ends here: what was taken is closed while somebody is still looking.
void TakeSession::tell_cameras() {
  for (const auto& incident : stream_.take_incidents()) tell(incident);
  if (stop_requested_ || !stream_.all_gone()) return;
  tell("no camera is left");
  give_up(
      "no camera sends pictures or answers any more; the take is closed with what came before; see to the switch, its "
      "power and this machine's network");
  stream_.stop();
  stream_.abandon();
}

void TakeSession::tell(const std::string& incident) {
  spdlog::warn("take {}: {}", progress_.name, incident);
  if (!writer_) return;
  try {
    writer_->incident(incident);
  } catch (const std::exception& error) {
    give_up(error.what());
  }
}

void TakeSession::annotate(const TakeAnnotation& annotation) {
  const std::lock_guard lock(progress_mutex_);
  if (!annotation.mark.empty()) {
    if (progress_.closed) throw DeviceError("rig", "no take is recording: there is no moment to mark");
    marks_.push_back(annotation.mark);
    ++progress_.marks;
  }
  if (annotation.note) said_.note = annotation.note;
  if (annotation.circled) said_.circled = annotation.circled;
  progress_.note = said_.note.value_or(progress_.note);
  progress_.circled = said_.circled.value_or(progress_.circled);
  if (progress_.closed) capture::edit_take(folder_, {.note = said_.note, .circled = said_.circled});
}

void TakeSession::write_annotations() {
  std::vector<std::string> marks;
  TakeAnnotation said;
  {
    const std::lock_guard lock(progress_mutex_);
    marks.swap(marks_);
    said = said_;
  }
  if (said.note) writer_->set_note(*said.note);
  if (said.circled) writer_->set_circled(*said.circled);
  for (const auto& mark : marks) writer_->mark(mark);
}

void TakeSession::write(const capture::FrameSet& set) {
  if (!writer_) return;
  try {
    writer_->write(set);
    write_annotations();
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
  if (const auto failure = stream_.failure(); !failure.empty()) give_up(failure);
  try {
    write_annotations();
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

}  // namespace rotunda::rig
