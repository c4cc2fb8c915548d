#pragma once
// A window of the desktop with an OpenGL ES 3 context (GLFW on X11, EGL), current on the thread that made it, which
// must be the program's first. Throws DeviceError if there is no display or it gives no such context.
#include <memory>
#include <string>
#include <vector>

namespace rotunda::playback {

enum class Key { left, right, up, down, space, plus, minus, next, previous, home, grey, help, quit };

struct WindowInput {
  std::vector<Key> keys;              // pressed or repeated since last asked
  std::vector<int> digits;            // of these, 1 to 9
  double drag_x = 0.0, drag_y = 0.0;  // of the mouse with a button down, in window heights
  double scroll = 0.0;                // notches, away from the hand is positive
};

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
