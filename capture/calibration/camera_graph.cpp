#include "capture/calibration/camera_graph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "capture/calibration/camera_start.h"

namespace rotunda::capture {
namespace {

constexpr std::size_t kMostTried = 24;  // shared boards whose relative pose is tried, and by which it is judged
constexpr double kAgrees = 0.01;        // of the picture's longer side: a board transferred so near agrees
constexpr double kFarOff = 0.1;         // of it: farther off counts as this
constexpr double kElsewhere = 0.05;     // of it: first intrinsics, chained poses and a far board's pose do less

using Poses = std::vector<Eigen::Isometry3d>;

// Everything about one sighting that placing needs.
struct Posed {
  const Sighting* sighting;
  Poses camera_from_board;        // one or two
  std::vector<double> distances;  // of what each of them shows from what was seen
};
using PosedByCamera = std::vector<std::map<BoardKey, Posed>>;

// Mean distance of the sighting's corners from where a pose puts them, in shares of the picture's longer side.
double distance(const CameraModel& camera, const Sighting& sighting, const Board& board,
                const Eigen::Isometry3d& camera_from_board) {
  CameraModel at_origin = camera;
  at_origin.R = camera_from_board.linear();
  at_origin.t = camera_from_board.translation();
  const auto positions = corner_positions(board);
  double sum = 0.0;
  for (const auto& corner : sighting.corners) {
    const auto pixel = project(at_origin, positions[static_cast<std::size_t>(corner.corner)]);
    const double off = pixel ? (*pixel - corner.pixel).norm() / std::max(camera.width, camera.height) : kFarOff;
    sum += std::min(off, kFarOff);
  }
  return sum / static_cast<double>(sighting.corners.size());
}

PosedByCamera pose_all(std::span<const CameraModel> cameras, std::span<const Sighting> sightings,
                       std::span<const Board> boards) {
  PosedByCamera posed(cameras.size());
  for (const auto& sighting : sightings) {
    if (sighting.camera >= cameras.size()) continue;
    auto poses = camera_from_board(cameras[sighting.camera], sighting, boards[sighting.board]);
    if (poses.empty()) continue;
    std::vector<double> distances;
    for (const auto& pose : poses)
      distances.push_back(distance(cameras[sighting.camera], sighting, boards[sighting.board], pose));
    posed[sighting.camera][{sighting.moment, sighting.board}] = {&sighting, std::move(poses), std::move(distances)};
  }
  return posed;
}

// The same pose of a board that is listed from its other end.
Eigen::Isometry3d turned(const Eigen::Isometry3d& camera_from_board) {
  const Eigen::Isometry3d half_turn(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  return camera_from_board * half_turn;
}

// Of a board that looks the same upside down two listings fit; the nearer counts.
double distance_either_way(const CameraModel& camera, const Sighting& sighting, const Board& board,
                           const Eigen::Isometry3d& camera_from_board) {
  const double as_listed = distance(camera, sighting, board, camera_from_board);
  if (!looks_the_same_upside_down(board)) return as_listed;
  return std::min(as_listed, distance(camera, sighting, board, turned(camera_from_board)));
}

struct Shared {
  const Posed *in_a, *in_b;
};

std::vector<Shared> shared_boards(const std::map<BoardKey, Posed>& a, const std::map<BoardKey, Posed>& b) {
  std::vector<Shared> shared;
  for (const auto& [key, posed] : a)
    if (const auto other = b.find(key); other != b.end()) shared.push_back({&posed, &other->second});
  return shared;
}

std::vector<Shared> some_of(const std::vector<Shared>& all) {
  if (all.size() <= kMostTried) return all;
  std::vector<Shared> some;
  for (std::size_t i = 0; i < kMostTried; ++i) some.push_back(all[i * all.size() / kMostTried]);
  return some;
}

// How far b's corners are from where a's poses and the relative pose put them; the better of a plane's two poses. How
// far a's own are counts too: of a single board one pair of poses shows b as well as any other.
double transferred(const Shared& shared, const Eigen::Isometry3d& b_from_a, const CameraModel& b,
                   std::span<const Board> boards) {
  double best = kFarOff;
  const auto& a = *shared.in_a;
  for (std::size_t i = 0; i < a.camera_from_board.size(); ++i)
    best = std::min(
        best, a.distances[i] + distance_either_way(b, *shared.in_b->sighting, boards[shared.in_b->sighting->board],
                                                   b_from_a * a.camera_from_board[i]));
  return best;
}

Poses either_way(Poses poses, const Board& board) {
  const std::size_t n = looks_the_same_upside_down(board) ? poses.size() : 0;
  for (std::size_t i = 0; i < n; ++i) poses.push_back(turned(poses[i]));
  return poses;
}

SeenTogether tie_of(std::size_t a, std::size_t b, const PosedByCamera& posed, std::span<const CameraModel> cameras,
                    std::span<const Board> boards) {
  const auto all = shared_boards(posed[a], posed[b]);
  SeenTogether tie{.a = a, .b = b, .boards = static_cast<int>(all.size())};
  const auto some = some_of(all);
  double least = std::numeric_limits<double>::max();
  for (const auto& candidate : some)
    for (const auto& in_a : candidate.in_a->camera_from_board)
      for (const auto& in_b : either_way(candidate.in_b->camera_from_board, boards[candidate.in_b->sighting->board])) {
        const Eigen::Isometry3d b_from_a = in_b * in_a.inverse();
        double sum = 0.0;
        for (const auto& judge : some) sum += transferred(judge, b_from_a, cameras[b], boards);
        if (sum >= least) continue;
        least = sum;
        tie.b_from_a = b_from_a;
      }
  for (const auto& judge : all) tie.agreeing += transferred(judge, tie.b_from_a, cameras[b], boards) < kAgrees ? 1 : 0;
  return tie;
}

// Kruskal's maximum spanning forest: places camera after camera; returns the groups.
class Forest {
 public:
  explicit Forest(std::size_t cameras) : group_(cameras), pose_(cameras, Eigen::Isometry3d::Identity()) {
    std::iota(group_.begin(), group_.end(), 0U);
  }
  // Moves b's whole group into a's frame.
  void join(const SeenTogether& tie) {
    const std::size_t into = group_[tie.a], from = group_[tie.b];
    if (into == from) return;
    const Eigen::Isometry3d a_world_from_b_world = pose_[tie.a].inverse() * tie.b_from_a.inverse() * pose_[tie.b];
    for (std::size_t i = 0; i < group_.size(); ++i)
      if (group_[i] == from) {
        group_[i] = into;
        pose_[i] = pose_[i] * a_world_from_b_world.inverse();
      }
  }
  std::vector<std::vector<std::size_t>> groups() const {
    std::map<std::size_t, std::vector<std::size_t>> by_number;
    for (std::size_t i = 0; i < group_.size(); ++i) by_number[group_[i]].push_back(i);
    std::vector<std::vector<std::size_t>> groups;
    for (auto& [number, members] : by_number) groups.push_back(std::move(members));
    std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
    return groups;
  }
  const Eigen::Isometry3d& camera_from_world(std::size_t camera) const { return pose_[camera]; }

 private:
  std::vector<std::size_t> group_;
  std::vector<Eigen::Isometry3d> pose_;  // camera_from_world of its group
};

Eigen::Isometry3d camera_from_world(const CameraModel& camera) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = camera.R;
  pose.translation() = camera.t;
  return pose;
}

// The pose of one board at one moment that suits all its cameras best.
Eigen::Isometry3d place_board(const BoardKey& key, const PosedByCamera& posed, const RigState& state,
                              const std::vector<std::size_t>& group, const Board& board) {
  Eigen::Isometry3d best = Eigen::Isometry3d::Identity();
  double least = std::numeric_limits<double>::max();
  for (const std::size_t from : group) {
    const auto seen = posed[from].find(key);
    if (seen == posed[from].end()) continue;
    for (const auto& pose : seen->second.camera_from_board) {
      const Eigen::Isometry3d world_from_board = camera_from_world(state.cameras[from]).inverse() * pose;
      double sum = 0.0;
      for (const std::size_t in : group)
        if (const auto other = posed[in].find(key); other != posed[in].end())
          sum += distance_either_way(state.cameras[in], *other->second.sighting, board,
                                     camera_from_world(state.cameras[in]) * world_from_board);
      if (sum >= least) continue;
      least = sum;
      best = world_from_board;
    }
  }
  return best;
}

// Which cameras' listings of the board begin at the other end than its pose has it.
void append_turned(const BoardKey& key, const PosedByCamera& posed, const Board& board, CameraGraph& graph) {
  if (!looks_the_same_upside_down(board)) return;
  const auto& world_from_board = graph.state.world_from_board.at(key);
  for (const std::size_t camera : graph.groups.front()) {
    const auto seen = posed[camera].find(key);
    if (seen == posed[camera].end()) continue;
    const auto& model = graph.state.cameras[camera];
    const Eigen::Isometry3d pose = camera_from_world(model) * world_from_board;
    const auto& sighting = *seen->second.sighting;
    if (distance(model, sighting, board, turned(pose)) < distance(model, sighting, board, pose))
      graph.turned.emplace_back(camera, key);
  }
}

}  // namespace

CameraGraph place_cameras(std::span<const CameraModel> cameras, std::span<const Sighting> sightings,
                          std::span<const Board> boards) {
  const auto posed = pose_all(cameras, sightings, boards);
  CameraGraph graph;
  for (std::size_t a = 0; a < cameras.size(); ++a)
    for (std::size_t b = a + 1; b < cameras.size(); ++b) {
      const auto tie = tie_of(a, b, posed, cameras, boards);
      if (tie.boards > 0) graph.ties.push_back(tie);
    }
  auto strongest = graph.ties;
  std::stable_sort(strongest.begin(), strongest.end(),
                   [](const auto& x, const auto& y) { return x.agreeing > y.agreeing; });
  Forest forest(cameras.size());
  for (const auto& tie : strongest)
    if (tie.agreeing > 0) forest.join(tie);
  graph.groups = forest.groups();
  graph.state.cameras.assign(cameras.begin(), cameras.end());
  if (graph.groups.empty()) return graph;
  for (const std::size_t camera : graph.groups.front()) {
    graph.state.cameras[camera].R = forest.camera_from_world(camera).linear();
    graph.state.cameras[camera].t = forest.camera_from_world(camera).translation();
  }
  for (const std::size_t camera : graph.groups.front())
    for (const auto& [key, seen] : posed[camera])
      if (!graph.state.world_from_board.contains(key))
        graph.state.world_from_board[key] =
            place_board(key, posed, graph.state, graph.groups.front(), boards[key.second]);
  for (const auto& [key, pose] : graph.state.world_from_board) append_turned(key, posed, boards[key.second], graph);
  return graph;
}

bool is_as_placed(const RigState& state, const Sighting& sighting, std::span<const Board> boards) {
  const auto world_from_board = state.world_from_board.find({sighting.moment, sighting.board});
  if (world_from_board == state.world_from_board.end()) return false;
  const auto& camera = state.cameras[sighting.camera];
  const Eigen::Isometry3d pose = camera_from_world(camera) * world_from_board->second;
  return distance_either_way(camera, sighting, boards[sighting.board], pose) < kElsewhere;
}

}  // namespace rotunda::capture
