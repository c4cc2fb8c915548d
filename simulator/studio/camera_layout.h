#pragma once
// Where the cameras of a simulated studio stand. World frame, metres, z up; all look at the middle of the volume.
#include <Eigen/Geometry>
#include <vector>

#include "capture/camera_model.h"

namespace rotunda::simulator {

// Where performers move, metres.
inline const Eigen::AlignedBox3d kStageVolume{Eigen::Vector3d(-1.5, -1.0, 0.0), Eigen::Vector3d(1.5, 1.0, 2.0)};

struct LayoutOptions {
  int cameras = 10;               // 2 to 64; four in five stand on the ring, the rest look down from above
  int width = 720, height = 576;  // pixels
  double radius = 3.6;            // of the ring, metres
  double ring_height = 1.3;       // metres above the floor
  double aim_height = 0.95;       // of the point all look at
  double subject_height = 2.3;    // metres at the aim point that fill the picture's height
  bool whole_volume = false;      // each camera has a lens of its own that just holds kStageVolume, instead
  double rig_height = 4.5;        // of the truss: no camera hangs higher, metres
  double aspect = 1.0;            // fy / fx
  double skew_px = 0.0;           // K[0][1]
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0;  // distortion, Brown-Conrady
};

// Cameras cam00, cam01, ...; throws InvalidInput outside 2 to 64 cameras or for an empty picture.
std::vector<capture::CameraModel> camera_layout(const LayoutOptions& options = {});

// Far enough out that performers who travel are tall in the picture and never leave it: in 720 x 576 a person of 1.75 m
// amid the volume is 330 to 370 rows tall from the ring (a ring of 3.6 m with wide lenses: 250).
LayoutOptions travelling_layout(LayoutOptions options = {});

// The camera has all of the volume in its picture.
bool holds(const capture::CameraModel& camera, const Eigen::AlignedBox3d& volume);

// A camera at `centre` that looks at `target` with the world's z upwards in its picture.
capture::CameraModel look_at(const Eigen::Vector3d& centre, const Eigen::Vector3d& target, int width, int height,
                             double fx, double fy);

}  // namespace rotunda::simulator
