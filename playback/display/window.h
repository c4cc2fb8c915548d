#pragma once
// A window of the desktop with an OpenGL ES 3 context (GLFW on X11, EGL), current on the thread that made it, which
// must be the program's first. Throws DeviceError if there is no display or it gives no such context.
#include <memory>
#include <string>

#include "playback/display/window_input.h"

namespace rotunda::playback {

struct WindowOptions {
  std::string title = "rotunda";
  int width = 1280, height = 720;  // pixels; ignored when full-screen
  bool fullscreen = false;
};

class Window {
 public:
  explicit Window(const WindowOptions& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool is_open() const;  // nobody has closed it
  int width() const;     // of what is drawn into, pixels; changes when the window is resized, 0 when minimised
  int height() const;
  void bind() const;                    // makes the window the framebuffer drawn into and sets the viewport
  void present();                       // shows what was drawn and takes the events
  void wait_for_input(double seconds);  // takes events as they come, for so long at most; shows nothing new
  WindowInput take_input();

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace rotunda::playback
