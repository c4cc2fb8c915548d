#pragma once
// What keys and buttons do alike in every window that plays something: freeze, step, slow motion, zoom, follow, grey,
// help, end; and how the screen tells of them. A window's own keys are its desk's (take_desk, character_desk). To add a
// common key: here, and `Key` with `key_of` in display/window.cpp.
#include <string>
#include <vector>

#include "playback/display/window_input.h"
#include "playback/render/view_program.h"
#include "playback/viewpoint.h"

namespace rotunda::playback {

// What is left for the desk to do.
enum class Pressed { own, done, step_on, step_back, home, follow };

class PlayingKeys {
 public:
  // `own`: the desk's to know. Steps freeze; home follows again; follow has been changed.
  Pressed press(Key key, Orbit& orbit);
  Pressed press(Button button);

  bool frozen() const { return frozen_; }
  bool follows() const { return follows_; }
  bool ended() const { return ended_; }
  double pace() const;  // times real time: 0 frozen, a quarter slow, 1
  const DrawOptions& draw() const { return draw_; }
  // What is played and how, the rate of pictures and, if asked for, the keys: the window's own, then the common ones.
  std::vector<std::string> lines(std::string what, const std::string& rate, std::vector<std::string> own_keys) const;

 private:
  DrawOptions draw_;
  bool frozen_ = false, slow_ = false, help_ = false, follows_ = true, ended_ = false;
};

}  // namespace rotunda::playback
