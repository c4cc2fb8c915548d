#pragma once
// The fabrics, as solid textures over the bind pose: knit, denim, printed crepe, herringbone wool, with their seams,
// stitches, buttons and pockets, down to about 2 mm.
#include "simulator/people/clothing.h"

namespace rotunda::simulator {

// sRGB, 0 to 1, of a covered point. `q`: in the reference frame of garment.h. The checked shirt and its trousers are
// clothing.h's own.
Eigen::Vector3d garment_colour(const Clothing& clothing, const Eigen::Vector3d& q, const BodyPlace& place,
                               const BodyBuild& build);

}  // namespace rotunda::simulator
