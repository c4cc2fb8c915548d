#pragma once
// Progress of long work on stderr: a bar that redraws itself on a terminal, a plain line every few seconds in a pipe.
#include <chrono>
#include <cstddef>
#include <string>

namespace rotunda {

class Progress {
 public:
  explicit Progress(std::string what);  // "recon demo"
  ~Progress();                          // ends the bar's line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void update(std::size_t done, std::size_t total, const std::string& note = {});

 private:
  void draw_bar(std::size_t done, std::size_t total, const std::string& note);

  std::string what_;
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point begun_, told_;
};

}  // namespace rotunda
