#pragma once
// The colours of a body's own surface: skin, face, hands, hair, with detail down to a millimetre (pores, lashes,
// strands).
#include "simulator/people/body_shape.h"
#include "simulator/people/clothing.h"
#include "simulator/people/surface_material.h"

namespace rotunda::simulator {

// sRGB in 0 to 1; `place`: of p (person frame, metres) on the shape, of material skin or hair.
Eigen::Vector3d skin_colour(const BodyShape& shape, const Clothing& look, const Eigen::Vector3d& p,
                            const BodyPlace& place);
Eigen::Vector3d hair_colour(const BodyShape& shape, const Clothing& look, const Eigen::Vector3d& p);

// Of a point of the body's own surface, of material skin or hair: skin, eye, lip or hair.
SurfaceMaterial skin_material(const BodyShape& shape, const Eigen::Vector3d& p, const BodyPlace& place);
// Between the lids; `q` on the reference head.
bool is_eyeball(const BodyBuild& build, const Eigen::Vector3d& q);

// Eyes, brows, nose, lips and stubble over the skin's `colour`; `q` on the reference head.
Eigen::Vector3d face_colour(const BodyBuild& build, const Clothing& look, const Eigen::Vector3d& q,
                            Eigen::Vector3d colour);

}  // namespace rotunda::simulator
