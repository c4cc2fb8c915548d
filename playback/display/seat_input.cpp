#include "playback/display/seat_input.h"

#include <fcntl.h>
#include <libinput.h>
#include <libudev.h>
#include <linux/input-event-codes.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace rotunda::playback {
namespace {

using Clock = std::chrono::steady_clock;

// As desktops do.
constexpr auto kRepeatDelay = std::chrono::milliseconds(400);
constexpr auto kRepeatPeriod = std::chrono::milliseconds(40);

constexpr libinput_interface kPlainFiles = {.open_restricted =
                                                [](const char* path, int flags, void*) {
                                                  const int fd = ::open(path, flags | O_CLOEXEC);
                                                  return fd < 0 ? -errno : fd;
                                                },
                                            .close_restricted = [](int fd, void*) { ::close(fd); }};

struct Unref {
  void operator()(udev* object) const noexcept { udev_unref(object); }
  void operator()(libinput* object) const noexcept { libinput_unref(object); }
  void operator()(libinput_event* object) const noexcept { libinput_event_destroy(object); }
};

}  // namespace

std::optional<Key> key_of_evdev(unsigned code) {
  static constexpr std::pair<unsigned, Key> kKeys[] = {
      {KEY_LEFT, Key::left},     {KEY_RIGHT, Key::right}, {KEY_UP, Key::up},          {KEY_DOWN, Key::down},
      {KEY_SPACE, Key::space},   {KEY_EQUAL, Key::plus},  {KEY_KPPLUS, Key::plus},    {KEY_MINUS, Key::minus},
      {KEY_KPMINUS, Key::minus}, {KEY_HOME, Key::home},   {KEY_G, Key::grey},         {KEY_Q, Key::quit},
      {KEY_ESC, Key::quit},      {KEY_DOT, Key::next},    {KEY_COMMA, Key::previous}, {KEY_F1, Key::help},
      {KEY_F, Key::follow},      {KEY_V, Key::pictures},  {KEY_M, Key::map}};
  const auto* found = std::ranges::find(kKeys, code, &std::pair<unsigned, Key>::first);
  return found == std::end(kKeys) ? std::nullopt : std::optional(found->second);
}

struct SeatInput::State {
  std::unique_ptr<udev, Unref> devices;
  std::unique_ptr<libinput, Unref> input;
  int keyboards = 0;
  WindowInput gathered;
  bool left = false, other = false;  // buttons of the mouse that are down
  std::optional<std::pair<unsigned, Key>> held;
  Clock::time_point repeat_at;

  void count(libinput_event* event, int change) {
    if (libinput_device_has_capability(libinput_event_get_device(event), LIBINPUT_DEVICE_CAP_KEYBOARD))
      keyboards += change;
  }
  void key(libinput_event_keyboard* event) {
    const unsigned code = libinput_event_keyboard_get_key(event);
    const bool down = libinput_event_keyboard_get_key_state(event) == LIBINPUT_KEY_STATE_PRESSED;
    if (!down && held && held->first == code) held.reset();
    const auto known = key_of_evdev(code);
    if (!down || !known) return;
    gathered.keys.push_back(*known);
    held = {code, *known};
    repeat_at = Clock::now() + kRepeatDelay;
  }
  void button(libinput_event_pointer* event) {
    const bool down = libinput_event_pointer_get_button_state(event) == LIBINPUT_BUTTON_STATE_PRESSED;
    (libinput_event_pointer_get_button(event) == BTN_LEFT ? left : other) = down;
  }
  void motion(libinput_event_pointer* event, int height) {
    const double across = libinput_event_pointer_get_dx(event) / height,
                 down = libinput_event_pointer_get_dy(event) / height;
    if (left) {
      gathered.drag_x += across;
      gathered.drag_y += down;
    } else if (other) {
      gathered.shift_x += across;
      gathered.shift_y += down;
    }
  }
  void wheel(libinput_event_pointer* event) {
    constexpr double kNotch = 120.0;  // as libinput counts, towards the hand
    if (libinput_event_pointer_has_axis(event, LIBINPUT_POINTER_AXIS_SCROLL_VERTICAL))
      gathered.scroll -=
          libinput_event_pointer_get_scroll_value_v120(event, LIBINPUT_POINTER_AXIS_SCROLL_VERTICAL) / kNotch;
  }
  void take(libinput_event* event, int height) {
    switch (libinput_event_get_type(event)) {
      case LIBINPUT_EVENT_DEVICE_ADDED:
        return count(event, 1);
      case LIBINPUT_EVENT_DEVICE_REMOVED:
        return count(event, -1);
      case LIBINPUT_EVENT_KEYBOARD_KEY:
        return key(libinput_event_get_keyboard_event(event));
      case LIBINPUT_EVENT_POINTER_BUTTON:
        return button(libinput_event_get_pointer_event(event));
      case LIBINPUT_EVENT_POINTER_MOTION:
        return motion(libinput_event_get_pointer_event(event), height);
      case LIBINPUT_EVENT_POINTER_SCROLL_WHEEL:
        return wheel(libinput_event_get_pointer_event(event));
      default:
        return;
    }
  }
};

SeatInput::SeatInput() : state_(std::make_unique<State>()) {
  state_->devices.reset(udev_new());
  if (!state_->devices) return;
  state_->input.reset(libinput_udev_create_context(&kPlainFiles, nullptr, state_->devices.get()));
  if (state_->input && libinput_udev_assign_seat(state_->input.get(), "seat0") != 0) state_->input.reset();
  read(1);
}

SeatInput::~SeatInput() = default;

bool SeatInput::has_keyboard() const {
  return state_->keyboards > 0;
}

int SeatInput::fd() const {
  return state_->input ? libinput_get_fd(state_->input.get()) : -1;
}

void SeatInput::read(int height) {
  if (!state_->input) return;
  libinput_dispatch(state_->input.get());
  while (const std::unique_ptr<libinput_event, Unref> event{libinput_get_event(state_->input.get())})
    state_->take(event.get(), std::max(1, height));
}

WindowInput SeatInput::take() {
  for (const auto now = Clock::now(); state_->held && state_->repeat_at <= now; state_->repeat_at += kRepeatPeriod)
    state_->gathered.keys.push_back(state_->held->second);
  return std::exchange(state_->gathered, {});
}

}  // namespace rotunda::playback
