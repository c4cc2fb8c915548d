// rotunda-sim: the simulated studio. Serves its cameras on the network, or writes their pictures or their layout.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <fstream>
#include <optional>
#include <string>

#include "capture/calibration_file.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "simulator/fault_command.h"
#include "simulator/gallery.h"
#include "simulator/gige/fault_control.h"
#include "simulator/gige/gige_studio.h"
#include "simulator/people/person.h"
#include "simulator/picture_set.h"
#include "simulator/served_studio.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/frame_cache.h"
#include "simulator/studio/truth.h"

namespace rotunda::simulator {
namespace {

// Blocked from the start, so that the one waiting place below gets them, whatever threads there are.
sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

bool stop_asked() {
  const sigset_t set = stop_signals();
  const timespec no_wait{};
  return sigtimedwait(&set, nullptr, &no_wait) > 0;
}

void wait_for_stop() {
  const sigset_t set = stop_signals();
  int signal = 0;
  sigwait(&set, &signal);
}

struct Stopped {};  // thrown out of rendering ahead when asked to stop

// One rewritten line on a terminal, a line each quarter in a pipe.
void tell_progress(const char* what, int done, int all) {
  if (isatty(STDERR_FILENO))
    fmt::print(stderr, "\r{} {}/{}{}", what, done, all, done == all ? "\n" : "");
  else if (done == all || done % std::max(1, all / 4) == 0)
    fmt::print(stderr, "{} {}/{}\n", what, done, all);
  if (stop_asked()) throw Stopped{};
}

struct ServeOptions {
  std::string rig, person, act, truth, ready_file;
  int cameras = 10;
  FaultControlOptions faults;
};

ServedStudio studio_for(const ServeOptions& options) {
  auto studio = options.rig.empty() ? studio_of_size(options.cameras) : studio_of_rig(options.rig);
  if (!options.person.empty()) studio.person = options.person;
  if (!options.act.empty()) studio.act = options.act;
  return studio;
}

FrameCache render_ahead(const ServedStudio& served, const std::string& truth_directory) {
  const auto performance = make_performance({.person = served.person, .act = served.act, .seed = served.seed});
  SceneRenderer studio(*performance, served.cameras, {.seed = served.seed});
  std::optional<TruthFiles> truth;
  if (!truth_directory.empty()) truth.emplace(truth_directory, studio, performance->frames());
  return FrameCache(studio, served.devices.front().format, [&](int frame, const auto& pictures) {
    if (truth) truth->write_frame(frame, pictures);
    tell_progress("rendering ahead", frame + 1, performance->frames());
  });
}

void tell_ready(const ServedStudio& studio, const std::string& ready_file) {
  const auto& devices = studio.devices;
  const auto line =
      fmt::format("{} cameras ready on {} … {}", devices.size(), devices.front().address, devices.back().address);
  fmt::print("{}\n", line);
  std::fflush(stdout);
  if (ready_file.empty()) return;
  std::ofstream file(ready_file + ".part");
  for (const auto& device : devices) file << device.name << ' ' << device.address << '\n';
  file.close();
  if (!file) throw std::system_error(errno, std::generic_category(), "cannot write " + ready_file);
  std::filesystem::rename(ready_file + ".part", ready_file);
}

int serve(const ServeOptions& options) {
  const auto served = studio_for(options);
  FaultControl faults(options.faults, camera_names(served));
  const auto cache = render_ahead(served, options.truth);
  GigeStudio studio(served.devices, [&](std::size_t camera, capture::Timestamp exposure_start) {
    return cache.picture_at(camera, exposure_start);
  });
  studio.start();
  faults.start(studio);
  tell_ready(served, options.ready_file);
  wait_for_stop();
  faults.stop();
  studio.stop();
  tell_faults(options.faults, studio.stats(), faults.cameras());
  if (!options.ready_file.empty()) std::filesystem::remove(options.ready_file);
  return kDone;
}

struct RenderOptions {
  LayoutOptions layout;
  std::string size, aspect, person = "alex", act = "walk", calibration, output;
  int frames = 1;
};

double positive_number(const std::string& text, const char* option) {
  std::size_t used = 0;
  double number = 0.0;
  try {
    number = std::stod(text, &used);
  } catch (const std::logic_error&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || !(number > 0.0))
    throw CLI::ValidationError(option, "expected a positive number, not '" + text + "'");
  return number;
}

void read_size(RenderOptions& options) {
  if (options.size.empty()) return;
  const auto x = options.size.find('x');
  options.layout.width = static_cast<int>(positive_number(options.size.substr(0, x), "--size"));
  options.layout.height =
      x == std::string::npos ? 0 : static_cast<int>(positive_number(options.size.substr(x + 1), "--size"));
}

void read_aspect(RenderOptions& options) {  // 16/15 or 1.0667
  if (options.aspect.empty()) return;
  const auto slash = options.aspect.find('/');
  const double below = slash == std::string::npos ? 1.0 : positive_number(options.aspect.substr(slash + 1), "--aspect");
  options.layout.aspect = positive_number(options.aspect.substr(0, slash), "--aspect") / below;
}

std::vector<capture::CameraModel> cameras_of(RenderOptions options) {
  if (!options.calibration.empty()) return capture::read_calibration(options.calibration);
  read_size(options);
  read_aspect(options);
  return camera_layout(options.layout);
}

int render(const RenderOptions& options) {
  auto cameras = cameras_of(options);
  const auto performance = make_performance({.person = options.person, .act = options.act});
  SceneRenderer studio(*performance, std::move(cameras));
  write_picture_set(options.output, studio, options.frames,
                    [&](int done) { tell_progress("frames written", done, options.frames); });
  return kDone;
}

int write_layout(const RenderOptions& options) {
  capture::write_calibration(options.output, cameras_of(options));
  return kDone;
}

struct GalleryChoice {
  GalleryOptions options{.people = person_names(), .acts = act_names()};
  std::string output;
};

int gallery(const GalleryChoice& choice) {
  write_gallery(choice.output, choice.options, [](const std::string& sheet) { fmt::print(stderr, "{}\n", sheet); });
  return kDone;
}

CLI::App* add_gallery(CLI::App& app, GalleryChoice& choice) {
  auto* command = app.add_subcommand("gallery", "write sheets of pictures of people and acts");
  command->add_option("--person", choice.options.people, "whom (all)")->delimiter(',');
  command->add_option("--act", choice.options.acts, "what (all acts)")->delimiter(',');
  command->add_option("-o,--output", choice.output, "folder to write")->required();
  command->footer("Example: rotunda-sim gallery --act walk,jog -o pictures");
  return command;
}

void add_layout_options(CLI::App& command, RenderOptions& options) {
  command.add_option("--cameras", options.layout.cameras, "2 to 64; four in five on a ring, the rest from above");
  command.add_option("--size", options.size, "WIDTHxHEIGHT in pixels (720x576)");
  command.add_option("--aspect", options.aspect, "fy / fx, as 16/15 or 1.0667 (1)");
  command.add_option("--skew", options.layout.skew_px, "K[0][1] in pixels");
  command.add_option("--k1", options.layout.k1, "radial distortion");
  command.add_option("--k2", options.layout.k2, "radial distortion");
}

void add_serve(CLI::App& app, ServeOptions& options) {
  auto* rig = app.add_option("--rig", options.rig, "serve the cameras of this rig file");
  app.add_option("--cameras", options.cameras, "serve so many cameras, 2 to 64 (10)")->excludes(rig);
  app.add_option("--person", options.person, fmt::format("who: {}, or FILE.glb", fmt::join(person_names(), ", ")));
  app.add_option("--act", options.act,
                 fmt::format("does what: {}, or a clip of FILE.glb", fmt::join(act_names(), ", ")));
  app.add_option("--truth", options.truth, "write what is true of each act frame into this folder");
  app.add_option("--ready-file", options.ready_file, "write this file once the cameras answer; gone again at the end");
  add_fault_options(app, options.faults);
}

int run(int argc, char** argv) {
  CLI::App app("rotunda-sim: synthetic people before virtual GigE Vision cameras\n", "rotunda-sim");
  app.footer("Example: rotunda-sim --rig config/simulated-studio.yaml\nServes until Ctrl-C.");
  ServeOptions serving;
  add_serve(app, serving);
  RenderOptions rendering;
  auto* render_command = app.add_subcommand("render", "write pictures, empty studio, calibration and truth as files");
  add_layout_options(*render_command, rendering);
  render_command->add_option("--calibration", rendering.calibration, "render the cameras of this file instead");
  render_command->add_option("--frames", rendering.frames, "frames of 40 ms (1)")->check(CLI::PositiveNumber);
  render_command->add_option("--person", rendering.person,
                             fmt::format("who: {}, or FILE.glb", fmt::join(person_names(), ", ")));
  render_command->add_option("--act", rendering.act,
                             fmt::format("does what: {}, or a clip of FILE.glb", fmt::join(act_names(), ", ")));
  render_command->add_option("-o,--output", rendering.output, "folder to write")->required();
  render_command->footer(
      "Example: rotunda-sim render --cameras 16 --size 1280x960 --aspect 16/15 --frames 4 -o studio16");
  FaultQuestion question;
  const auto* fault_command = add_fault_command(app, question);
  auto* layout_command = app.add_subcommand("layout", "write the calibration of a simulated studio");
  add_layout_options(*layout_command, rendering);
  layout_command->add_option("-o,--output", rendering.output, "file to write")->required();
  layout_command->footer("Example: rotunda-sim layout --cameras 10 -o calibration.yaml");
  GalleryChoice galleried;
  auto* gallery_command = add_gallery(app, galleried);
  app.require_subcommand(0, 1);
  try {
    app.parse(argc, argv);
    if (*render_command) return render(rendering);
    if (*fault_command) return ask(question);
    if (*gallery_command) return gallery(galleried);
    return *layout_command ? write_layout(rendering) : serve(serving);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  } catch (const Stopped&) {
    return kDone;
  }
}

}  // namespace
}  // namespace rotunda::simulator

int main(int argc, char** argv) {
  rotunda::playback::keep_scene_memory();
  const sigset_t signals = rotunda::simulator::stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  try {
    return rotunda::simulator::run(argc, argv);
  } catch (...) {
    return rotunda::report_current_exception("rotunda-sim");
  }
}
