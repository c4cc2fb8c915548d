#pragma once
// What keys, mouse and gamepad do to a take that is played, and what the screen says of it. No window and no GL: input
// comes as values, so tests play as hands do. Frames are counted from 0 and may be a fraction; seconds, metres.
//
// Keys: space freezes, then , and . step a frame; , else plays a quarter as fast; 1 to 9 go to so many tenths; arrows
// and the dragged mouse go round, with the right button it shifts the picture; the wheel and + - zoom; f follows the
// performer or lets go; Home looks from the front; v the colours of the cameras' own pictures or the stored ones; g
// grey; F1 help; q or Esc ends. Gamepad: the left stick winds on and back, the right one goes round; triggers zoom;
// Start freezes; X the pictures; Back shows help.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "playback/display/window_input.h"
#include "playback/render/view_program.h"
#include "playback/viewpoint.h"

namespace rotunda::playback {

struct TakeTold {
  int frames = 1;
  int first_frame = 0;  // of the take, for people
  double fps = 25.0;
  bool has_pictures = false;  // its cameras' pictures are there to be shown
};

class TakeDesk {
 public:
  TakeDesk(const TakeTold& take, const Orbit& front);

  void apply(const WindowInput& input, double seconds);
  void go_on(double seconds);     // time passes; not while frozen
  void wait() { at_ = before_; }  // what was asked for is not there yet: back to before the last go_on()
  void look_at(const Eigen::Vector3d& performer);

  double at() const { return at_; }
  const Orbit& orbit() const { return orbit_; }
  const DrawOptions& draw() const { return draw_; }
  bool frozen() const { return frozen_; }
  bool shows_pictures() const { return pictures_; }
  bool ended() const { return ended_; }
  // Frame, rate of pictures and, if asked for, the keys.
  std::vector<std::string> lines(const std::string& rate) const;

 private:
  void press(Key key);
  void press(Button button);
  void step(int frames);
  void wind(double frames);
  void toggle_pictures();
  void shift(double right, double down);

  TakeTold take_;
  Orbit front_, orbit_;
  Eigen::Vector3d performer_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d beside_ = Eigen::Vector3d::Zero();  // of the performer, where the eye looks
  DrawOptions draw_;
  double at_ = 0.0, before_ = 0.0;
  bool frozen_ = false, slow_ = false, pictures_ = false, help_ = false, follows_ = true, ended_ = false;
};

}  // namespace rotunda::playback
