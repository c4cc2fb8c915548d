#pragma once
// A window of the desktop with an OpenGL ES 3 context (GLFW on X11, EGL), current on the thread that made it, which
// must be the program's first. Throws DeviceError if there is no display or it gives no such context.
#include <memory>
#include <string>

#include "playback/display/display.h"

namespace rotunda::playback {

struct WindowOptions {
  std::string title = "rotunda";
  int width = 1280, height = 720;  // pixels; ignored when full-screen
  bool fullscreen = false;
};

class Window final : public Display {
 public:
  explicit Window(const WindowOptions& options);
  ~Window() override;

  bool is_open() const override;
  int width() const override;  // changes when the window is resized, 0 when minimised
  int height() const override;
  void bind() const override;
  void present() override;
  void wait_for_input(double seconds) override;
  WindowInput take_input() override;

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace rotunda::playback
