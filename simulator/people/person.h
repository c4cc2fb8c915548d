#pragma once
// A synthetic person: closed surface, skin weights, texture. Person frame: metres, x forward, y left, z up, feet on the
// floor. Built from a few parameters, the same on every machine.
#include <string>
#include <string_view>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "simulator/people/body_shape.h"
#include "simulator/people/cloth.h"
#include "simulator/people/clothing.h"
#include "simulator/people/skeleton.h"
#include "simulator/people/skin_weights.h"
#include "simulator/people/surface_material.h"
#include "simulator/people/surface_texture.h"

namespace rotunda::simulator {

struct Person {
  std::string name;
  Skeleton skeleton;
  recon::TriangleMesh bind;          // A-pose; closed, one piece, no handle; colours at the vertices
  std::vector<SkinWeights> weights;  // one a vertex
  std::vector<float> openness;       // one a vertex: 1 open to all light, 0 buried
  SurfaceTexture texture;
  std::vector<SurfaceMaterial> material;  // one a vertex
  Cloth cloth;                            // what of the surface moves by itself
};

struct PersonDescription {
  std::string name;
  BodyBuild build;
  Clothing clothing;
  int texels_per_edge = 6;  // of the texture: about 2 mm a texel
  double coarseness = 1.0;  // of the surface's grid
};

// Builds the surface and paints it: about a second. Throws InvalidInput for a build that is not one closed surface.
Person make_person(const PersonDescription& description);

// One of the people that come with the simulator; throws InvalidInput with their names for another name.
Person make_person(std::string_view name);
PersonDescription describe_person(std::string_view name);
std::vector<std::string> person_names();

// The true surface in a pose: world, metres, vertex numbers as in `bind`.
recon::TriangleMesh posed_mesh(const Person& person, const Pose& pose);

}  // namespace rotunda::simulator
