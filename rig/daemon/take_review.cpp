#include "rig/daemon/take_review.h"

#include <pthread.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include "recon/live_take.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

constexpr int kNice = 15;  // below live surfaces: nobody waits for a review as for those
constexpr auto kRest = 100ms;

}  // namespace

TakeReview::TakeReview(std::function<bool()> recording)
    : recording_(std::move(recording)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

void TakeReview::add(const std::filesystem::path& take) {
  takes_.push_drop_oldest(take);
}

void TakeReview::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "review");
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  while (const auto take = takes_.pop(stop)) review(*take, stop);
}

void TakeReview::review(const std::filesystem::path& take, const std::stop_token& stop) {
  const auto go_on = [&] {
    while (recording_() && !stop.stop_requested()) std::this_thread::sleep_for(kRest);
    return !stop.stop_requested();
  };
  try {
    const auto report = recon::make_live_take(take, go_on);
    if (report.finished)
      spdlog::info("take {}: can be looked at, {} of {} frames have a surface", take.filename().string(),
                   report.with_surface, report.frames);
  } catch (const std::exception& error) {
    spdlog::warn("take {}: no quick look at it: {}", take.filename().string(), error.what());
  }
}

}  // namespace rotunda::rig
