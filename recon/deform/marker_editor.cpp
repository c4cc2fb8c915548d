#include "recon/deform/marker_editor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

// Half of what proposed markers keep from each other: nearer than this two places on the template are the same.
constexpr double kSamePlace = 0.015;

std::string name_of(const Marker& marker) {
  return fmt::format("{} on {}", marker.number, segment_name(segment_of_triangle(marker.template_triangle)));
}

int next_number(const std::vector<Marker>& pairs) {
  int last = 0;
  for (const auto& marker : pairs) last = std::max(last, marker.number);
  return last + 1;
}

// The pairs, that of the marker's number being as the marker has it.
std::vector<Marker> with(std::vector<Marker> pairs, const Marker& marker) {
  for (auto& other : pairs)
    if (other.number == marker.number) other = marker;
  return pairs;
}

}  // namespace

MarkerEditor::MarkerEditor(const PreparedScan& scan, Markers markers)
    : scan_(scan),
      markers_(std::move(markers)),
      posed_(pose_template(markers_.fit.value().body, markers_.fit->pose)),
      mirror_(scan.mesh, *markers_.fit),
      saved_(markers_.pairs) {
  check(markers_.pairs);
}

void MarkerEditor::check(const Pairs& pairs) const {
  std::vector<std::string> missing;
  for (const auto& marker : pairs)
    if (!std::binary_search(scan_.from_triangle.begin(), scan_.from_triangle.end(), marker.scan_triangle))
      missing.push_back(fmt::format("marker {}: the scan has no triangle {}", marker.number, marker.scan_triangle));
  if (missing.empty()) return;
  const std::size_t more = missing.size() - std::min<std::size_t>(missing.size(), 10);
  missing.resize(missing.size() - more);
  throw InvalidInput(fmt::format("the markers do not fit the scan:\n  {}{}", fmt::join(missing, "\n  "),
                                 more > 0 ? fmt::format("\n  and {} more", more) : ""));
}

std::uint32_t MarkerEditor::on_prepared(const Marker& marker) const {
  const auto& from = scan_.from_triangle;
  return static_cast<std::uint32_t>(std::lower_bound(from.begin(), from.end(), marker.scan_triangle) - from.begin());
}

std::optional<std::size_t> MarkerEditor::place_of_selected() const {
  for (std::size_t i = 0; i < markers_.pairs.size(); ++i)
    if (selected_ && markers_.pairs[i].number == *selected_) return i;
  return std::nullopt;
}

const Marker* MarkerEditor::selected() const {
  const auto place = place_of_selected();
  return place ? &markers_.pairs[*place] : nullptr;
}

const Marker* MarkerEditor::mirror_of_selected() const {
  const auto* marker = selected();
  const auto twin = marker && symmetric_ ? twin_of(*marker) : std::nullopt;
  return twin ? &markers_.pairs[*twin] : nullptr;
}

void MarkerEditor::select_next(int step) {
  const auto count = static_cast<int>(markers_.pairs.size());
  if (count == 0) return;  // a template that fits badly may propose none
  const auto place = place_of_selected();
  const int from = place ? static_cast<int>(*place) : (step > 0 ? -1 : count);
  selected_ = markers_.pairs[static_cast<std::size_t>((from + step + count) % count)].number;
}

bool MarkerEditor::on_midline(std::uint32_t template_triangle) const {
  return mirror_.distance(template_triangle, mirror_.on_template(template_triangle)) < kSamePlace;
}

std::optional<std::size_t> MarkerEditor::twin_of(const Marker& marker) const {
  if (on_midline(marker.template_triangle)) return std::nullopt;
  const auto wanted = mirror_.on_template(marker.template_triangle);
  std::optional<std::size_t> twin;
  double least = kSamePlace;
  for (std::size_t i = 0; i < markers_.pairs.size(); ++i) {
    const auto& other = markers_.pairs[i];
    const double away = mirror_.distance(wanted, other.template_triangle);
    if (other.number == marker.number || away >= least) continue;
    least = away;
    twin = i;
  }
  return twin;
}

std::optional<Marker> MarkerEditor::mirrored_of(const Marker& marker, int number) const {
  const auto place = mirror_.on_scan(on_prepared(marker), segment_of_triangle(marker.template_triangle));
  if (!place) return std::nullopt;
  return Marker{number, mirror_.on_template(marker.template_triangle), scan_.from_triangle[*place]};
}

