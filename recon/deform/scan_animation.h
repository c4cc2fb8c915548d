#pragma once
// A scan that moves as somebody else did (de Aguiar et al. 2007, sections 4 and 5.1; ALGORITHMS step 13): markers tie
// it to the sixteen segments of the body template, whose poses turn and carry it (poisson_deform.h). The motion's turns
// are taken as they are, its path as long as the scan's legs are (body_motion.h), so that bodies of any build share
// motions. World frame, metres, floor at z = 0.
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "recon/body/body_motion.h"
#include "recon/body/captured_motion.h"
#include "recon/deform/markers.h"
#include "recon/deform/poisson_deform.h"
#include "recon/deform/scan_preparation.h"

namespace rotunda::recon {

struct ScanAnimationOptions {
  bool as_paper = false;  // marked triangles alone, nothing held in place, volume left to itself, signs as they come
};

class ScanAnimation {
 public:
  // `markers`: with the fit they belong to. Throws InvalidInput that tells every marker naming a triangle the scan has
  // not, one of two segments' and far from where the template has it, and if no marker is left.
  ScanAnimation(PreparedScan scan, const Markers& markers, const ScanAnimationOptions& options = {});

  const TriangleMesh& rest() const { return scan_.mesh; }
  const TemplateFit& fit() const { return fit_; }
  const std::vector<std::string>& notes() const { return notes_; }
  const HandleShares& shares() const { return deform_->shares(); }
  DeformClock clock() const { return deform_->clock(); }

  // What carries each segment from the scan's pose into each of the motion's: frames x kBodySegments, signs agreed.
  std::vector<HandlePose> handle_poses(const BodyMotion& motion) const;
  // The same for the performer's own scan where they were seen: every joint is put where theirs was, in the studio, so
  // that the take's pictures fall onto the scan (3D video, section 5.2).
  std::vector<HandlePose> handle_poses_in_studio(const CapturedMotion& motion) const;
  // The surface in each: frames x vertices, frame by frame; `poses` as above.
  void deform(std::span<const HandlePose> poses, std::span<Eigen::Vector3f> positions) {
    deform_->deform(poses, positions);
  }
  // How far held vertices lie from where their segment takes them, the worst of them, metres.
  double drift(std::span<const HandlePose> poses, std::span<const Eigen::Vector3f> positions) const;

 private:
  void carry_handles(const JointTransforms& posed, std::vector<HandlePose>& poses) const;

  PreparedScan scan_;
  TemplateFit fit_;
  std::vector<std::string> notes_;
  std::vector<HeldVertex> held_;
  bool as_paper_ = false;
  std::unique_ptr<PoissonDeform> deform_;
};

// The handle above each in the tree of segments; -1 for the pelvis.
std::span<const int> segment_parents();

}  // namespace rotunda::recon
