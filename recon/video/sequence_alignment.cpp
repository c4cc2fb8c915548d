#include "recon/video/sequence_alignment.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "config/errors.h"
#include "recon/sphere/relaxed_lattice.h"
#include "recon/sphere/resample.h"
#include "recon/track/body_surface.h"
#include "recon/track/rest_shape.h"
#include "recon/track/settled_surface.h"
#include "recon/track/skinned_prior.h"
#include "recon/track/surface_tracker.h"

namespace rotunda::recon {
namespace {

TriangleMesh with_normals(TriangleMesh mesh) {
  if (mesh.normals.size() != mesh.positions.size()) compute_normals(mesh);
  return mesh;
}

// Large where limbs stand free of the body or the surface is torn, small where parts are fused.
double openness(const TriangleMesh& mesh) {
  const double area = surface_area(mesh);
  return area * std::sqrt(area) / std::max(signed_volume(mesh), 1e-9);
}

double stretch_p95(const TriangleMesh& rest, const TriangleMesh& now) {
  std::vector<double> factors;
  for (const auto& t : rest.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = t[i], b = t[(i + 1) % 3];
      if (a > b) continue;  // closed: every edge comes both ways
      const double before = std::max(1e-6F, (rest.positions[a] - rest.positions[b]).norm());
      const double after = std::max(1e-6F, (now.positions[a] - now.positions[b]).norm());
      factors.push_back(std::max(before / after, after / before));
    }
  if (factors.empty()) return 1.0;
  const auto p95 = factors.begin() + static_cast<long>(0.95 * static_cast<double>(factors.size() - 1));
  std::nth_element(factors.begin(), p95, factors.end());
  return *p95;
}

AlignedFrame settled_frame(const AlignmentReference& reference, const TriangleMesh& carried,
                           const SurfaceTarget& target) {
  auto settled = settle(carried, target);
  auto image = resample(settled.mesh, reference.surface.map, reference.lattice);
  const double stretch = stretch_p95(reference.surface.mesh, settled.mesh);
  return {.surface = std::move(settled.mesh),
          .image = std::move(image),
          .residual_mean_mm = settled.residual_mean_mm,
          .residual_p95_mm = settled.residual_p95_mm,
          .stretch_p95 = stretch,
          .uncovered = settled.uncovered,
          .folds = settled.folds};
}

std::vector<std::size_t> spread_frames(std::size_t count, std::size_t most) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < std::min(most, count); ++i) chosen.push_back(i * count / std::min(most, count));
  return chosen;
}

// What frames spread over the take say of a body's shape.
std::optional<TriangleMesh> shaped(const TriangleMesh& mesh, const BodyTrack& track, const LoadSurface& load,
                                   const std::stop_token& stop) {
  constexpr std::size_t kFrames = 24;
  const SurfaceModel model(mesh);
  const SkinnedPrior prior(model, track.body, free_pose());
  RestShape shape(mesh);
  bool any = false;
  for (const auto i : spread_frames(track.poses.size(), kFrames)) {
    if (stop.stop_requested()) return std::nullopt;
    const auto loaded = load(i);
    if (!loaded || !track.poses[i]) continue;
    any = true;
    const auto surface = with_normals(*loaded);
    const auto motion = prior.posed(track.body.skeleton, *track.poses[i]);
    shape.add(model.moved(motion), SurfaceTarget(surface));
  }
  if (!any) return std::nullopt;
  return shape.refined();
}

}  // namespace

std::optional<AlignmentReference> body_reference(const BodyTrack& track, int level, const LoadSurface& load,
                                                 const std::stop_token& stop) {
  constexpr int kRounds = 2;  // the second looks along normals that the first has set right
  std::optional<TriangleMesh> mesh = body_surface(track.body, free_pose());
  for (int round = 0; round < kRounds; ++round) {
    mesh = shaped(*mesh, track, load, stop);
    if (!mesh) return std::nullopt;
  }
  auto mapped = map_to_sphere(*mesh);
  if (!mapped.map) throw InvalidInput("the body's surface has no sphere map: " + mapped.report.failure);
  AlignmentReference reference{
      .surface = {std::move(*mesh), std::move(*mapped.map)}, .lattice = {}, .body = track.body};
  reference.lattice = relaxed_lattice(reference.surface.mesh, reference.surface.map, level);
  return reference;
}

