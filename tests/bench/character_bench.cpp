// Characters measured: what their motion graph finds against the simulator's truth, what its seams cost, how soon
// commands are answered, how fast it is drawn.
//   character_bench [--character DIR]... [--steer SECONDS] [--takes DIR --sim DIR]
//   character_bench --stand-ins DIR [--person NAME] [--noise METRES]
// --takes: reconstructed takes; --sim: what they were filmed from, NAME/truth/truth.json. One line a figure, with what
// is asked; the baselines of drawing are the same surface as an indexed mesh, here and in VTK (vtk_drawing.py).
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "config/exit_code.h"
#include "playback/character_view.h"
#include "playback/display/headless.h"
#include "playback/render/geometry_image_renderer.h"
#include "playback/render/mesh_renderer.h"
#include "recon/mesh/mesh_file.h"
#include "recon/motion/character.h"
#include "recon/motion/motion_seam.h"
#include "recon/sphere/resample.h"
#include "tests/bench/stand_in_takes.h"

namespace rotunda {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// --- heel strikes -------------------------------------------------------------------------------------------------

struct Strikes {
  int truth = 0, found = 0, near = 0, wrong = 0;
};

// The truth's strikes in a clip that repeats the act; those too near its ends to be seen are left out.
std::vector<recon::HeelStrike> true_strikes(const nlohmann::json& truth, int frames) {
  constexpr int kUnseen = 4;
  const int round = truth.at("act_frames");
  const int end = truth.at("is_cyclic") ? frames : std::min(frames, round);
  std::vector<recon::HeelStrike> strikes;
  for (int start = 0; start < end; start += round)
    for (const auto& strike : truth.at("heel_strikes")) {
      const int frame = start + static_cast<int>(std::lround(strike.at("seconds").get<double>() / 0.04));
      if (frame >= kUnseen && frame < end - kUnseen)
        strikes.push_back({frame, strike.at("side") == "left" ? recon::Side::left : recon::Side::right});
    }
  return strikes;
}

Strikes compare_strikes(const fs::path& video_file, const fs::path& truth_file) {
  std::ifstream stream(truth_file);
  const auto truth = nlohmann::json::parse(stream);
  recon::GeometryVideoReader video(video_file);
  auto clip = recon::clip_shape(video, video_file.string());
  if (!truth.at("is_cyclic") && clip.frame_count() > static_cast<int>(truth.at("act_frames")))
    clip.frames.resize(truth.at("act_frames"));  // then the act starts again elsewhere
  const auto events = recon::gait_events(clip);
  const auto expected = true_strikes(truth, clip.frame_count());
  Strikes strikes{.truth = static_cast<int>(expected.size()), .found = static_cast<int>(events.strikes.size())};
  for (const auto& strike : expected)
    if (std::any_of(events.strikes.begin(), events.strikes.end(), [&](const auto& found) {
          return found.side == strike.side && std::abs(found.frame - strike.frame) <= 1;
        }))
      ++strikes.near;
  for (const auto& found : events.strikes)
    if (found.frame >= 4 && found.frame < clip.frame_count() - 4 &&
        std::none_of(expected.begin(), expected.end(),
                     [&](const auto& strike) { return std::abs(found.frame - strike.frame) <= 1; }))
      ++strikes.wrong;
  return strikes;
}

void measure_strikes(const fs::path& takes, const fs::path& sim) {
  Strikes all;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(takes)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  for (const auto& folder : folders) {
    const auto video = folder / "recon" / "geometry.mkv", truth = sim / folder.filename() / "truth" / "truth.json";
    if (!fs::exists(video) || !fs::exists(truth)) continue;
    const auto one = compare_strikes(video, truth);
    fmt::print("  {:<24} strikes {:>2}, within a frame {:>2}, false {:>2}\n", folder.filename().string(), one.truth,
               one.near, one.wrong);
    all.truth += one.truth;
    all.near += one.near;
    all.wrong += one.wrong;
  }
  fmt::print("heel strikes within a frame  {} of {} ({:.0f} %), {} false   asked >= 95 %\n", all.near, all.truth,
             100.0 * all.near / std::max(1, all.truth), all.wrong);
}

// --- seams --------------------------------------------------------------------------------------------------------

void measure_seams(const recon::MotionGraph& graph) {
  std::vector<double> ratios, slides, errors;
  const auto add = [&](const recon::Join& join) {
    ratios.push_back(join.price.step_ratio);
    slides.push_back(join.price.slide_mm);
    errors.push_back(join.price.error_mm);
  };
  for (const auto& state : graph.states) add(state.loop);
  for (const auto& transition : graph.transitions) {
    for (const auto& leave : transition.leaves) add(leave);
    if (!transition.synthesised()) add(transition.arrive);
  }
  fmt::print("seams {}: error median {:.1f} mm, worst {:.1f} mm\n", ratios.size(), quantile(errors, 0.5),
             quantile(errors, 1.0));
  fmt::print("seam's largest step          median {:.2f}, worst {:.2f}, within 1.5 {:.0f} %   asked <= 1.5\n",
             quantile(ratios, 0.5), quantile(ratios, 1.0),
             100.0 *
                 static_cast<double>(std::count_if(ratios.begin(), ratios.end(), [](double r) { return r <= 1.5; })) /
                 static_cast<double>(ratios.size()));
  fmt::print("standing foot at seams       median {:.1f} mm, worst {:.1f} mm   asked <= 10 mm\n", quantile(slides, 0.5),
             quantile(slides, 1.0));
}

// --- commands -----------------------------------------------------------------------------------------------------

// From a command, given in a state at any moment, to the first frame of the way to what it asks for.
void measure_latency(const recon::MotionGraph& graph, const playback::RootPaths& roots) {
  playback::CharacterPlayer player(graph, roots);
  std::mt19937 random(1);
  std::vector<double> waits;
  constexpr double kTick = 0.01;
  while (waits.size() < 1000 && graph.states.size() > 1) {
    for (int wait = static_cast<int>(random() % 300);
         wait > 0 || !player.in_state() || player.doing() != player.wanted(); --wait)
      player.advance(kTick);
    const auto& asked = graph.states[random() % graph.states.size()].name;
    if (asked == player.wanted()) continue;
    player.command({.state = asked});
    const long before = player.seams();
    int ticks = 0;
    while (player.seams() == before && ticks < 2000) {
      player.advance(kTick);
      ++ticks;
    }
    waits.push_back(ticks * kTick);
  }
  fmt::print("command to its first frame   median {:.2f} s, p95 {:.2f} s, worst {:.2f} s   asked <= 0.5, 1.0 s\n",
             quantile(waits, 0.5), quantile(waits, 0.95), quantile(waits, 1.0));
}

// --- drawing ------------------------------------------------------------------------------------------------------

void time_pictures(const std::string& what, int pictures, const std::string& asked,
                   const std::function<void(int)>& draw) {
  playback::FrameFence fence;
  for (int i = 0; i < 5; ++i) draw(i);
  glFinish();
  const auto begin = Clock::now();
  const double cpu = cpu_seconds();
  for (int i = 0; i < pictures; ++i) {
    draw(i);
    fence.frame_drawn();
  }
  glFinish();
  fmt::print("{:<44} {:>6.1f} /s   CPU {:>5.1f} ms a picture   {}\n", what, pictures / seconds_since(begin),
             1000.0 * (cpu_seconds() - cpu) / pictures, asked);
}

// In a process of its own, without a screen: VTK wants an X server.
void measure_vtk(const recon::TriangleMesh& mesh) {
  const auto file = fs::temp_directory_path() / fmt::format("rotunda_vtk_{}.ply", ::getpid());
  recon::write_ply(file, mesh);
  const auto command =
      fmt::format("xvfb-run -a /usr/bin/python3 '{}' '{}' 200 2>/dev/null", ROTUNDA_VTK_DRAWING, file.string());
  double rate = 0.0, cpu_ms = 0.0;
  FILE* told = ::popen(command.c_str(), "r");
  const bool drawn = told != nullptr && std::fscanf(told, "%lf %lf", &rate, &cpu_ms) == 2;
  if (told != nullptr) ::pclose(told);
  fs::remove(file);
  const std::string what = "baseline: VTK drawing that mesh, 720 x 576";
  if (drawn)
    fmt::print("{:<44} {:>6.1f} /s   CPU {:>5.1f} ms a picture\n", what, rate, cpu_ms);
  else
    fmt::print("{}: not measured; it needs python3-vtk9 and xvfb\n", what);
}

void measure_drawing(const fs::path& character, const recon::MotionGraph& graph) {
  const playback::HeadlessDisplay display;
  auto begin = Clock::now();
  playback::CharacterView view(character, recon::open_character(character));
  view.renderer().load(0, 0);
  glFinish();
  fmt::print("load to the first picture    {:.2f} s   asked < 1 s\n", seconds_since(begin));
  begin = Clock::now();
  view.renderer().load_all();
  std::size_t frames = 0;
  for (const auto& clip : graph.clips) frames += static_cast<std::size_t>(clip.frames);
  fmt::print("all {} frames resident      {:.1f} MB of textures, {:.1f} s   asked <= 320 MB\n", frames,
             static_cast<double>(view.renderer().texture_bytes()) / 1e6, seconds_since(begin));
  playback::CharacterPlayer player(graph, view.renderer().roots());
  player.command({.state = graph.states.front().name});
  const auto film = [&](int width, int height, bool floor, const std::string& what, const std::string& asked) {
    const playback::RenderTarget target(width, height);
    view.orbit() = view.orbit_for(static_cast<double>(width) / height);
    time_pictures(what, 200, asked, [&](int) {
      player.advance(1.0 / graph.fps);
      view.follow(player.appearance(), 1.0 / graph.fps);
      target.bind();
      view.draw(player.appearance(), width, height, {recon::Colour{24, 26, 30}, floor, {}});
    });
  };
  film(720, 576, false, "character alone, 720 x 576", "asked >= 88");
  film(1280, 720, false, "character alone, 1280 x 720", "asked >= 78");
  film(1280, 720, true, "with floor and shadow, 1280 x 720", "asked >= 60");
  recon::GeometryVideoReader video(recon::clip_video_of(character, graph.clips.front().name));
  const std::vector<recon::GeometryImage> images{video.read(0), video.read(1)};
  const playback::RenderTarget target(720, 576);
  playback::GeometryImageRenderer single;
  playback::Orbit orbit = view.orbit_for(1.25);
  orbit.target.head<2>() = video.header().root_path.front().head<2>();
  const auto eye = orbit.viewpoint(720, 576);
  time_pictures("both uploads a frame, 720 x 576", 200, "asked >= 88", [&](int i) {
    single.upload(images[static_cast<std::size_t>(i % 2)]);
    target.bind();
    playback::clear(recon::Colour{24, 26, 30});
    single.draw(eye);
  });
  const auto mesh = recon::remesh(images[0]);
  playback::MeshRenderer plain;
  plain.upload(mesh);
  time_pictures("baseline: an indexed mesh of one frame, 720 x 576", 200, "", [&](int) {
    target.bind();
    playback::clear(recon::Colour{24, 26, 30});
    plain.draw(eye);
  });
  measure_vtk(mesh);
}

// --- long steering ------------------------------------------------------------------------------------------------

long resident_kilobytes() {
  std::ifstream statm("/proc/self/statm");
  long size = 0, resident = 0;
  statm >> size >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

// Random commands, every picture drawn, as fast as it goes; seconds are the character's.
void measure_steering(const fs::path& character, const recon::MotionGraph& graph, double seconds) {
  const playback::HeadlessDisplay display;
  playback::CharacterView view(character, graph);
  view.renderer().load_all();
  view.orbit() = view.orbit_for(16.0 / 9.0);
  const playback::RenderTarget target(640, 360);
  playback::CharacterPlayer player(graph, view.renderer().roots());
  std::mt19937 random(3);
  std::vector<double> times;
  long before = 0;
  const auto frames = static_cast<int>(seconds * graph.fps);
  for (int i = 0; i < frames; ++i) {
    const auto begin = Clock::now();
    if (random() % 40 == 0) player.command({.state = graph.states[random() % graph.states.size()].name});
    if (random() % 60 == 0) player.command({.turn = 0.5 * (static_cast<double>(random() % 7) - 3.0)});
    if (random() % 80 == 0) player.command({.speed = 0.1 * static_cast<double>(random() % 25)});
    player.advance(1.0 / graph.fps);
    view.follow(player.appearance(), 1.0 / graph.fps);
    target.bind();
    view.draw(player.appearance(), 640, 360, {recon::Colour{24, 26, 30}, true, {}});
    glFinish();
    times.push_back(seconds_since(begin));
    if (i == frames / 10) before = resident_kilobytes();
  }
  const double median = quantile(times, 0.5);
  fmt::print(
      "{:.0f} s of random steering       worst picture {:.1f} x the median, {} of {} over 3 x; memory {:+.1f} MB\n",
      seconds, quantile(times, 1.0) / median,
      std::count_if(times.begin(), times.end(), [&](double t) { return t > 3.0 * median; }), times.size(),
      static_cast<double>(resident_kilobytes() - before) / 1024.0);
}

void measure_character(const fs::path& character, double steering) {
  const auto graph = recon::open_character(character);
  fmt::print("== {}\n", character.string());
  measure_seams(graph);
  playback::RootPaths roots;
  for (const auto& clip : graph.clips) {
    recon::GeometryVideoReader video(recon::clip_video_of(character, clip.name));
    roots.emplace_back();
    for (const auto& root : video.header().root_path) roots.back().push_back(root.head<2>());
  }
  measure_latency(graph, roots);
  measure_drawing(character, graph);
  if (steering > 0.0) measure_steering(character, graph, steering);
}

int run(int argc, char** argv) {
  CLI::App app("Measures characters");
  std::vector<fs::path> characters;
  fs::path takes, sim;
  app.add_option("--character", characters, "built by rotunda character build");
  auto* with_truth = app.add_option("--takes", takes, "reconstructed takes");
  app.add_option("--sim", sim, "the simulator's pictures and truth of them")->needs(with_truth);
  double steering = 0.0;
  app.add_option("--steer", steering, "seconds of random steering, every picture drawn");
  fs::path stand_ins;
  bench::StandInOptions stand_in;
  app.add_option("--stand-ins", stand_ins, "only writes perfectly aligned takes of a simulated person there");
  app.add_option("--person", stand_in.person, "whose")->capture_default_str();
  app.add_option("--level", stand_in.level, "of their lattice")->capture_default_str();
  app.add_option("--noise", stand_in.noise, "of their surfaces, metres")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (!stand_ins.empty()) bench::write_stand_ins(stand_ins, stand_in);
  if (!takes.empty()) measure_strikes(takes, sim);
  for (const auto& character : characters) measure_character(character, steering);
  return kDone;
}

}  // namespace
}  // namespace rotunda

int main(int argc, char** argv) try {
  rotunda::playback::keep_scene_memory();
  return rotunda::run(argc, argv);
} catch (...) {
  return rotunda::report_current_exception("character_bench");
}
