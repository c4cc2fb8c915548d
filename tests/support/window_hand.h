#pragma once
// Hands on a window of an X display: keys and clicks, sent to it one after another.
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/keysym.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

namespace rotunda::tests {

class WindowHand {
 public:
  // Waits until a window of this title is to be seen, a minute at most.
  WindowHand(const std::string& display, const std::string& title) : display_(XOpenDisplay(display.c_str())) {
    if (!display_) throw std::runtime_error("no display " + display);
    for (int i = 0; i < 6000 && !window_; ++i) {
      window_ = find(DefaultRootWindow(display_), title);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    if (!window_) throw std::runtime_error("no window " + title);
  }
  ~WindowHand() { XCloseDisplay(display_); }
  WindowHand(const WindowHand&) = delete;
  WindowHand& operator=(const WindowHand&) = delete;

  void press(KeySym key, unsigned modifiers = 0) {
    XEvent event{};
    event.xkey.keycode = XKeysymToKeycode(display_, key);
    event.xkey.state = modifiers;
    event.xkey.time = ++time_;
    for (const int type : {KeyPress, KeyRelease}) send(event, type, type == KeyPress ? KeyPressMask : KeyReleaseMask);
  }
  void click(int x, int y) { drag(x, y, x, y); }
  void drag(int x, int y, int to_x, int to_y) {
    move(x, y);
    button(ButtonPress, ButtonPressMask);
    if (to_x != x || to_y != y) move(to_x, to_y);
    button(ButtonRelease, ButtonReleaseMask);
  }
  // Of what the window shows there, 0 to 255.
  int brightness_at(int x, int y) {
    XImage* image = XGetImage(display_, window_, x, y, 1, 1, AllPlanes, ZPixmap);
    if (!image) throw std::runtime_error("the window shows nothing");
    const unsigned long pixel = XGetPixel(image, 0, 0);
    XDestroyImage(image);
    return static_cast<int>(((pixel & 0xFF) + (pixel >> 8 & 0xFF) + (pixel >> 16 & 0xFF)) / 3);
  }

 private:
  ::Window find(::Window under, const std::string& title) {
    ::Window root = 0, parent = 0, *children = nullptr, found = 0;
    unsigned count = 0;
    if (!XQueryTree(display_, under, &root, &parent, &children, &count)) return 0;
    for (unsigned i = 0; i < count && !found; ++i) {
      char* name = nullptr;
      XWindowAttributes attributes{};
      if (XFetchName(display_, children[i], &name) && name == title &&
          XGetWindowAttributes(display_, children[i], &attributes) && attributes.map_state == IsViewable)
        found = children[i];
      if (name) XFree(name);
    }
    if (children) XFree(children);
    return found;
  }
  void move(int x, int y) {
    XWarpPointer(display_, None, window_, 0, 0, 0, 0, x, y);
    XSync(display_, False);
  }
  void button(int type, long mask) {
    XEvent event{};
    event.xbutton.button = Button1;
    event.xbutton.time = ++time_;
    send(event, type, mask);
  }
  void send(XEvent& event, int type, long mask) {
    event.xany.type = type;
    event.xany.display = display_;
    event.xany.window = window_;
    XSendEvent(display_, window_, True, mask, &event);
    XSync(display_, False);
  }

  Display* display_;
  ::Window window_ = 0;
  ::Time time_ = 0;
};

}  // namespace rotunda::tests