// Why the marker cannot stand as it is among the pairs, of which it is one.
std::optional<std::string> MarkerEditor::refusal(const Pairs& pairs, const Marker& marker) const {
  MarkerRules rules;
  for (const auto& other : pairs)
    if (other.number != marker.number) rules.admit(other);
  for (const auto& conflict : rules.admit(marker))
    return fmt::format("marker {} needs {}", name_of(marker), conflict.expected);
  if (const auto problem = misplacement(marker, scan_.mesh, on_prepared(marker), posed_))
    return fmt::format("marker {}: {}", name_of(marker), *problem);
  return std::nullopt;
}

MarkerEdit MarkerEditor::add(std::uint32_t template_triangle, std::uint32_t scan_triangle) {
  Pairs pairs = markers_.pairs;
  const Marker added{next_number(pairs), template_triangle, scan_.from_triangle.at(scan_triangle)};
  pairs.push_back(added);
  if (const auto why = refusal(pairs, added)) return {false, *why};
  std::string told = "made: marker " + name_of(added);
  if (!symmetric_ || on_midline(template_triangle)) return take(std::move(pairs), std::move(told));
  if (const auto there = twin_of(added))
    return take(std::move(pairs),
                told + fmt::format("; its mirror {} is there already", markers_.pairs[*there].number));
  const auto twin = mirrored_of(added, next_number(pairs));
  if (!twin) return take(std::move(pairs), told + "; alone: the scan has nothing at the mirrored place");
  pairs.push_back(*twin);
  if (const auto why = refusal(pairs, *twin)) {
    pairs.pop_back();
    return take(std::move(pairs), told + "; alone: " + *why);
  }
  return take(std::move(pairs), told + " and its mirror " + name_of(*twin));
}

// The selected pair to where `to` has it, and its twin likewise.
MarkerEdit MarkerEditor::move(const Marker& to) {
  const Pairs alone = with(markers_.pairs, to);
  std::string told = "moved: marker " + name_of(to);
  if (const auto twin = moved_twin(to)) {
    Pairs both = with(alone, *twin);
    const auto why = refusal(both, *twin);
    if (!why && !refusal(both, to)) return take(std::move(both), told + " and its mirror " + name_of(*twin));
    if (why) told += "; alone: " + *why;
  }
  if (const auto why = refusal(alone, to)) return {false, *why};
  return take(alone, std::move(told));
}

// Where the twin of the selected pair goes when that goes to `to`; nothing if there is none, or no mirrored place.
std::optional<Marker> MarkerEditor::moved_twin(const Marker& to) const {
  const auto* twin = mirror_of_selected();
  if (!twin || on_midline(to.template_triangle)) return std::nullopt;
  return mirrored_of(to, twin->number);
}

MarkerEdit MarkerEditor::move_on_template(std::uint32_t template_triangle) {
  const auto* marker = selected();
  if (!marker) return {false, "no marker is selected"};
  return move({marker->number, template_triangle, marker->scan_triangle});
}

MarkerEdit MarkerEditor::move_on_scan(std::uint32_t scan_triangle) {
  const auto* marker = selected();
  if (!marker) return {false, "no marker is selected"};
  return move({marker->number, marker->template_triangle, scan_.from_triangle.at(scan_triangle)});
}

MarkerEdit MarkerEditor::remove() {
  const auto *leaving = selected(), *twin = mirror_of_selected();
  if (!leaving) return {false, "no marker is selected"};
  std::string told = "taken away: marker " + name_of(*leaving);
  if (twin) told += " and its mirror " + name_of(*twin);
  Pairs pairs;
  for (const auto& marker : markers_.pairs)
    if (&marker != leaving && &marker != twin) pairs.push_back(marker);
  if (pairs.empty()) return {false, "one marker at least must stay"};
  return take(std::move(pairs), std::move(told));
}

MarkerEdit MarkerEditor::replace(const Pairs& pairs) {
  check(pairs);
  return take(pairs, fmt::format("{} markers", pairs.size()));
}

MarkerEdit MarkerEditor::take(Pairs pairs, std::string told) {
  before_.push_back(markers_.pairs);
  after_.clear();
  put(std::move(pairs));
  return {true, std::move(told)};
}

void MarkerEditor::put(Pairs pairs) {
  markers_.pairs = std::move(pairs);
  ++revision_;
}

MarkerEdit MarkerEditor::undo() {
  if (before_.empty()) return {false, "nothing to undo"};
  after_.push_back(markers_.pairs);
  put(std::move(before_.back()));
  before_.pop_back();
  return {true, "undone"};
}

MarkerEdit MarkerEditor::redo() {
  if (after_.empty()) return {false, "nothing to do again"};
  before_.push_back(markers_.pairs);
  put(std::move(after_.back()));
  after_.pop_back();
  return {true, "done again"};
}

}  // namespace rotunda::recon
