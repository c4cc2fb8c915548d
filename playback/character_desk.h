#pragma once
// What keys, mouse and gamepad do to a character that is played, and what the screen says of it. No window and no GL:
// input comes as values, so tests steer as hands do. Metres, seconds, radians.
//
// Beside the keys of every such window (playing_keys.h), of which , steps back through what was seen: 1 to 9 its states
// and actions; left, right turn it; up, down its speed; m the map. Gamepad: the left stick says where to and how fast,
// seen from the eye; A B X Y its first states and actions.
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "playback/character_player.h"
#include "playback/playing_keys.h"

namespace rotunda::playback {

class CharacterDesk {
 public:
  CharacterDesk(const recon::MotionGraph& graph, const Orbit& front);

  void apply(const WindowInput& input, CharacterPlayer& player, Orbit& orbit, double seconds);
  // What is to be seen after `seconds` more: the player goes on, or stands still, or what was seen before.
  const Appearance& go_on(CharacterPlayer& player, double seconds);
  // Shifts of the picture since last asked, in its heights, right and down.
  Eigen::Vector2d take_shift();

  bool take_home() { return std::exchange(home_, false); }  // whether the eye is to be put back

  bool ended() const { return keys_.ended(); }
  bool follows() const { return keys_.follows(); }
  bool shows_map() const { return map_; }
  const DrawOptions& draw() const { return keys_.draw(); }
  // State, rate of pictures and, if asked for, the keys.
  std::vector<std::string> lines(const CharacterPlayer& player, const std::string& rate) const;

 private:
  void press(Key key, CharacterPlayer& player, Orbit& orbit);
  void press_own(Key key, CharacterPlayer& player);
  void go_home(Orbit& orbit);
  void choose(std::size_t choice, CharacterPlayer& player);
  void change_speed(CharacterPlayer& player, double change);
  void push_stick(const Gamepad& pad, const Orbit& orbit, CharacterPlayer& player);
  void step(CharacterPlayer& player, int pictures);

  std::vector<std::string> choices_;  // behind the keys 1, 2, ...
  double fastest_ = 0.0;              // m/s, of all states
  Orbit front_;
  PlayingKeys keys_;
  std::deque<Appearance> seen_;  // the newest last
  std::size_t back_ = 0;         // so many pictures before the newest
  double speed_ = 0.0;           // asked for; 0: that of the state
  double pushed_ = 0.0;          // the last speed that the stick asked for
  Eigen::Vector2d shift_ = Eigen::Vector2d::Zero();
  bool map_ = true, home_ = false;
};

}  // namespace rotunda::playback
