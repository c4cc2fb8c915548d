#include "qemu_monitor.h"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace rotunda::vm {
namespace {

constexpr int kAnswer_ms = 20'000;  // an emulated machine may be busy

}  // namespace

QemuMonitor::QemuMonitor() : port_(::open("/dev/ttyS1", O_RDWR | O_NOCTTY | O_CLOEXEC)) {
  termios settings{};
  if (!port_ || ::tcgetattr(port_.get(), &settings) != 0) throw std::runtime_error("no monitor at /dev/ttyS1");
  ::cfmakeraw(&settings);
  ::tcsetattr(port_.get(), TCSANOW, &settings);
  // The greeting comes before it; what of that was echoed before the port was raw ends with the first line.
  command("\nprint /d 4711", std::string("4711\r\n") + kPrompt);
}

cv::Mat QemuMonitor::screen(const std::string& device) {
  const std::string name = std::to_string(++screens_) + ".ppm";
  const auto file = std::filesystem::path("/run/share") / name;
  command("screendump " + name + " " + device);
  const cv::Mat bgr = cv::imread(file.string());
  if (bgr.empty()) throw std::runtime_error("no picture of " + device);
  std::filesystem::remove(file);
  cv::Mat rgb;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

void QemuMonitor::press(const std::string& key) {
  command("sendkey " + key);
}

void QemuMonitor::command(const std::string& line, const std::string& answer) {
  const std::string told = line + "\n";
  if (::write(port_.get(), told.data(), told.size()) != static_cast<ssize_t>(told.size()) ||
      !read_until(answer, kAnswer_ms).ends_with(answer))
    throw std::runtime_error("QEMU's monitor does not answer to " + line);
}

// Up to these words, or until so long nothing more comes.
std::string QemuMonitor::read_until(const std::string& end, int silence_ms) {
  std::string heard;
  std::array<char, 256> bytes{};
  while (!heard.ends_with(end)) {
    pollfd source{.fd = port_.get(), .events = POLLIN, .revents = 0};
    if (::poll(&source, 1, silence_ms) <= 0) break;
    const auto count = ::read(port_.get(), bytes.data(), bytes.size());
    if (count <= 0) break;
    heard.append(bytes.data(), static_cast<std::size_t>(count));
  }
  return heard;
}

}  // namespace rotunda::vm
