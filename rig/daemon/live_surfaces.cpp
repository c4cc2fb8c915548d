#include "rig/daemon/live_surfaces.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <spdlog/spdlog.h>
#include <tbb/info.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "recon/live_studio.h"
#include "recon/live_surface.h"
#include "rig/daemon/low_priority.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

constexpr auto kLately = 3s;
constexpr auto kTryAgain = 3s;
constexpr auto kStill = 1s;  // no set was offered for so long: nothing runs
constexpr int kPictureWidth = 360;
constexpr std::size_t kPictures = 4;  // at most, with a surface

// A camera that is not there is done without; a frame that was lost on its way would be missed on the surface.
bool usable(const capture::FrameSet& set) {
  return std::all_of(set.slots.begin(), set.slots.end(), [](const capture::FrameSlot& slot) {
    return slot.frame || slot.missing_because == capture::HoleReason::camera_lost;
  });
}

cv::Mat bgr_of(const capture::HalfPicture& half) {
  std::vector<cv::Mat> planes;
  for (const auto c : {2U, 1U, 0U}) half.planes[c].convertTo(planes.emplace_back(), CV_8U, 1.0 / capture::kHalfScale);
  cv::Mat bgr;
  cv::merge(planes, bgr);
  return bgr;
}

// The picture, and its matte beside it.
LivePicture live_picture(const recon::LiveView& view) {
  const cv::Mat bgr = bgr_of(view.matte.picture);
  cv::Mat alpha = cv::Mat::zeros(bgr.size(), CV_8UC1);
  if (!view.matte.alpha.empty()) view.matte.alpha.copyTo(alpha(view.matte.box));
  const cv::Size size(std::min(kPictureWidth, bgr.cols), std::min(kPictureWidth, bgr.cols) * bgr.rows / bgr.cols);
  cv::Mat both(size.height, 2 * size.width, CV_8UC3), matte;
  cv::resize(bgr, both.colRange(0, size.width), size, 0, 0, cv::INTER_AREA);
  cv::resize(alpha, matte, size, 0, 0, cv::INTER_AREA);
  cv::cvtColor(matte, both.colRange(size.width, 2 * size.width), cv::COLOR_GRAY2BGR);
  LivePicture picture{view.camera, {}};
  cv::imencode(".jpg", both, picture.jpeg, {cv::IMWRITE_JPEG_QUALITY, 80});
  return picture;
}

// Of cameras spread over the rig.
std::vector<LivePicture> live_pictures(const std::vector<recon::LiveView>& views) {
  std::vector<LivePicture> pictures;
  const auto count = std::min(kPictures, views.size());
  for (std::size_t i = 0; i < count; ++i) pictures.push_back(live_picture(views[i * views.size() / count]));
  return pictures;
}

}  // namespace

LiveSurfaces::LiveSurfaces(MakeWork make_work, std::size_t workers, Onlooker onlooker)
    : make_work_(std::move(make_work)), onlooker_(std::move(onlooker)), count_(workers) {
  for (std::size_t i = 0; i < count_; ++i)
    workers_.emplace_back([this](const std::stop_token& stop) { work_off(stop); });
}

LiveSurfaces::~LiveSurfaces() {
  queue_.close();
  workers_.clear();
}

void LiveSurfaces::offer(const capture::FrameSet& set, const std::vector<capture::CameraId>& cameras) {
  if (!usable(set)) return;
  std::shared_ptr<Studio> studio;
  {
    const std::lock_guard lock(mutex_);
    offered_ = Clock::now();
    if (!studio_ || studio_->cameras != cameras) {
      studio_ = std::make_shared<Studio>();
      studio_->cameras = cameras;
    }
    studio = studio_;
  }
  queue_.push_drop_oldest({std::move(studio), set});
}

void LiveSurfaces::renew() {
  const std::lock_guard lock(mutex_);
  studio_.reset();
}

void LiveSurfaces::work_off(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "surfaces");
  lower_priority();
  tbb::task_arena arena(std::max(1, tbb::info::default_concurrency() / static_cast<int>(count_)));
  const LowPriority low(arena);
  while (const auto job = queue_.pop(stop)) arena.execute([&] { work_on(*job); });
}

