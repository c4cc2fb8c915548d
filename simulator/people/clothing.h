#pragma once
// What a person wears, as a solid texture over the bind pose (Peachey; Perlin; both 1985): a colour for every point of
// the surface, with detail down to about 4 mm: weave, checks, seams, buttons, laces, strands of hair, the face.
#include <Eigen/Core>

#include "recon/mesh/triangle_mesh.h"
#include "simulator/people/body_shape.h"

namespace rotunda::simulator {

struct Clothing {
  recon::Colour skin{214, 165, 140}, hair{74, 50, 32}, iris{92, 66, 40}, lips{186, 108, 98};
  double stubble = 0.35, blush = 0.8, freckles = 0.04;  // 0 to 1
  recon::Colour shirt{158, 38, 40}, shirt_check{46, 38, 40}, shirt_line{226, 206, 160};
  recon::Colour trousers{158, 134, 98}, shoe{92, 58, 36}, sole{58, 50, 44}, belt{46, 34, 30};
  double check = 0.052;  // period of the shirt's checks, metres
};

// sRGB in 0 to 1 of a point on (or within millimetres of) the surface of `shape`.
// `place`: of p on the shape.
Eigen::Vector3d colour_at(const BodyShape& shape, const Clothing& clothing, const Eigen::Vector3d& p,
                          const BodyPlace& place);

}  // namespace rotunda::simulator
