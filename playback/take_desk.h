#pragma once
// What keys, mouse and gamepad do to a take that is played, and what the screen says of it. No window and no GL: input
// comes as values, so tests play as hands do. Frames are counted from 0 and may be a fraction; seconds, metres.
//
// Beside the keys of every such window (playing_keys.h): 1 to 9 go to so many tenths; arrows go round; v the colours of
// the cameras' own pictures or the stored ones. Gamepad: the left stick winds on and back; X the pictures.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "playback/playing_keys.h"

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
  void go_on(double seconds);  // time passes; not while frozen
  void go_to(double frame) { wind(frame - at_); }
  void wait() { at_ = before_; }  // what was asked for is not there yet: back to before the last go_on()
  void look_at(const Eigen::Vector3d& performer);

  double at() const { return at_; }
  const Orbit& orbit() const { return orbit_; }
  const DrawOptions& draw() const { return keys_.draw(); }
  bool shows_pictures() const { return pictures_; }
  bool frozen() const { return keys_.frozen(); }
  bool ended() const { return keys_.ended(); }
  // Frame, rate of pictures and, if asked for, the keys.
  std::vector<std::string> lines(const std::string& rate) const;

 private:
  void press(Key key);
  void go_home();
  void step(int frames);
  void wind(double frames);
  void toggle_pictures();
  void shift(double right, double down);

  TakeTold take_;
  Orbit front_, orbit_;
  Eigen::Vector3d performer_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d beside_ = Eigen::Vector3d::Zero();  // of the performer, where the eye looks
  PlayingKeys keys_;
  double at_ = 0.0, before_ = 0.0;
  bool pictures_ = false;
};

}  // namespace rotunda::playback
