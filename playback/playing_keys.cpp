#include "playback/playing_keys.h"

#include <iterator>

#include "playback/eye_control.h"

namespace rotunda::playback {
namespace {

constexpr double kSlowMotion = 0.25;

}  // namespace

Pressed PlayingKeys::press(Key key, Orbit& orbit) {
  switch (key) {
    case Key::plus:
    case Key::minus:
      zoom_by_key(key, orbit);
      return Pressed::done;
    case Key::space:
      frozen_ = !frozen_;
      return Pressed::done;
    case Key::next:
      frozen_ = true;
      return Pressed::step_on;
    case Key::previous:
      if (frozen_) return Pressed::step_back;
      slow_ = !slow_;
      return Pressed::done;
    case Key::home:
      follows_ = true;
      return Pressed::home;
    case Key::follow:
      follows_ = !follows_;
      return Pressed::follow;
    case Key::grey:
      draw_.shading = draw_.shading == Shading::grey ? Shading::colour : Shading::grey;
      return Pressed::done;
    case Key::help:
      help_ = !help_;
      return Pressed::done;
    case Key::quit:
      ended_ = true;
      return Pressed::done;
    default:
      return Pressed::own;
  }
}

Pressed PlayingKeys::press(Button button) {
  if (button == Button::start)
    frozen_ = !frozen_;
  else if (button == Button::back)
    help_ = !help_;
  else
    return Pressed::own;
  return Pressed::done;
}

double PlayingKeys::pace() const {
  if (frozen_) return 0.0;
  return slow_ ? kSlowMotion : 1.0;
}

std::vector<std::string> PlayingKeys::lines(std::string what, const std::string& rate,
                                            std::vector<std::string> own_keys) const {
  if (frozen_) what += "   frozen";
  if (slow_ && !frozen_) what += "   slow";
  std::vector<std::string> lines{what + "   " + rate};
  if (!help_) return lines;
  std::move(own_keys.begin(), own_keys.end(), std::back_inserter(lines));
  for (const char* line : {"space  freeze, then  , .  step back and on    ,  slow motion",
                           "mouse  look round, right button  shift, wheel or + -  zoom",
                           "f  follow or not    Home  from the front    g  grey    F1  this help    q  end",
                           "gamepad  right stick  look round, triggers  zoom, Start  freeze, Back  this help"})
    lines.emplace_back(line);
  return lines;
}

}  // namespace rotunda::playback
