#include "capture/calibration/board_walk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "capture/calibration/calibration_quality.h"

namespace rotunda::capture {
namespace {

constexpr int kViewsWanted = 15;          // boards a camera
constexpr int kTiesWanted = 6;            // of them together with another camera
constexpr double kRadiusWanted = 0.75;    // of the picture's, about its middle
constexpr std::size_t kPlacesMissed = 1;  // of the picture's ninths that may stay empty
constexpr double kNewPlace = 0.06;        // of the picture's longer side: so far from any board kept before
constexpr double kMovingBlur = 1.9;       // pixels: the detector's next to last level

Eigen::Vector2d middle_of(const Sighting& sighting) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& corner : sighting.corners) sum += corner.pixel;
  return sum / static_cast<double>(sighting.corners.size());
}

// A board's size and slant in the picture: root of its corners' scatter.
Eigen::Vector3d spread_of(const Sighting& sighting) {
  const Eigen::Vector2d middle = middle_of(sighting);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& corner : sighting.corners) {
    const Eigen::Vector2d off = corner.pixel - middle;
    sum += Eigen::Vector3d(off.x() * off.x(), off.y() * off.y(), off.x() * off.y());
  }
  sum /= static_cast<double>(sighting.corners.size());
  return {std::sqrt(sum.x()), std::sqrt(sum.y()), sum.z() / std::max(1.0, std::sqrt(sum.x() * sum.y()))};
}

void cover(const CameraModel& camera, const Sighting& sighting, ImageCoverage& coverage) {
  const Eigen::Vector2d size(camera.width, camera.height), middle = 0.5 * (size.array() - 1.0);
  for (const auto& corner : sighting.corners) {
    const Eigen::Array2d share = ((corner.pixel.array() + 0.5) / size.array()).max(0.0).min(1.0 - 1e-9);
    const auto x = static_cast<int>(share.x() * coverage.columns), y = static_cast<int>(share.y() * coverage.rows);
    ++coverage.corners[static_cast<std::size_t>(y * coverage.columns + x)];
    coverage.outermost_radius = std::max(coverage.outermost_radius, (corner.pixel - middle).norm() / middle.norm());
  }
}

// Camera by camera, which group of cameras it is tied to by boards seen at once.
std::vector<std::size_t> groups_of(std::size_t cameras, std::span<const Sighting> sightings) {
  std::vector<std::size_t> group(cameras);
  std::iota(group.begin(), group.end(), 0U);
  std::map<BoardKey, std::size_t> first;
  for (const auto& sighting : sightings) {
    const auto [seen, is_new] = first.try_emplace({sighting.moment, sighting.board}, sighting.camera);
    if (is_new) continue;
    const std::size_t into = group[seen->second], from = group[sighting.camera];
    std::replace(group.begin(), group.end(), from, into);
  }
  return group;
}

std::string in_words(const CameraNeed& need, const std::string& apart_from) {
  std::vector<std::string> needs;
  if (need.views < kViewsWanted) needs.push_back(fmt::format("{} more boards", kViewsWanted - need.views));
  const auto places = uncovered_places(need.coverage);
  if (uncovered_count(need.coverage) > kPlacesMissed)
    needs.push_back(places);
  else if (need.coverage.outermost_radius < kRadiusWanted)
    needs.push_back("farther into the corners");
  if (!apart_from.empty()) needs.push_back("together with " + apart_from);
  if (apart_from.empty() && need.tied_moments < kTiesWanted) needs.push_back("together with its neighbours");
  std::string text;
  for (const auto& one : needs) text += (text.empty() ? "" : "; ") + one;
  return text;
}

}  // namespace

BoardWalk::BoardWalk(std::vector<CameraModel> cameras, std::vector<Board> boards)
    : cameras_(std::move(cameras)), boards_(std::move(boards)) {}

bool BoardWalk::shows_something_new(const Sighting& sighting) const {
  const auto& camera = cameras_[sighting.camera];
  const double limit = kNewPlace * std::max(camera.width, camera.height);
  return std::none_of(kept_.begin(), kept_.end(), [&](const auto& before) {
    if (before.camera != sighting.camera || before.board != sighting.board) return false;
    const Eigen::Vector3d spread = spread_of(before) - spread_of(sighting);
    return (middle_of(before) - middle_of(sighting)).norm() < limit && spread.cwiseAbs().maxCoeff() < 0.5 * limit;
  });
}

bool BoardWalk::add(std::vector<Sighting> found) {
  std::erase_if(found, [&](const auto& s) { return s.blur_px > kMovingBlur || s.corners.empty(); });
  if (std::none_of(found.begin(), found.end(), [&](const auto& s) { return shows_something_new(s); })) return false;
  for (auto& sighting : found) {
    sighting.moment = moments_;
    kept_.push_back(std::move(sighting));
  }
  ++moments_;
  return true;
}

std::vector<CameraNeed> BoardWalk::needs() const {
  std::vector<CameraNeed> needs(cameras_.size());
  std::map<BoardKey, int> seen_by;
  for (const auto& sighting : kept_) ++seen_by[{sighting.moment, sighting.board}];
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    needs[i].camera = cameras_[i].name;
    needs[i].coverage.corners.assign(static_cast<std::size_t>(needs[i].coverage.columns * needs[i].coverage.rows), 0);
  }
  for (const auto& sighting : kept_) {
    auto& need = needs[sighting.camera];
    ++need.views;
    if (seen_by.at({sighting.moment, sighting.board}) > 1) ++need.tied_moments;
    cover(cameras_[sighting.camera], sighting, need.coverage);
  }
  const auto groups = groups_of(cameras_.size(), kept_);
  const std::set<std::size_t> different(groups.begin(), groups.end());
  for (std::size_t i = 0; i < needs.size(); ++i) {
    const auto other = std::find_if(groups.begin(), groups.end(), [&](auto group) { return group != groups[i]; });
    const bool apart = different.size() > 1 && other != groups.end();
    needs[i].needs =
        in_words(needs[i], apart ? cameras_[static_cast<std::size_t>(other - groups.begin())].name : std::string());
  }
  return needs;
}

bool BoardWalk::is_enough() const {
  const auto all = needs();
  return !all.empty() && std::all_of(all.begin(), all.end(), [](const auto& need) { return need.needs.empty(); });
}

}  // namespace rotunda::capture
