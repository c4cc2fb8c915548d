#pragma once
// The virtual machine as someone before its screens and keyboard has it: QEMU's monitor, on its second serial port
// (tests/vm/run).
#include <opencv2/core.hpp>
#include <string>

#include "capture/base/unique_fd.h"

namespace rotunda::vm {

class QemuMonitor {
 public:
  QemuMonitor();

  // What the graphics device of this name shows, CV_8UC3, RGB.
  cv::Mat screen(const std::string& device);
  void press(const std::string& key);  // "q"

 private:
  static constexpr const char* kPrompt = "(qemu) ";
  void command(const std::string& line, const std::string& answer = kPrompt);
  std::string read_until(const std::string& end, int silence_ms);

  capture::UniqueFd port_;
  int screens_ = 0;
};

}  // namespace rotunda::vm
