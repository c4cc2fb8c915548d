#pragma once
// The empty studio (painted_room.h) as one camera sees it, and the shade that figures throw on its floor. World frame,
// metres.
#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "capture/camera_model.h"
#include "recon/mesh/triangle_mesh.h"
#include "simulator/studio/painted_room.h"
#include "simulator/studio/shadow.h"

namespace rotunda::simulator {

struct Backdrop {
  cv::Mat linear;  // CV_32FC3, red, green, blue: what the camera sees without anyone on the stage
  cv::Mat floor;   // CV_32FC2: x and y of the floor point at each pixel; far away where there is wall
  // How much faster than the paint's own channel each goes in shadow: eighths of a power of the light.
  std::array<std::size_t, 3> fading{2, 1, 0};
};
// The same with a wall that stands behind all cameras.
BackdropOptions room_around(const std::vector<capture::CameraModel>& cameras, BackdropOptions options);

Backdrop make_backdrop(const capture::CameraModel& camera, const BackdropOptions& options = {});

// How much of the light reaches the floor beside a body: 1 all, 0 none.
struct ContactShadow {
  cv::Mat light;                                  // CV_32FC1, rows along y, columns along x
  double from_x = 0.0, from_y = 0.0, cell = 0.0;  // metres: the middle of the first sample; sample spacing
  float at(float x, float y) const;               // bilinear; 1 outside
};
ContactShadow contact_shadow(const std::vector<recon::TriangleMesh>& surfaces, const ShadowMaps& maps);

// Backdrop with the shadow on it, in `picture` (a copy of backdrop.linear); shadow on blue paint is bluer, for it is
// filled with light off the paint.
void lay_shadow(const Backdrop& backdrop, const ContactShadow& shadow, cv::Mat& picture);

}  // namespace rotunda::simulator
