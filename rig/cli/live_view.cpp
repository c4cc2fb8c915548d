#include "rig/cli/live_view.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "capture/picture.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "playback/live_player.h"
#include "recon/live_take.h"
#include "rig/client.h"
#include "rig/live_feed.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto kPatience = 20s;  // for the next surface: going live, a first plate, a machine that is busy

double delay_ms(const recon::LiveSurface& surface) {
  return std::chrono::duration<double, std::milli>(surface.made - surface.exposure).count();
}

// Asks the daemon, which knows better than "nothing came".
std::string why_nothing(const LiveViewRequest& request) {
  const auto status = RigClient(request.socket).status();
  const auto& surfaces = status.surfaces;
  if (!surfaces.problem.empty()) return surfaces.problem;
  if (status.state != "live" && status.state != "recording")
    return fmt::format("the rig is {}; have its cameras triggered: rotunda rig live", status.state);
  return fmt::format("{} frame sets came without a surface", surfaces.failed);
}

playback::LiveView next_view(LiveFeed& feed, const LiveViewRequest& request, std::stop_token stop) {
  if (auto view = feed.wait(kPatience, std::move(stop))) return std::move(*view);
  throw DeviceError("live", fmt::format("no surface came within {} s: {}", kPatience.count(),
                                        feed.problem().empty() ? why_nothing(request) : feed.problem()));
}

void tell(const playback::LiveView& view, const LiveViewRequest& request, long surfaces) {
  const auto& mesh = view.surface.mesh;
  if (request.json)
    fmt::print("{}\n", json{{"picture", request.picture.string()},
                            {"surfaces", surfaces},
                            {"trigger", view.surface.trigger},
                            {"triangles", mesh.triangles.size()},
                            {"closed", recon::topology_of(mesh).is_sphere()},
                            {"volume", recon::signed_volume(mesh)},
                            {"pictures", view.sides.size()},
                            {"delay_ms", delay_ms(view.surface)}}
                           .dump(2));
  else
    fmt::print("{}: frame set {}, {} triangles, {:.0f} ms after its trigger\n", request.picture.string(),
               view.surface.trigger, mesh.triangles.size(), delay_ms(view.surface));
}

int write_picture(LiveFeed& feed, const LiveViewRequest& request, const cv::Size& size, const std::stop_token& stop) {
  if (const auto state = RigClient(request.socket).status().state; state == "armed" || state == "idle")
    throw DeviceError("live", why_nothing(request));
  playback::LiveView view;
  long surfaces = 0;
  while (surfaces < request.surfaces && !stop.stop_requested()) {
    view = next_view(feed, request, stop);
    ++surfaces;
  }
  if (surfaces == 0) return kDoneWithLoss;
  capture::write_png(request.picture, playback::live_picture(view, size.width, size.height));
  tell(view, request, surfaces);
  return kDone;
}

cv::Size size_of(const LiveViewRequest& request) {
  return request.size.empty() ? cv::Size(1280, 720) : cv::Size(request.size[0], request.size[1]);
}

int play_in_window(const std::function<std::optional<playback::LiveView>()>& newest, const LiveViewRequest& request,
                   std::stop_token stop) {
  const auto size = size_of(request);
  const auto tell = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
  const auto report =
      playback::play_live(newest, {.width = size.width,
                                   .height = size.height,
                                   .fullscreen = request.fullscreen,
                                   .display = request.display,
                                   .screen = {.device = request.device, .connector = request.connector, .tell = tell},
                                   .stop = std::move(stop)});
  if (request.json)
    fmt::print("{}\n", json{{"pictures", report.pictures},
                            {"surfaces", report.surfaces},
                            {"seconds", report.seconds},
                            {"lost_contexts", report.lost_contexts}}
                           .dump(2));
  return kDone;
}

std::optional<playback::LiveView> view_of(recon::LiveTakeReader& take, std::size_t frame) {
  auto surface = take.read(frame);
  if (!surface) return std::nullopt;
  recon::compute_normals(surface->mesh);
  return playback::LiveView{std::move(*surface), {}};
}

}  // namespace

int show_live(const LiveViewRequest& request, std::stop_token stop) {
  const auto size = size_of(request);
  LiveFeed feed(request.socket, request.with_pictures);
  if (!request.picture.empty()) return write_picture(feed, request, size, stop);
  std::string told;
  const auto newest = [&] {
    if (const auto problem = feed.problem(); problem != told) {
      if (!problem.empty()) fmt::print(stderr, "{}\n", problem);
      told = problem;
    }
    return feed.take();
  };
  return play_in_window(newest, request, std::move(stop));
}

int show_live_take(const std::filesystem::path& file, const LiveViewRequest& request, std::stop_token stop) {
  recon::LiveTakeReader take(file);
  if (take.frame_count() == 0) throw InvalidInput(file.string() + " holds no frames");
  if (!request.picture.empty()) {
    const auto view = view_of(take, take.frame_count() / 2);
    if (!view) throw InvalidInput(fmt::format("frame {} has no surface", take.frame_count() / 2));
    const auto size = size_of(request);
    capture::write_png(request.picture, playback::live_picture(*view, size.width, size.height));
    tell(*view, request, 1);
    return kDone;
  }
  const auto begin = std::chrono::steady_clock::now();
  auto shown = take.frame_count();
  return play_in_window(
      [&]() -> std::optional<playback::LiveView> {
        const std::chrono::duration<double> since = std::chrono::steady_clock::now() - begin;
        const auto frame = static_cast<std::size_t>(since.count() * take.fps()) % take.frame_count();
        if (frame == shown) return std::nullopt;
        shown = frame;
        return view_of(take, frame);
      },
      request, std::move(stop));
}

}  // namespace rotunda::rig
