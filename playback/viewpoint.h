#pragma once
// The spectator's eye: a pinhole with skew and Brown-Conrady distortion (a real camera's, or none), in the frames of
// capture/camera_model.h: eye x right, y down, z forward; pixel (0, 0) is the centre of the top-left pixel.
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "capture/camera_model.h"

namespace rotunda::playback {

struct Viewpoint {
  int width = 1280, height = 720;                                                // pixels
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();                               // fx, skew, cx; 0, fy, cy; 0, 0, 1
  Eigen::Matrix<double, 5, 1> distortion = Eigen::Matrix<double, 5, 1>::Zero();  // k1 k2 p1 p2 k3
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();                               // eye_from_world
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  Eigen::Vector3d eye() const { return -R.transpose() * t; }  // in world
  // The picture shows the world as a mirror does (left-handed sets): front faces turn the other way round.
  bool mirrored() const { return R.determinant() * K(0, 0) * K(1, 1) < 0.0; }
};

// Exactly what the camera sees: its size, K, distortion and pose.
Viewpoint viewpoint_of(const capture::CameraModel& camera);

// The same eye with a picture `factor` times as large: pixel p of the small picture covers factor x factor of these.
Viewpoint magnified(const Viewpoint& viewpoint, int factor);

// An eye that goes round a target. Azimuth 0 stands on the target's +x side; the world's z is up in the picture.
struct Orbit {
  Eigen::Vector3d target = Eigen::Vector3d(0.0, 0.0, 1.0);  // world, metres
  double distance = 4.0;                                    // metres
  double azimuth = 0.0;                                     // radians, counter-clockwise seen from above
  double elevation = 0.15;                                  // radians; kept within +-85 degrees
  double field_of_view = 0.6;                               // of the picture's height, radians

  void turn(double azimuth_change, double elevation_change);
  void zoom(double factor);  // above 1 comes closer; the distance stays within 0.05 to 1000 m
  Viewpoint viewpoint(int width, int height) const;
  // The target's way, world, that shifts the picture by so much of its height, right and down.
  Eigen::Vector3d shift(const Eigen::Vector2d& heights) const;
};

// An orbit about the box's middle from where all of it is in the picture, whatever the azimuth.
Orbit orbit_around(const Eigen::AlignedBox3d& box, double field_of_view = 0.6, double aspect = 16.0 / 9.0);

// Depths of clipping, metres along the eye's z: the box lies between them, near is positive.
struct DepthRange {
  double near_plane = 0.1, far_plane = 100.0;
};
DepthRange depth_range(const Viewpoint& viewpoint, const Eigen::AlignedBox3d& box);

// GL's normalised device coordinates (y up, corners of the picture at +-1) of the ideal image plane, homogeneous:
// rows 0 and 1 times (x, y, z) in the eye's frame are clip x and y, where clip w = z.
Eigen::Matrix3d device_from_ideal(const Viewpoint& viewpoint);

// The square of the radius on the ideal image plane where the distortion folds over (1e9 if nowhere within reach).
double fold_radius_squared(const Viewpoint& viewpoint);

}  // namespace rotunda::playback
