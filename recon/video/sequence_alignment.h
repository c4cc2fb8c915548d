#pragma once
// Temporal alignment (ALGORITHMS step 8): a take's surfaces, each reconstructed on its own, to a sequence in which
// every sample is the same point of the performer in every frame. One reference surface is carried onto every frame's.
// A person's is carried by the skeleton (track/skinned_prior.h), which cannot drift nor swap left and right, and
// settles on each frame's surface along its normals (track/settled_surface.h); anything else is followed from frame to
// frame by an embedded-deformation graph (track/surface_tracker.h). The lattice is the reference's in all frames:
// one-to-one on the sphere. World frame, metres. Pure; the same result on any number of threads.
#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "recon/body/body_track.h"
#include "recon/frame_store.h"
#include "recon/sphere/geometry_image.h"
#include "recon/sphere/spherical_matching.h"

namespace rotunda::recon {

// What is carried. Images of it are all sampled at the same points of it.
struct AlignmentReference {
  MappedSurface surface;                 // with normals
  std::vector<Eigen::Vector3d> lattice;  // directions on the sphere, raster order
  std::optional<BodyTemplate> body;      // of a person: who stands there in free_pose() (track/body_surface.h)
};

struct AlignedFrame {
  TriangleMesh surface;                                  // the reference, carried here; with normals
  GeometryImage image;                                   // of it; colours and coverage left for the caller
  double residual_mean_mm = 0.0, residual_p95_mm = 0.0;  // of the surface carried to the frame's own, by area
  double stretch_p95 = 1.0;  // 95 % of its edges are longer or shorter than the reference's by less than this factor
  double uncovered = 0.0;    // share of the frame's own area farther than 50 mm from the surface carried
  std::size_t folds = 0;     // its triangles that face against the surface around them
};

// A frame's own surface; none where the frame failed.
using LoadSurface = std::function<std::optional<TriangleMesh>(std::size_t)>;
using FrameAligned = std::function<void(std::size_t, const AlignedFrame&)>;

// The body template made into what the take's frames show: a shape that no single frame's flaws are in, with arms and
// legs apart. The track has no gaps (steadied()). Nothing if no frame can be loaded, or asked to stop.
// Throws InvalidInput if the body is none (body_surface.h).
std::optional<AlignmentReference> body_reference(const BodyTrack& track, int level, const LoadSurface& load,
                                                 const std::stop_token& stop = {});
// Without a skeleton: the surface of one frame. Of many: the one that is neither fused (limbs at the body, small for
// what it holds) nor torn (large), the median of that. Nothing if no frame can be loaded, or asked to stop.
struct KeyFrame {
  std::size_t frame = 0;
  AlignmentReference reference;
};
std::optional<KeyFrame> key_reference(std::size_t count, int level,
                                      const std::function<std::optional<MappedSurface>(std::size_t)>& load,
                                      const std::stop_token& stop = {});

// A person's reference carried to one frame.
class BodyCarrier {
 public:
  explicit BodyCarrier(const AlignmentReference& reference);  // kept; throws InvalidInput if it has no body
  ~BodyCarrier();
  BodyCarrier(const BodyCarrier&) = delete;
  BodyCarrier& operator=(const BodyCarrier&) = delete;

  AlignedFrame align(const TriangleMesh& surface, const Skeleton& skeleton, const Pose& pose) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// As the first paper has it (SMH 4, figure 2): every frame's own geometry image matched on the sphere to the one
// before, as that was matched; the first of them to `before`, if given. Images come with their colours.
void match_sequence(std::size_t count, std::optional<GeometryImage> before, const MatchingOptions& options,
                    const std::function<std::optional<GeometryImage>(std::size_t)>& load, const FrameAligned& done,
                    const std::stop_token& stop = {});

// From the key frame on to both ends. Calls `done` once for each frame that could be loaded. Asked to stop, it leaves
// the rest undone.
void track_sequence(std::size_t count, const KeyFrame& key, const LoadSurface& load, const FrameAligned& done,
                    const std::stop_token& stop = {});

}  // namespace rotunda::recon
