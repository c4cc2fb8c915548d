#pragma once
// What a player draws on: a window of the desktop or a whole screen without one. It has an OpenGL ES 3 context, current
// on the thread that made it; use it from that thread only.
#include "config/errors.h"
#include "playback/display/window_input.h"

namespace rotunda::playback {

// The driver gave up the context with all that was made in it (a reset GPU, a suspended machine). Making everything
// anew on a new display helps (open_display.h).
struct ContextLost : DeviceError {
  ContextLost() : DeviceError("display", "the graphics driver lost its context") {}
};

class Display {
 public:
  Display() = default;
  virtual ~Display() = default;
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  virtual bool is_open() const = 0;  // nobody has closed it
  virtual int width() const = 0;     // of what is drawn into, pixels; may change; 0 while nothing can be seen
  virtual int height() const = 0;
  virtual void bind() const = 0;                    // makes it the framebuffer drawn into and sets the viewport
  virtual void present() = 0;                       // shows what was drawn and takes the events; throws ContextLost
  virtual void wait_for_input(double seconds) = 0;  // takes events as they come, for so long at most; shows nothing new
  virtual WindowInput take_input() = 0;
};

}  // namespace rotunda::playback
