#include "playback/display/window.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLES3/gl3.h>
#include <GLFW/glfw3.h>

#include "config/errors.h"
#include "playback/display/click_finder.h"
#include "playback/display/context_reset.h"

namespace rotunda::playback {
namespace {

[[noreturn]] void fail(const std::string& what) {
  const char* reason = nullptr;
  glfwGetError(&reason);
  throw DeviceError("display", what + (reason ? std::string(" (") + reason + ")" : ""));
}

std::optional<Key> key_of(int glfw_key, int modifiers) {
  const bool shift = (modifiers & GLFW_MOD_SHIFT) != 0;
  if ((modifiers & GLFW_MOD_CONTROL) != 0) {
    if (glfw_key == GLFW_KEY_Z) return shift ? Key::redo : Key::undo;
    if (glfw_key == GLFW_KEY_Y) return Key::redo;
    if (glfw_key == GLFW_KEY_S) return Key::save;
  }
  if (glfw_key == GLFW_KEY_TAB) return shift ? Key::previous_item : Key::next_item;
  static constexpr std::pair<int, Key> kKeys[] = {
      {GLFW_KEY_LEFT, Key::left},   {GLFW_KEY_RIGHT, Key::right},    {GLFW_KEY_UP, Key::up},
      {GLFW_KEY_DOWN, Key::down},   {GLFW_KEY_SPACE, Key::space},    {GLFW_KEY_EQUAL, Key::plus},
      {GLFW_KEY_KP_ADD, Key::plus}, {GLFW_KEY_MINUS, Key::minus},    {GLFW_KEY_KP_SUBTRACT, Key::minus},
      {GLFW_KEY_PERIOD, Key::next}, {GLFW_KEY_COMMA, Key::previous}, {GLFW_KEY_HOME, Key::home},
      {GLFW_KEY_G, Key::grey},      {GLFW_KEY_Q, Key::quit},         {GLFW_KEY_ESCAPE, Key::quit},
      {GLFW_KEY_F1, Key::help},     {GLFW_KEY_M, Key::map},          {GLFW_KEY_F, Key::follow},
      {GLFW_KEY_V, Key::pictures},  {GLFW_KEY_U, Key::undo},         {GLFW_KEY_R, Key::redo},
      {GLFW_KEY_S, Key::save},      {GLFW_KEY_X, Key::remove},       {GLFW_KEY_DELETE, Key::remove},
      {GLFW_KEY_N, Key::add},       {GLFW_KEY_B, Key::both_sides},   {GLFW_KEY_E, Key::residuals},
      {GLFW_KEY_T, Key::rest}};
  for (const auto& [number, key] : kKeys)
    if (number == glfw_key) return key;
  return std::nullopt;
}

// The first device that GLFW's database knows as a gamepad. Its sticks' y axes point to the hand.
std::optional<Gamepad> gamepad_now(std::array<bool, 6>& held) {
  constexpr int kButtons[] = {GLFW_GAMEPAD_BUTTON_A, GLFW_GAMEPAD_BUTTON_B,     GLFW_GAMEPAD_BUTTON_X,
                              GLFW_GAMEPAD_BUTTON_Y, GLFW_GAMEPAD_BUTTON_START, GLFW_GAMEPAD_BUTTON_BACK};
  GLFWgamepadstate state;
  for (int device = GLFW_JOYSTICK_1; device <= GLFW_JOYSTICK_LAST; ++device) {
    if (!glfwJoystickIsGamepad(device) || !glfwGetGamepadState(device, &state)) continue;
    for (std::size_t i = 0; i < held.size(); ++i) held[i] = state.buttons[kButtons[i]] == GLFW_PRESS;
    const auto axis = [&](int which) { return static_cast<double>(state.axes[which]); };
    return Gamepad{.left_right = axis(GLFW_GAMEPAD_AXIS_LEFT_X),
                   .left_up = -axis(GLFW_GAMEPAD_AXIS_LEFT_Y),
                   .right_right = axis(GLFW_GAMEPAD_AXIS_RIGHT_X),
                   .right_up = -axis(GLFW_GAMEPAD_AXIS_RIGHT_Y),
                   .closer = 0.5 + 0.5 * axis(GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER),
                   .farther = 0.5 + 0.5 * axis(GLFW_GAMEPAD_AXIS_LEFT_TRIGGER)};
  }
  return std::nullopt;
}

}  // namespace

struct Window::Handles {
  GLFWwindow* window = nullptr;
  WindowInput input;
  double last_x = 0.0, last_y = 0.0;  // of the mouse, screen coordinates
  std::array<bool, 6> held{};         // of the gamepad's buttons
  std::optional<ContextReset> reset;

  static Handles& of(GLFWwindow* window) { return *static_cast<Handles*>(glfwGetWindowUserPointer(window)); }

  ClickFinder clicks;
  MousePlace mouse;

