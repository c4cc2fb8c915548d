#include "kms_show.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <thread>

#include "capture/base/interrupt.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "playback/display/headless.h"
#include "playback/live_player.h"
#include "tests/support/painted_ball.h"

namespace rotunda::vm {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 60s;
volatile std::sig_atomic_t must_fail = 0;

}  // namespace

playback::LiveView painted_ball() {
  constexpr int kRings = 24, kSectors = 48;
  const tests::PaintedBall ball;
  playback::LiveView view;
  auto& mesh = view.surface.mesh;
  for (int ring = 0; ring <= kRings; ++ring)
    for (int sector = 0; sector <= kSectors; ++sector) {
      const double polar = M_PI * ring / kRings, azimuth = 2.0 * M_PI * sector / kSectors;
      const Eigen::Vector3d normal(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                                   std::cos(polar));
      const Eigen::Vector3d place = ball.centre + ball.radius * normal;
      const auto paint = tests::paint_at(ball, place);
      mesh.positions.push_back(place.cast<float>());
      mesh.normals.push_back(normal.cast<float>());
      mesh.colours.push_back({paint[0], paint[1], paint[2]});
    }
  const auto at = [](int ring, int sector) { return static_cast<std::uint32_t>(ring * (kSectors + 1) + sector); };
  for (int ring = 0; ring < kRings; ++ring)
    for (int sector = 0; sector < kSectors; ++sector) {
      mesh.triangles.push_back({at(ring, sector), at(ring + 1, sector), at(ring + 1, sector + 1)});
      mesh.triangles.push_back({at(ring, sector), at(ring + 1, sector + 1), at(ring, sector + 1)});
    }
  return view;
}

int draw(const std::vector<std::string>& arguments) {
  const cv::Size size(std::stoi(arguments.at(1)), std::stoi(arguments.at(2)));
  const playback::HeadlessDisplay display;
  const playback::RenderTarget target(size.width, size.height);
  playback::LiveStage stage;
  if (arguments.at(3) == "grey") stage.options().shading = playback::Shading::grey;
  stage.show(painted_ball());
  target.bind();
  stage.draw(size.width, size.height);
  cv::Mat bgr;
  cv::cvtColor(target.read_rgba(), bgr, cv::COLOR_RGBA2BGR);
  return cv::imwrite(arguments.at(0), bgr) ? kDone : kBadInput;
}

cv::Mat headless_picture(const cv::Size& size, const std::string& shading) {
  static std::map<std::pair<int, std::string>, cv::Mat> drawn;
  auto& rgb = drawn[{size.width, shading}];
  if (!rgb.empty()) return rgb;
  const auto file = (std::filesystem::temp_directory_path() / "headless.png").string();
  ShowProcess drawing({file, std::to_string(size.width), std::to_string(size.height), shading}, "--draw");
  if (drawing.wait() != kDone) throw std::runtime_error("no headless picture: " + drawing.output());
  cv::cvtColor(cv::imread(file), rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

int show(const std::vector<std::string>& arguments) {
  const capture::Interrupt interrupt;
  std::signal(SIGUSR1, [](int) { must_fail = 1; });
  const auto ball = painted_ball();
  int views = 0;
  const auto newest = [&] {
    if (++views == 10) fmt::print(stderr, "{}\n", kManyPictures);
    if (must_fail) throw InvalidInput("as asked");
    return std::optional(ball);
  };
  const auto tell = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
  try {
    playback::play_live(newest,
                        {.display = playback::DisplayKind::screen,
                         .screen = {.device = arguments.at(0), .atomic = arguments.at(1) == "atomic", .tell = tell},
                         .stop = interrupt.token()});
    return kDone;
  } catch (...) {
    return report_current_exception("show");
  }
}

ShowProcess::ShowProcess(const std::vector<std::string>& arguments, const std::string& task, const std::string& program)
    : log_(std::filesystem::temp_directory_path() / ("show" + task + ".log")) {
  std::vector<std::string> words = {program, task};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (auto& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  std::filesystem::remove(log_);
  process_ = ::fork();
  if (process_ != 0) return;
  const int log = ::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(log, 1);
  ::dup2(log, 2);
  ::execv(program.c_str(), pointers.data());
  ::_exit(127);
}

ShowProcess::~ShowProcess() {
  send(SIGKILL);
  wait();
}

bool ShowProcess::told(const std::string& words) const {
  for (const auto end = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < end;) {
    if (output().find(words) != std::string::npos) return true;
    std::this_thread::sleep_for(100ms);
  }
  return false;
}

void ShowProcess::send(int signal) const {
  if (process_ > 0) ::kill(process_, signal);
}

int ShowProcess::wait() {
  int status = 0;
  for (const auto end = std::chrono::steady_clock::now() + kPatience; process_ > 0;) {
    if (::waitpid(process_, &status, WNOHANG) == process_) {
      process_ = -1;
      return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    if (std::chrono::steady_clock::now() > end) return 255;
    std::this_thread::sleep_for(50ms);
  }
  return 255;
}

std::string ShowProcess::output() const {
  std::ifstream file(log_);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace rotunda::vm
