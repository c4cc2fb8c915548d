#pragma once
// A surface shown on a whole screen by a process of its own, as the kiosk shows it, and as it must look.
#include <sys/types.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "playback/live_stage.h"

namespace rotunda::vm {

// A painted ball: nothing on it looks the same elsewhere.
playback::LiveView painted_ball();

// What the process does: shows the ball, drawn anew all the time, until it is asked to end, and says when that were
// more pictures than there are buffers; after SIGUSR1 an exception ends it. ARGUMENTS: DEVICE atomic|legacy
inline constexpr const char* kManyPictures = "many pictures";
int show(const std::vector<std::string>& arguments);

// Draws it without a display. ARGUMENTS: FILE.png WIDTH HEIGHT colour|grey
int draw(const std::vector<std::string>& arguments);
// The same by a process of its own, once: on virtio's graphics device Mesa's headless platform holds the device, too.
cv::Mat headless_picture(const cv::Size& size, const std::string& shading = "colour");

class ShowProcess {
 public:
  explicit ShowProcess(const std::vector<std::string>& arguments, const std::string& task = "--show",
                       const std::string& program = "/proc/self/exe");
  ~ShowProcess();  // ends it
  ShowProcess(const ShowProcess&) = delete;
  ShowProcess& operator=(const ShowProcess&) = delete;

  bool told(const std::string& words) const;  // within a minute
  void send(int signal) const;
  int wait();  // its exit code; 128 and the signal that ended it; 255: it does not end
  std::string output() const;

 private:
  std::filesystem::path log_;
  pid_t process_ = -1;
};

}  // namespace rotunda::vm
