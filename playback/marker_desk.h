#pragma once
// What keys and mouse do to markers that are edited, and what the screen says of them. No window and no GL: input comes
// as values, so tests edit as hands do. The motion is played, and the eye moved, as a take's (take_desk.h).
//
// Mouse: a click on a dot selects the pair; a click on a body moves that end of the selected pair there; with none
// selected, a click on the template and one on the scan make a pair; a click beside the bodies selects none. Dragged
// along the bar below, the motion is scrubbed.
// Keys: n select none, to make pairs; Tab, Shift+Tab go through them; x or Delete takes the selected one away; u or
// Ctrl+Z undoes, r or Ctrl+Y does again; b both sides of the body or one; e residuals; t the pose of the scan or the
// motion; s or Ctrl+S saves.
#include <optional>
#include <string>
#include <vector>

#include "playback/marker_layout.h"
#include "playback/take_desk.h"
#include "recon/deform/marker_editor.h"

namespace rotunda::playback {

// What is on the screen while input comes.
struct MarkerScene {
  const recon::TriangleMesh& body;  // the template and the scan as they stand there
  const recon::TriangleMesh& scan;
  MarkerLayout layout;
};

// Half of a pair, waiting for the other.
struct PendingPair {
  std::optional<std::uint32_t> body, scan;  // triangles of the template and of the prepared scan
};

class MarkerDesk {
 public:
  // `front`: about the middle of the scan in its own pose. Keeps a reference to the editor.
  MarkerDesk(recon::MarkerEditor& editor, const TakeTold& motion, const Orbit& front);

  void apply(const WindowInput& input, const MarkerScene& scene, double seconds);
  void go_on(double seconds);  // time passes
  void look_at(const Eigen::Vector3d& performer) { motion_.look_at(performer); }
  void say(std::string message) { message_ = std::move(message); }
  bool take_save();  // it was asked for since last asked

  const recon::MarkerEditor& editor() const { return editor_; }
  std::optional<int> frame() const;  // of the motion; nothing: the scan's own pose
  double share() const { return motion_.at() / frames_; }
  const Orbit& orbit() const { return motion_.orbit(); }
  const DrawOptions& draw() const { return motion_.draw(); }
  const PendingPair& pending() const { return pending_; }
  bool shows_residuals() const { return residuals_; }
  bool moves() const { return !at_rest_ && !motion_.frozen(); }
  bool ended() const { return motion_.ended(); }
  // What is shown and selected, what came of the last step and, if asked for, the keys.
  std::vector<std::string> lines(const std::string& rate) const;

 private:
  bool press(Key key);  // false: not one of the editor's
  bool press_motion(Key key);
  void click(const MousePlace& place, const MarkerScene& scene);
  void put(MarkerSide side, std::uint32_t triangle);
  std::optional<int> dot_at(MarkerSide side, const Eigen::Vector2d& pixel, const MarkerScene& scene) const;
  void scrub(double share);
  void say(const recon::MarkerEdit& edit) { message_ = edit.told; }
  void select(std::optional<int> number);

  recon::MarkerEditor& editor_;
  TakeDesk motion_;
  const int frames_;
  PendingPair pending_;
  std::string message_;
  bool at_rest_ = true, residuals_ = false, save_ = false;
};

}  // namespace rotunda::playback
