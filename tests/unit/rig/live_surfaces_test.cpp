#include "rig/daemon/live_surfaces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <thread>

#include "config/errors.h"
#include "recon/live_surface.h"
#include "tests/support/closed_shapes.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

const std::vector<capture::CameraId> kCameras{"cam00", "cam01"};
constexpr auto kSoon = 20s;  // on a machine that is busy elsewhere

capture::FrameSet set_of(std::uint64_t trigger) {
  capture::FrameSet set{.trigger = trigger, .time = capture::RigClock::now(), .slots = {}};
  for (const auto& camera : kCameras) {
    set.slots.emplace_back();
    set.slots.back().frame.emplace().camera = camera;
  }
  return set;
}

recon::LiveFrame a_surface() {
  recon::LiveFrame frame{.mesh = tests::icosphere(1), .views = {}, .failure = {}};
  frame.mesh.colours.resize(frame.mesh.positions.size());
  return frame;
}

LiveSurfaces::MakeWork made_of(std::function<recon::LiveFrame(const capture::FrameSet&)> reconstruct) {
  return [reconstruct](const auto&, const auto&) { return LiveWork{reconstruct, ""}; };
}

bool comes_true(const std::function<bool()>& claim) {
  const auto end = std::chrono::steady_clock::now() + kSoon;
  while (!claim() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(2ms);
  return claim();
}

// Work that waits for a gate.
struct Gate {
  std::atomic<int> begun = 0;
  std::atomic<bool> open = false;
  recon::LiveFrame operator()() {
    ++begun;
    while (!open) std::this_thread::sleep_for(1ms);
    return a_surface();
  }
};

TEST(LiveSurfaces, ShedsTheOldestWholeSetsAndNeverHoldsUpWhoOffers) {
  Gate gate;
  LiveSurfaces surfaces(made_of([&gate](const auto&) { return gate(); }), 1);
  surfaces.offer(set_of(0), kCameras);
  ASSERT_TRUE(comes_true([&] { return gate.begun == 1; }));
  for (std::uint64_t trigger = 1; trigger <= 9; ++trigger) surfaces.offer(set_of(trigger), kCameras);
  EXPECT_EQ(surfaces.status().shed, 8u) << "nine came while one was worked on; the newest waits";
  LiveViewer viewer(surfaces, false);
  gate.open = true;
  ASSERT_TRUE(comes_true([&] { return surfaces.status().made == 2; }));
  const auto newest = viewer.next(1s);
  ASSERT_TRUE(newest);
  EXPECT_EQ(recon::unpack_surface(newest->surface).trigger, 9u);
  EXPECT_EQ(surfaces.status().shed, 8u);
}

TEST(LiveSurfaces, EveryViewerGetsTheNewestOnceAndASlowOneMissesSome) {
  LiveSurfaces surfaces(made_of([](const auto&) { return a_surface(); }), 1);
  LiveViewer quick(surfaces, false), slow(surfaces, false);
  EXPECT_EQ(surfaces.status().viewers, 2u);
  for (std::uint64_t trigger = 0; trigger < 5; ++trigger) {
    surfaces.offer(set_of(trigger), kCameras);
    const auto packet = quick.next(kSoon);
    ASSERT_TRUE(packet);
    EXPECT_EQ(recon::unpack_surface(packet->surface).trigger, trigger);
  }
  const auto packet = slow.next(kSoon);
  ASSERT_TRUE(packet);
  EXPECT_EQ(recon::unpack_surface(packet->surface).trigger, 4u);
  EXPECT_FALSE(slow.next(1ms)) << "it has that one";
  const auto status = surfaces.status();
  EXPECT_EQ(status.made, 5u);
  EXPECT_GT(status.rate_hz, 0.0);
  EXPECT_GT(status.delay_ms, 0.0);
  EXPECT_EQ(status.triangles, tests::icosphere(1).triangles.size());
}

TEST(LiveSurfaces, AWorkerThatWasOvertakenKeepsItsOldSurface) {
  std::atomic<bool> first_may_end = false;
  LiveSurfaces surfaces(made_of([&](const auto& set) {
                          while (set.trigger == 0 && !first_may_end) std::this_thread::sleep_for(1ms);
                          return a_surface();
                        }),
                        2);
  LiveViewer viewer(surfaces, false);
  surfaces.offer(set_of(0), kCameras);
  std::this_thread::sleep_for(20ms);
  surfaces.offer(set_of(1), kCameras);
  const auto packet = viewer.next(kSoon);
  first_may_end = true;
  ASSERT_TRUE(packet);
  EXPECT_EQ(recon::unpack_surface(packet->surface).trigger, 1u);
  ASSERT_TRUE(comes_true([&] { return surfaces.status().shed == 1; }));
  EXPECT_FALSE(viewer.next(1ms));
}

TEST(LiveSurfaces, LostCamerasAreDoneWithoutLostPacketsAreNot) {
  std::atomic<int> worked = 0;
  LiveSurfaces surfaces(made_of([&](const auto&) {
                          ++worked;
                          return a_surface();
                        }),
                        1);
  auto set = set_of(0);
  set.slots[1] = {std::nullopt, capture::HoleReason::packets_lost};
  surfaces.offer(set, kCameras);
  set.slots[1].missing_because = capture::HoleReason::camera_lost;
  surfaces.offer(set, kCameras);
  ASSERT_TRUE(comes_true([&] { return surfaces.status().made == 1; }));
  EXPECT_EQ(worked, 1);
}

TEST(LiveSurfaces, TellsWhatKeepsThemFromBeingMadeAndWhatFailed) {
  std::atomic<bool> calibrated = false;
  std::atomic<bool> empty = false;
  LiveSurfaces surfaces(
      [&](const auto&, const auto&) -> LiveWork {
        if (!calibrated) throw InvalidInput("the rig has no calibration");
        return {[&](const auto&) {
                  auto frame = a_surface();
                  if (empty) frame = {.mesh = {}, .views = {}, .failure = "empty silhouette in cam00"};
                  return frame;
                },
                "cam01: no plate"};
      },
      1);
  EXPECT_EQ(surfaces.status().state, "waiting");
  surfaces.offer(set_of(0), kCameras);
  ASSERT_TRUE(comes_true([&] { return surfaces.status().problem == "the rig has no calibration"; }));
  EXPECT_EQ(surfaces.status().state, "running");
  calibrated = true;
  surfaces.renew();  // a new session reads it anew
  surfaces.offer(set_of(1), kCameras);
  ASSERT_TRUE(comes_true([&] { return surfaces.status().made == 1; }));
  surfaces.offer(set_of(2), kCameras);
  EXPECT_EQ(surfaces.status().problem, "cam01: no plate");
  empty = true;
  ASSERT_TRUE(comes_true([&] {
    surfaces.offer(set_of(3), kCameras);
    return surfaces.status().failed > 0;
  }));
  EXPECT_EQ(surfaces.status().problem, "empty silhouette in cam00");
}

}  // namespace
}  // namespace rotunda::rig
