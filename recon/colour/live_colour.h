#pragma once
// Colours of a mesh's own vertices at live quality: a few milliseconds for ten views and 10 000 vertices. As
// surface_colour.h, with two things simpler: what hides a vertex is found among the vertices themselves (those that
// face the camera, nearest one in each of a grid of their own spacing), and pixels beside the matte's outline, which
// have spill in them, are left to other views; where no other sees the place, the backdrop's channel is
// held to the others. World frame and units. Pure, and the same on any
// number of threads.
#include <span>

#include "recon/colour/surface_colour.h"

namespace rotunda::recon {

// Fills `mesh.colours`; vertices that no view sees take the colour of the nearest one that is seen, along the edges.
// Needs normals. Throws InvalidInput without them, or if a view's picture or matte is not of its camera's size.
void colour_live(TriangleMesh& mesh, std::span<const ColourView> views, capture::Backdrop backdrop);

}  // namespace rotunda::recon
