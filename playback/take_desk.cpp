#include "playback/take_desk.h"

#include <fmt/format.h>

#include <cmath>

#include "playback/eye_control.h"

namespace rotunda::playback {
namespace {

constexpr double kSlowMotion = 0.25;
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
  frozen_ = true;
  at_ = std::floor(at_);
  wind(frames);
}

void TakeDesk::toggle_pictures() {
  pictures_ = !pictures_ && take_.has_pictures;
}

void TakeDesk::press(Key key) {
  switch (key) {
    case Key::left:
    case Key::right:
    case Key::up:
    case Key::down:
      return turn_by_key(key, orbit_);
    case Key::plus:
    case Key::minus:
      return zoom_by_key(key, orbit_);
    case Key::next:
      return step(1);
    case Key::previous:
      if (frozen_) return step(-1);
      slow_ = !slow_;
      return;
    case Key::space:
      frozen_ = !frozen_;
      return;
    case Key::home:
      orbit_ = front_;
      beside_.setZero();
      follows_ = true;
      return look_at(performer_);
    case Key::follow:
      follows_ = !follows_;
      beside_ = orbit_.target - performer_;
      return;
    case Key::pictures:
      return toggle_pictures();
    case Key::grey:
      draw_.shading = draw_.shading == Shading::grey ? Shading::colour : Shading::grey;
      return;
    case Key::map:
      return;
    case Key::help:
      help_ = !help_;
      return;
    case Key::quit:
      ended_ = true;
      return;
  }
}

void TakeDesk::press(Button button) {
  if (button == Button::start) frozen_ = !frozen_;
  if (button == Button::back) help_ = !help_;
  if (button == Button::x) toggle_pictures();
}

void TakeDesk::shift(double right, double down) {
  const Eigen::Vector3d way = orbit_.shift({right, down});
  orbit_.target += way;
  beside_ += way;
}

void TakeDesk::apply(const WindowInput& input, double seconds) {
  for (const Key key : input.keys) press(key);
  for (const int digit : input.digits) wind(std::floor(0.1 * digit * take_.frames) - at_);
  for (const Button button : input.buttons) press(button);
  move_eye(input, orbit_, seconds);
  if (input.shift_x != 0.0 || input.shift_y != 0.0) shift(input.shift_x, input.shift_y);
  if (input.gamepad && std::abs(input.gamepad->left_right) > kStickDead)
    wind(kWinding * input.gamepad->left_right * take_.fps * seconds);
}

void TakeDesk::go_on(double seconds) {
  const double before = at_;
  if (!frozen_) wind(seconds * take_.fps * (slow_ ? kSlowMotion : 1.0));
  before_ = before;
}

void TakeDesk::look_at(const Eigen::Vector3d& performer) {
  performer_ = performer;
  if (follows_) orbit_.target = performer_ + beside_;
}

std::vector<std::string> TakeDesk::lines(const std::string& rate) const {
  const int frame = static_cast<int>(at_);
  std::string first = fmt::format("frame {}   {:.2f} of {:.2f} s", take_.first_frame + frame, at_ / take_.fps,
                                  take_.frames / take_.fps);
  if (pictures_) first += "   cameras' colours";
  if (frozen_) first += "   frozen";
  if (slow_ && !frozen_) first += "   slow";
  std::vector<std::string> lines{first + "   " + rate};
  if (!help_) return lines;
  for (const char* line :
       {"space  freeze, then  , .  step back and on    ,  slow motion", "1 to 9  go to so many tenths",
        "arrows, mouse  look round, right button  shift, wheel or + -  zoom",
        "f  follow or not    Home  from the front    g  grey", "F1  this help    q  end",
        "gamepad  left stick  wind, right stick  look round, triggers  zoom"})
    lines.emplace_back(line);
  if (take_.has_pictures) lines.insert(lines.end() - 2, "v  colours of the cameras' pictures, or stored ones");
  return lines;
}

}  // namespace rotunda::playback