void LiveSurfaces::work_on(const Job& job) {
  try {
    const auto work = work_of(*job.studio, job.set);
    if (!work) return;
    const bool just_key = only_keys(*work);
    auto frame = just_key ? work->key(job.set) : work->reconstruct(job.set);
    if (onlooker_.tell) onlooker_.tell(job.set, *work, frame.views);
    if (!frame.failure.empty()) return fail(frame.failure);
    if (!just_key) publish(job.set, std::move(frame));
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

bool LiveSurfaces::only_keys(const LiveWork& work) const {
  if (!work.key || !onlooker_.looks || !onlooker_.looks()) return false;
  const std::lock_guard lock(mutex_);
  return viewers_ == 0;
}

std::shared_ptr<const LiveWork> LiveSurfaces::work_of(Studio& studio, const capture::FrameSet& first) {
  const std::lock_guard lock(studio.making);
  if (studio.work || Clock::now() < studio.try_again) return studio.work;
  try {
    studio.work = std::make_shared<const LiveWork>(make_work_(studio.cameras, first));
    tell(studio, studio.work->remark);
  } catch (const std::exception& error) {
    studio.try_again = Clock::now() + kTryAgain;
    tell(studio, error.what());
  }
  return studio.work;
}

void LiveSurfaces::tell(Studio& studio, const std::string& problem) {
  const std::lock_guard lock(mutex_);
  studio.problem = problem;
  if (problem.empty() || problem == logged_) return;
  logged_ = problem;
  spdlog::warn("live surfaces: {}", problem);
}

void LiveSurfaces::fail(const std::string& why) {
  const std::lock_guard lock(mutex_);
  ++told_.failed;
  told_.problem = why;
}

// A worker that was overtaken by another has made what nobody wants to see any more.
void LiveSurfaces::publish(const capture::FrameSet& set, recon::LiveFrame&& frame) {
  bool with_pictures = false;
  {
    const std::lock_guard lock(mutex_);
    with_pictures = picture_viewers_ > 0;
  }
  const auto made = capture::RigClock::now();
  const auto triangles = static_cast<std::uint32_t>(frame.mesh.triangles.size());
  auto packet = std::make_shared<LivePacket>();
  packet->surface =
      recon::pack_surface({.trigger = set.trigger, .exposure = set.time, .made = made, .mesh = std::move(frame.mesh)});
  if (with_pictures) packet->pictures = live_pictures(frame.views);
  const std::lock_guard lock(mutex_);
  if (newest_ && set.time <= newest_time_ && newest_time_ - set.time < kLately) {
    ++told_.shed;
    return;
  }
  newest_ = std::move(packet);
  newest_time_ = set.time;
  ++sequence_;
  ++told_.made;
  told_.triangles = triangles;
  told_.problem.clear();
  lately_.push_back({Clock::now(), std::chrono::duration<double, std::milli>(made - set.time).count()});
  while (lately_.front().at < Clock::now() - kLately) lately_.pop_front();
  changed_.notify_all();
}

LiveSurfacesStatus LiveSurfaces::status() const {
  const std::lock_guard lock(mutex_);
  LiveSurfacesStatus status = told_;
  const auto now = Clock::now();
  status.shed += queue_.dropped();
  status.viewers = viewers_;
  status.state = now - offered_ < kStill ? "running" : "waiting";
  if (status.state == "waiting") status.problem.clear();
  if (studio_ && status.problem.empty() && status.state == "running") status.problem = studio_->problem;
  std::vector<double> delays;
  Clock::time_point first = now;
  for (const auto& made : lately_)
    if (made.at > now - kLately) {
      first = std::min(first, made.at);
      delays.push_back(made.delay_ms);
    }
  if (delays.size() < 2) return status;
  status.rate_hz = static_cast<double>(delays.size()) / std::chrono::duration<double>(now - first).count();
  std::nth_element(delays.begin(), delays.begin() + static_cast<std::ptrdiff_t>(delays.size() / 2), delays.end());
  status.delay_ms = delays[delays.size() / 2];
  return status;
}

LiveViewer::LiveViewer(LiveSurfaces& surfaces, bool with_pictures)
    : surfaces_(surfaces), with_pictures_(with_pictures) {
  const std::lock_guard lock(surfaces_.mutex_);
  if (surfaces_.lately_.empty() || surfaces_.lately_.back().at < LiveSurfaces::Clock::now() - kStill)
    seen_ = surfaces_.sequence_;  // what is left of an earlier session is not live
  ++surfaces_.viewers_;
  if (with_pictures_) ++surfaces_.picture_viewers_;
}

LiveViewer::~LiveViewer() {
  const std::lock_guard lock(surfaces_.mutex_);
  --surfaces_.viewers_;
  if (with_pictures_) --surfaces_.picture_viewers_;
}

std::shared_ptr<const LivePacket> LiveViewer::next(std::chrono::milliseconds patience) {
  std::unique_lock lock(surfaces_.mutex_);
  if (!surfaces_.changed_.wait_for(lock, patience, [&] { return surfaces_.sequence_ != seen_; })) return nullptr;
  seen_ = surfaces_.sequence_;
  return surfaces_.newest_;
}

LiveWork live_work(const config::RigConfig& rig, const std::filesystem::path& plates,
                   const std::vector<capture::CameraId>& cameras, const capture::FrameSet& first) {
  const auto studio = std::make_shared<const recon::LiveStudio>(recon::live_studio(rig, cameras, plates, first));
  return {[studio](const capture::FrameSet& set) {
            recon::StageClock clock;
            return recon::reconstruct_live(set, studio->views, {.bounds = studio->volume}, clock);
          },
          fmt::format("{}", fmt::join(studio->remarks, "; ")),
          [studio](const capture::FrameSet& set) {
            recon::StageClock clock;
            return recon::key_live(set, studio->views, clock);
          },
          {studio, &studio->views.cameras}};
}

}  // namespace rotunda::rig