  // Of the mouse, in pixels of the framebuffer, which on some displays are finer than those of the screen.
  static MousePlace place_of(GLFWwindow* window, double x, double y) {
    int width = 1, height = 1, drawn_width = 1, drawn_height = 1;
    glfwGetWindowSize(window, &width, &height);
    glfwGetFramebufferSize(window, &drawn_width, &drawn_height);
    return {x * drawn_width / std::max(1, width) - 0.5, y * drawn_height / std::max(1, height) - 0.5};
  }
  static void on_button(GLFWwindow* window, int button, int action, int) {
    if (button != GLFW_MOUSE_BUTTON_LEFT) return;
    Handles& handles = of(window);
    const auto place = handles.mouse;  // by its events: it may be elsewhere by now
    if (action == GLFW_PRESS)
      handles.clicks.press(place);
    else if (const auto click = handles.clicks.release(place))
      handles.input.clicks.push_back({*click, handles.input.keys.size()});
  }
  static void on_key(GLFWwindow* window, int key, int, int action, int modifiers) {
    const auto known = key_of(key, modifiers);
    if (known && action != GLFW_RELEASE) of(window).input.keys.push_back(*known);
    if (key >= GLFW_KEY_1 && key <= GLFW_KEY_9 && action == GLFW_PRESS)
      of(window).input.digits.push_back(key - GLFW_KEY_0);
  }
  static void on_scroll(GLFWwindow* window, double, double notches) { of(window).input.scroll += notches; }
  static void on_mouse(GLFWwindow* window, double x, double y) {
    Handles& handles = of(window);
    int width = 1, height = 1;
    glfwGetWindowSize(window, &width, &height);
    const double across = (x - handles.last_x) / std::max(1, height), down = (y - handles.last_y) / std::max(1, height);
    const auto pressed = [&](int button) { return glfwGetMouseButton(window, button) == GLFW_PRESS; };
    if (pressed(GLFW_MOUSE_BUTTON_LEFT)) {
      handles.input.drag_x += across;
      handles.input.drag_y += down;
    } else if (pressed(GLFW_MOUSE_BUTTON_RIGHT) || pressed(GLFW_MOUSE_BUTTON_MIDDLE)) {
      handles.input.shift_x += across;
      handles.input.shift_y += down;
    }
    handles.mouse = place_of(window, x, y);
    handles.clicks.move(handles.mouse);
    if (const auto from = handles.clicks.held_from()) handles.input.dragged = MouseDrag{*from, handles.mouse};
    handles.last_x = x;
    handles.last_y = y;
  }
};

Window::Window(const WindowOptions& options) : handles_(std::make_unique<Handles>()) {
  if (!glfwInit())
    fail(
        "no display: set DISPLAY; or draw without one: `rotunda render` makes films, --picture a picture of what is "
        "live");
  glfwWindowHint(GLFW_CLIENT_API, GLFW_OPENGL_ES_API);
  glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_EGL_CONTEXT_API);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_DEPTH_BITS, 24);
  GLFWmonitor* monitor = options.fullscreen ? glfwGetPrimaryMonitor() : nullptr;
  const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
  // Told of a reset where the driver can tell.
  for (const int robustness : {GLFW_LOSE_CONTEXT_ON_RESET, GLFW_NO_ROBUSTNESS}) {
    glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, robustness);
    if (!handles_->window)
      handles_->window = glfwCreateWindow(mode ? mode->width : options.width, mode ? mode->height : options.height,
                                          options.title.c_str(), monitor, nullptr);
  }
  if (!handles_->window) {
    const char* reason = nullptr;
    glfwGetError(&reason);
    const std::string told = reason ? reason : "no reason given";
    glfwTerminate();
    throw DeviceError("display", "no window with OpenGL ES 3: " + told);
  }
  glfwSetWindowUserPointer(handles_->window, handles_.get());
  glfwSetKeyCallback(handles_->window, Handles::on_key);
  glfwSetScrollCallback(handles_->window, Handles::on_scroll);
  glfwSetMouseButtonCallback(handles_->window, Handles::on_button);
  glfwSetCursorPosCallback(handles_->window, Handles::on_mouse);
  glfwMakeContextCurrent(handles_->window);
  glfwSwapInterval(1);
  handles_->reset.emplace();
}

Window::~Window() {
  glfwDestroyWindow(handles_->window);
  glfwTerminate();
}

bool Window::is_open() const {
  return !glfwWindowShouldClose(handles_->window);
}

int Window::width() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(handles_->window, &width, &height);
  return width;
}

int Window::height() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(handles_->window, &width, &height);
  return height;
}

void Window::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width(), height());
}

void Window::present() {
  glfwSwapBuffers(handles_->window);
  if (handles_->reset->happened()) throw ContextLost();
  glfwPollEvents();
}

void Window::wait_for_input(double seconds) {
  glfwWaitEventsTimeout(seconds);
}

WindowInput Window::take_input() {
  const auto held = handles_->held;
  handles_->input.gamepad = gamepad_now(handles_->held);
  for (std::size_t i = 0; i < held.size(); ++i)
    if (handles_->held[i] && !held[i]) handles_->input.buttons.push_back(static_cast<Button>(i));
  return std::exchange(handles_->input, {});
}

}  // namespace rotunda::playback