std::optional<KeyFrame> key_reference(std::size_t count, int level,
                                      const std::function<std::optional<MappedSurface>(std::size_t)>& load,
                                      const std::stop_token& stop) {
  std::vector<std::pair<double, std::size_t>> frames;
  for (std::size_t i = 0; i < count && !stop.stop_requested(); ++i)
    if (const auto surface = load(i)) frames.emplace_back(openness(surface->mesh), i);
  if (frames.empty() || stop.stop_requested()) return std::nullopt;
  std::nth_element(frames.begin(), frames.begin() + static_cast<long>(frames.size() / 2), frames.end());
  KeyFrame key{.frame = frames[frames.size() / 2].second, .reference = {}};
  auto surface = load(key.frame);
  if (!surface) return std::nullopt;
  surface->mesh = with_normals(std::move(surface->mesh));
  key.reference.lattice = relaxed_lattice(surface->mesh, surface->map, level);
  key.reference.surface = std::move(*surface);
  return key;
}

struct BodyCarrier::State {
  explicit State(const AlignmentReference& its)
      : reference(its), model(its.surface.mesh), prior(model, *its.body, free_pose()) {}
  const AlignmentReference& reference;
  SurfaceModel model;
  SkinnedPrior prior;
};

BodyCarrier::BodyCarrier(const AlignmentReference& reference) {
  if (!reference.body) throw InvalidInput("this reference is nobody's: it has no skeleton to be carried by");
  state_ = std::make_unique<State>(reference);
}

BodyCarrier::~BodyCarrier() = default;

AlignedFrame BodyCarrier::align(const TriangleMesh& surface, const Skeleton& skeleton, const Pose& pose) const {
  const auto target_mesh = with_normals(surface);
  const SurfaceTarget target(target_mesh);
  return settled_frame(state_->reference, state_->model.moved(state_->prior.posed(skeleton, pose)), target);
}

void match_sequence(std::size_t count, std::optional<GeometryImage> before, const MatchingOptions& options,
                    const std::function<std::optional<GeometryImage>(std::size_t)>& load, const FrameAligned& done,
                    const std::stop_token& stop) {
  std::optional<TriangleMesh> first;
  for (std::size_t i = 0; i < count && !stop.stop_requested(); ++i) {
    auto own = load(i);
    if (!own) continue;
    const auto own_surface = with_normals(remesh(*own));
    std::size_t folds = 0;
    if (before) {
      const auto match = match_on_sphere(*own, *before, options);
      folds = match.folds;
      own = matched_image(*own, match);
    }
    auto fit = measured(with_normals(remesh(*own)), SurfaceTarget(own_surface));
    if (!first) first = fit.mesh;
    const double stretch = stretch_p95(*first, fit.mesh);
    before = *own;
    done(i, {.surface = std::move(fit.mesh),
             .image = std::move(*own),
             .residual_mean_mm = fit.residual_mean_mm,
             .residual_p95_mm = fit.residual_p95_mm,
             .stretch_p95 = stretch,
             .uncovered = fit.uncovered,
             .folds = folds});
  }
}

void track_sequence(std::size_t count, const KeyFrame& key, const LoadSurface& load, const FrameAligned& done,
                    const std::stop_token& stop) {
  const SurfaceModel model(key.reference.surface.mesh);
  const auto walk = [&](std::ptrdiff_t from, std::ptrdiff_t direction) {
    SurfaceTracker tracker(model);
    for (auto i = from; i >= 0 && i < static_cast<std::ptrdiff_t>(count) && !stop.stop_requested(); i += direction) {
      const auto frame = static_cast<std::size_t>(i);
      const auto loaded = load(frame);
      if (!loaded) {
        tracker.skip();
        continue;
      }
      const auto surface = with_normals(*loaded);
      const SurfaceTarget target(surface);
      if (frame != key.frame) tracker.follow(target);  // of the key itself nothing has moved
      done(frame, settled_frame(key.reference, tracker.carried(), target));
    }
  };
  walk(static_cast<std::ptrdiff_t>(key.frame), 1);
  walk(static_cast<std::ptrdiff_t>(key.frame) - 1, -1);
}

}  // namespace rotunda::recon
