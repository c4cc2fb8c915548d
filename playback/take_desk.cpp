#include "playback/take_desk.h"

#include <fmt/format.h>

#include <cmath>

#include "playback/eye_control.h"

namespace rotunda::playback {
namespace {

constexpr double kWinding = 4.0;  // times the take's own speed, with the stick pushed to its end

}  // namespace

TakeDesk::TakeDesk(const TakeTold& take, const Orbit& front)
    : take_(take), front_(front), orbit_(front), performer_(front.target), pictures_(take.has_pictures) {}

// Takes go round and round.
void TakeDesk::wind(double frames) {
  at_ = std::fmod(std::fmod(at_ + frames, take_.frames) + take_.frames, take_.frames);
  if (at_ >= take_.frames) at_ = 0.0;  // a tiny step back from 0, rounded
  before_ = at_;
}

void TakeDesk::step(int frames) {
  at_ = std::floor(at_);
  wind(frames);
}

void TakeDesk::toggle_pictures() {
  pictures_ = !pictures_ && take_.has_pictures;
}

void TakeDesk::go_home() {
  orbit_ = front_;
  beside_.setZero();
  look_at(performer_);
}

void TakeDesk::press(Key key) {
  switch (keys_.press(key, orbit_)) {
    case Pressed::done:
      return;
    case Pressed::step_on:
      return step(1);
    case Pressed::step_back:
      return step(-1);
    case Pressed::home:
      return go_home();
    case Pressed::follow:
      beside_ = orbit_.target - performer_;
      return;
    case Pressed::own:
      turn_by_key(key, orbit_);
      if (key == Key::pictures) toggle_pictures();
      return;
  }
}

void TakeDesk::shift(double right, double down) {
  const Eigen::Vector3d way = orbit_.shift({right, down});
  orbit_.target += way;
  beside_ += way;
}

void TakeDesk::apply(const WindowInput& input, double seconds) {
  for (const Key key : input.keys) press(key);
  for (const int digit : input.digits) go_to(std::floor(0.1 * digit * take_.frames));
  for (const Button button : input.buttons)
    if (keys_.press(button) == Pressed::own && button == Button::x) toggle_pictures();
  move_eye(input, orbit_, seconds);
  if (input.shift_x != 0.0 || input.shift_y != 0.0) shift(input.shift_x, input.shift_y);
  if (input.gamepad && std::abs(input.gamepad->left_right) > kStickDead)
    wind(kWinding * input.gamepad->left_right * take_.fps * seconds);
}

void TakeDesk::go_on(double seconds) {
  const double before = at_;
  wind(seconds * take_.fps * keys_.pace());
  before_ = before;
}

void TakeDesk::look_at(const Eigen::Vector3d& performer) {
  performer_ = performer;
  if (keys_.follows()) orbit_.target = performer_ + beside_;
}

std::vector<std::string> TakeDesk::lines(const std::string& rate) const {
  const int frame = static_cast<int>(at_);
  std::string first = fmt::format("frame {}   {:.2f} of {:.2f} s", take_.first_frame + frame, at_ / take_.fps,
                                  take_.frames / take_.fps);
  if (pictures_) first += "   cameras' colours";
  std::vector<std::string> keys{"1 to 9  go to so many tenths    arrows  look round", "gamepad  left stick  wind"};
  if (take_.has_pictures)
    keys.emplace_back("v  colours of the cameras' pictures, or stored ones    gamepad  X  the same");
  return keys_.lines(std::move(first), rate, std::move(keys));
}

}  // namespace rotunda::playback
