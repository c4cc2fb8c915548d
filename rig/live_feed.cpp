#include "rig/live_feed.h"

#include <pthread.h>

#include <chrono>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "rig/client.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

constexpr auto kComeBackAfter = 1s;

playback::LiveView view_of(const LivePacket& packet) {
  playback::LiveView view{recon::unpack_surface(packet.surface), {}};
  recon::compute_normals(view.surface.mesh);
  for (const auto& picture : packet.pictures) {
    if (picture.jpeg.empty()) continue;
    cv::Mat rgb = cv::imdecode(picture.jpeg, cv::IMREAD_COLOR);
    if (rgb.empty()) continue;
    cv::cvtColor(rgb, rgb, cv::COLOR_BGR2RGB);
    view.sides.push_back(std::move(rgb));
  }
  return view;
}

}  // namespace

LiveFeed::LiveFeed(const std::filesystem::path& socket, bool with_pictures)
    : socket_(socket), with_pictures_(with_pictures), thread_([this](const std::stop_token& stop) { receive(stop); }) {}

void LiveFeed::receive(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "live feed");
  while (!stop.stop_requested()) {
    std::string problem = "the daemon has ended";
    try {
      RigClient client(socket_);
      client.watch_live(
          with_pictures_,
          [&](LivePacket&& packet) {
            auto view = view_of(packet);
            const std::lock_guard lock(mutex_);
            newest_ = std::move(view);
            problem_.clear();
            changed_.notify_all();
            return true;
          },
          stop);
    } catch (const std::exception& error) {
      problem = error.what();
    }
    std::unique_lock lock(mutex_);
    problem_ = problem;
    changed_.notify_all();
    changed_.wait_for(lock, stop, kComeBackAfter, [] { return false; });
  }
}

std::optional<playback::LiveView> LiveFeed::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(newest_, std::nullopt);
}

std::optional<playback::LiveView> LiveFeed::wait(std::chrono::milliseconds patience, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, stop, patience, [this] { return newest_.has_value(); });
  return std::exchange(newest_, std::nullopt);
}

std::string LiveFeed::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

}  // namespace rotunda::rig
