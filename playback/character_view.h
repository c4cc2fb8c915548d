#pragma once
// A character on its floor, seen by an eye that follows it: what films and windows share. Needs a current GLES 3
// context.
#include <filesystem>
#include <optional>

#include "playback/character_player.h"
#include "playback/render/character_renderer.h"
#include "playback/render/stage.h"
#include "playback/viewpoint.h"

namespace rotunda::playback {

struct CharacterViewOptions {
  std::optional<recon::Colour> background;  // not given: alpha 0 where nothing is
  bool floor = true;
  DrawOptions draw;
  int coarser = 0;  // levels of detail below the clips' own
};

class CharacterView {
 public:
  CharacterView(const std::filesystem::path& character, const recon::MotionGraph& graph);

  CharacterRenderer& renderer() { return renderer_; }
  Orbit& orbit() { return orbit_; }
  // From where the character fills the picture well, whatever it does.
  Orbit orbit_for(double aspect) const;
  // The eye's target goes after the character, evened out over a third of a second; at once after a long time.
  void follow(const Appearance& appearance, double seconds);
  // Shifts the picture by so much of its height, right and down; the eye goes on following beside the character.
  void shift(const Eigen::Vector2d& heights);
  void centre() { beside_.setZero(); }
  void draw(const Appearance& appearance, int width, int height, const CharacterViewOptions& options);

 private:
  CharacterRenderer renderer_;
  Stage stage_;
  Orbit orbit_;
  Eigen::Vector2d beside_ = Eigen::Vector2d::Zero();  // of the character, where the eye looks
};

}  // namespace rotunda::playback
