#pragma once
// An OpenGL ES 3 context without any display (EGL, Mesa's surfaceless platform): what tests, the simulator and
// `rotunda render` draw with. Current on the thread that made it until destroyed; use it from that thread only.
// Throws DeviceError with the EGL step that failed.
#include <memory>

namespace rotunda::playback {

class HeadlessDisplay {
 public:
  HeadlessDisplay();
  ~HeadlessDisplay();
  HeadlessDisplay(const HeadlessDisplay&) = delete;
  HeadlessDisplay& operator=(const HeadlessDisplay&) = delete;

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

// Keeps llvmpipe's scene memory from being handed back to the kernel every frame (it halves the frame rate). Call it
// first thing in main of a program that draws.
void keep_scene_memory();

}  // namespace rotunda::playback
