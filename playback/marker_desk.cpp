#include "playback/marker_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "playback/surface_pick.h"

namespace rotunda::playback {
namespace {

constexpr double kDotReach = 9.0;    // pixels about a dot that are the dot
constexpr double kDotBehind = 0.02;  // metres that a dot may lie behind the surface in front of it
constexpr const char* kOwnKeys[] = {
    "click a dot  selects its pair    then a body  moves that end of it",
    "n, or beside the bodies  none selected: then template and scan  make a pair",
    "Tab  Shift+Tab  through the pairs    x  takes it away    b  both sides of the body or one",
    "u  undo    r  again    s  save    e  residuals",
    "t  as scanned or in the motion    drag the bar below  scrub",
};

}  // namespace

MarkerDesk::MarkerDesk(recon::MarkerEditor& editor, const TakeTold& motion, const Orbit& front)
    : editor_(editor), motion_(motion, front), frames_(motion.frames) {
  motion_.apply({.keys = {Key::space, Key::grey}}, 0.0);  // still, and plain, until asked
}

std::optional<int> MarkerDesk::frame() const {
  if (at_rest_) return std::nullopt;
  return static_cast<int>(motion_.at());
}

void MarkerDesk::go_on(double seconds) {
  if (!at_rest_) motion_.go_on(seconds);
}

bool MarkerDesk::take_save() {
  return std::exchange(save_, false);
}

void MarkerDesk::select(std::optional<int> number) {
  editor_.select(number);
  pending_ = {};
  message_.clear();
}

// Keys of the motion leave the scan's own pose first.
bool MarkerDesk::press_motion(Key key) {
  if (key == Key::rest) {
    at_rest_ = !at_rest_;
    return true;
  }
  const bool moves = key == Key::space || key == Key::next || key == Key::previous;
  if (!at_rest_ || !moves) return false;
  at_rest_ = false;
  return key != Key::space || !motion_.frozen();
}

bool MarkerDesk::press(Key key) {
  switch (key) {
    case Key::undo:
      say(editor_.undo());
      return true;
    case Key::redo:
      say(editor_.redo());
      return true;
    case Key::remove:
      say(editor_.remove());
      return true;
    case Key::add:
      select(std::nullopt);
      return true;
    case Key::next_item:
    case Key::previous_item:
      pending_ = {};
      editor_.select_next(key == Key::next_item ? 1 : -1);
      return true;
    case Key::both_sides:
      editor_.set_symmetric(!editor_.symmetric());
      return true;
    case Key::residuals:
      residuals_ = !residuals_;
      return true;
    case Key::save:
      save_ = true;
      return true;
    default:
      return press_motion(key);
  }
}

// The visible dot nearest to the pixel.
std::optional<int> MarkerDesk::dot_at(MarkerSide side, const Eigen::Vector2d& pixel, const MarkerScene& scene) const {
  const auto& mesh = side == MarkerSide::body ? scene.body : scene.scan;
  const auto eye = scene.layout.viewpoint(side, orbit());
  std::optional<int> found;
  double nearest = kDotReach;
  for (const auto& marker : editor_.markers().pairs) {
    const auto triangle = side == MarkerSide::body ? marker.template_triangle : editor_.on_prepared(marker);
    const Eigen::Vector3d place = recon::middle_of(mesh, triangle).cast<double>();
    if (outwards(mesh, triangle).cast<double>().dot(eye.eye() - place) <= 0.0) continue;
    const auto seen = seen_at(eye, place);
    if (!seen || (seen->head<2>() - pixel).norm() >= nearest) continue;
    const auto front = pick(mesh, eye, seen->head<2>());
    if (front && front->depth < seen->z() - kDotBehind) continue;
    nearest = (seen->head<2>() - pixel).norm();
    found = marker.number;
  }
  return found;
}

void MarkerDesk::click(const MousePlace& place, const MarkerScene& scene) {
  if (scene.layout.in_bar(place)) return scrub(scene.layout.share(place));
  const auto side = scene.layout.side_of(place);
  const auto pixel = scene.layout.within(side, place);
  if (!pending_.body && !pending_.scan)
    if (const auto dot = dot_at(side, pixel, scene)) return select(dot);
  const auto hit =
      pick(side == MarkerSide::body ? scene.body : scene.scan, scene.layout.viewpoint(side, orbit()), pixel);
  if (!hit) return select(std::nullopt);
  put(side, hit->triangle);
}

// The selected pair's end, or a half of a new pair.
void MarkerDesk::put(MarkerSide side, std::uint32_t triangle) {
  if (editor_.selected())
    return say(side == MarkerSide::body ? editor_.move_on_template(triangle) : editor_.move_on_scan(triangle));
  (side == MarkerSide::body ? pending_.body : pending_.scan) = triangle;
  if (pending_.body && pending_.scan) {
    say(editor_.add(*pending_.body, *pending_.scan));
    pending_ = {};
  } else {
    say(fmt::format("now its place on the {}", side == MarkerSide::body ? "scan" : "template"));
  }
}

void MarkerDesk::scrub(double share) {
  at_rest_ = false;
  motion_.go_to(std::clamp(std::floor(share * frames_), 0.0, frames_ - 1.0));
}

void MarkerDesk::apply(const WindowInput& input, const MarkerScene& scene, double seconds) {
  WindowInput rest = input;
  rest.keys.clear();
  std::size_t pressed = 0;
  const auto press_until = [&](std::size_t end) {
    for (; pressed < std::min(end, input.keys.size()); ++pressed)
      if (!press(input.keys[pressed])) rest.keys.push_back(input.keys[pressed]);
  };
  for (const auto& [at, after_keys] : input.clicks) {
    press_until(after_keys);
    click(at, scene);
  }
  press_until(input.keys.size());
  if (!input.digits.empty()) at_rest_ = false;
  if (input.dragged && scene.layout.in_bar(input.dragged->from)) {
    scrub(scene.layout.share(input.dragged->to));
    rest.drag_x = rest.drag_y = 0.0;
  }
  motion_.apply(rest, seconds);
}

std::vector<std::string> MarkerDesk::lines(const std::string& rate) const {
  auto lines = motion_.lines(rate);
  if (at_rest_) lines[0] = "as scanned   " + rate;
  const auto& pairs = editor_.markers().pairs;
  std::string state = fmt::format("{} markers   {}", pairs.size(), editor_.symmetric() ? "both sides" : "one side");
  if (const auto* marker = editor_.selected())
    state += fmt::format("   selected: {} on {}", marker->number,
                         recon::segment_name(recon::segment_of_triangle(marker->template_triangle)));
  if (const auto* mirror = editor_.mirror_of_selected()) state += fmt::format(", with {}", mirror->number);
  state += editor_.changed() ? "   not saved" : "";
  lines.insert(lines.begin() + 1, state);
  const bool help = lines.size() > 2;
  if (help) lines.insert(lines.begin() + 2, std::begin(kOwnKeys), std::end(kOwnKeys));
  if (!message_.empty()) lines.insert(lines.begin() + 2, message_);
  if (!help) lines.emplace_back("F1  keys");
  return lines;
}

}  // namespace rotunda::playback
