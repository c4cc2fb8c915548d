#pragma once
// A window of the desktop with an OpenGL ES 3 context (GLFW on X11, EGL), current on the thread that made it, which
// must be the program's first. Throws DeviceError if there is no display or it gives no such context.
#include <functional>
#include <memory>
#include <string>

#include "config/errors.h"
#include "playback/display/window_input.h"

namespace rotunda::playback {

struct WindowOptions {
  std::string title = "rotunda";
  int width = 1280, height = 720;  // pixels; ignored when full-screen
  bool fullscreen = false;
};

// The driver gave up the context with all that was made in it (a reset GPU, a suspended machine). Making everything
// anew in a new window helps (with_window).
struct ContextLost : DeviceError {
  ContextLost() : DeviceError("display", "the graphics driver lost its context") {}
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
  void present();                       // shows what was drawn and takes the events; may throw ContextLost
  void wait_for_input(double seconds);  // takes events as they come, for so long at most; shows nothing new
  WindowInput take_input();

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

// Calls `use` with a window; with a new one, as large as the old one was, whenever it throws ContextLost: what lives in
// the context belongs inside of it, what must outlast it outside. How often that was. Throws ContextLost itself when
// contexts are lost faster than one every five seconds, ten times on end.
int with_window(WindowOptions options, const std::function<void(Window&)>& use);

}  // namespace rotunda::playback
