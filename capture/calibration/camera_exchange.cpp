#include "capture/calibration/camera_exchange.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>

namespace rotunda::capture {
namespace {

constexpr double kSamePlace = 0.15;                // metres
constexpr double kExchangeHelps = 0.3;             // what is left of the misfit once two names are exchanged
constexpr double kElsewhere = 0.1;                 // of a camera's sightings: worth a closer look
constexpr std::array kShares = {0.5, 0.25, 0.75};  // of the moments: earlier and later ones
constexpr std::size_t kFewest = 2;                 // of the two cameras' sightings, before as well as after
constexpr std::size_t kOneWrongIn = 10;

// Root mean square distance of the centres after rigid alignment.
double misfit(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
  return std::sqrt(
      ((T.topLeftCorner<3, 3>() * a).colwise() + T.topRightCorner<3, 1>() - b).colwise().squaredNorm().mean());
}

// Cameras of which many sightings lie elsewhere than the whole has them.
std::size_t count_suspects(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards) {
  std::map<std::size_t, std::pair<int, int>> elsewhere;  // by camera: of all
  for (const auto& sighting : sightings) {
    auto& [off, all] = elsewhere[sighting.camera];
    ++all;
    if (!is_as_placed(state, sighting, boards)) ++off;
  }
  return static_cast<std::size_t>(std::count_if(elsewhere.begin(), elsewhere.end(), [](const auto& camera) {
    return camera.second.first > kElsewhere * camera.second.second;
  }));
}

struct Halves {
  std::size_t first_later;  // moment
  CameraGraph earlier, later;
};

Halves placed_apart(std::size_t first_later, std::span<const CameraModel> cameras, std::span<const Sighting> sightings,
                    std::span<const Board> boards) {
  std::vector<Sighting> earlier, later;
  for (const auto& sighting : sightings) (sighting.moment < first_later ? earlier : later).push_back(sighting);
  return {first_later, place_cameras(cameras, earlier, boards), place_cameras(cameras, later, boards)};
}

std::optional<std::pair<std::size_t, std::size_t>> exchanged_between(const Halves& halves) {
  const auto &first = halves.earlier.groups.front(), &second = halves.later.groups.front();
  std::vector<std::size_t> both;
  std::set_intersection(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(both));
  Eigen::Matrix3Xd now(3, both.size()), then(3, both.size());
  for (std::size_t i = 0; i < both.size(); ++i) {
    then.col(static_cast<Eigen::Index>(i)) = halves.earlier.state.cameras[both[i]].centre();
    now.col(static_cast<Eigen::Index>(i)) = halves.later.state.cameras[both[i]].centre();
  }
  const auto pair = exchanged_centres(now, then);
  if (!pair) return std::nullopt;
  return std::pair{both[static_cast<std::size_t>(pair->first)], both[static_cast<std::size_t>(pair->second)]};
}

// Whether each of the two cameras' sightings is one from after the exchange, by moment, as far as that can be told.
std::multimap<std::size_t, bool> exchanged_sightings(const Halves& halves, std::size_t a, std::size_t b,
                                                     std::span<const Sighting> sightings,
                                                     std::span<const Board> boards) {
  std::multimap<std::size_t, bool> exchanged;
  for (const auto& sighting : sightings) {
    if (sighting.camera != a && sighting.camera != b) continue;
    const bool is_later = sighting.moment >= halves.first_later;
    const auto& state = (is_later ? halves.later : halves.earlier).state;
    Sighting of_other = sighting;
    of_other.camera = a + b - sighting.camera;
    const bool own = is_as_placed(state, sighting, boards), others = is_as_placed(state, of_other, boards);
    if (own != others) exchanged.emplace(sighting.moment, is_later == own);
  }
  return exchanged;
}

// The moment before which few are exchanged, and after which few are not.
std::optional<std::size_t> moment_of(const std::multimap<std::size_t, bool>& exchanged) {
  std::optional<std::size_t> best;
  std::size_t least = exchanged.size() / kOneWrongIn, before = 0, wrong = 0;
  for (const auto& [moment, is] : exchanged) wrong += is ? 0U : 1U;
  for (auto view = exchanged.begin(); view != exchanged.end();) {
    const bool both_sides = before >= kFewest && exchanged.size() - before >= kFewest;
    if (both_sides && wrong <= least) least = wrong, best = view->first;
    for (const std::size_t moment = view->first; view != exchanged.end() && view->first == moment; ++view, ++before)
      view->second ? ++wrong : --wrong;
  }
  return best;
}

}  // namespace

std::optional<std::pair<Eigen::Index, Eigen::Index>> exchanged_centres(const Eigen::Matrix3Xd& now,
                                                                       const Eigen::Matrix3Xd& then) {
  const Eigen::Index n = now.cols();
  if (n < 4) return std::nullopt;
  const double before = misfit(now, then);
  if (before < kSamePlace) return std::nullopt;
  double least = kExchangeHelps * before;
  std::optional<std::pair<Eigen::Index, Eigen::Index>> best;
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = a + 1; b < n; ++b) {
      Eigen::Matrix3Xd exchanged = then;
      exchanged.col(a).swap(exchanged.col(b));
      const double after = misfit(now, exchanged);
      if (after < least) least = after, best = {a, b};
    }
  return best;
}

std::optional<Exchange> find_exchange(const CameraGraph& graph, std::span<const CameraModel> cameras,
                                      std::span<const Sighting> sightings, std::span<const Board> boards) {
  if (count_suspects(graph.state, sightings, boards) < 2) return std::nullopt;
  std::size_t moments = 0;
  for (const auto& sighting : sightings) moments = std::max(moments, sighting.moment + 1);
  for (const double share : kShares) {
    const auto halves =
        placed_apart(static_cast<std::size_t>(share * static_cast<double>(moments)), cameras, sightings, boards);
    const auto pair = exchanged_between(halves);
    if (!pair) continue;
    const auto moment = moment_of(exchanged_sightings(halves, pair->first, pair->second, sightings, boards));
    if (moment) return Exchange{pair->first, pair->second, *moment};
  }
  return std::nullopt;
}

std::string in_words(const Exchange& exchange, std::span<const CameraModel> cameras,
                     std::span<const std::string> moments) {
  return fmt::format("{} and {} were swapped by {}: from then on one shows what the other showed",
                     cameras[exchange.a].name, cameras[exchange.b].name, moments[exchange.first_after]);
}

}  // namespace rotunda::capture
