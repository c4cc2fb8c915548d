#pragma once
// A dense coloured scan of a person, as a body scanner would give it, perfect or with a real one's flaws. World frame,
// metres. Deterministic by seed.
#include <string_view>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "simulator/people/surface_texture.h"

namespace rotunda::simulator {

// noise: vertices move along the ray they were measured by, 0.5 mm (frontal) to 1.5 mm (slanted) standard deviation,
// correlated over 8 mm. holes: nothing where no column measures. misaligned-partials: one piece a scanner column,
// overlapping, each off by a small rigid motion (standard deviations 1.5 mm and 0.15 degrees an axis).
struct ScanFlaws {
  bool noise = false, holes = false, misaligned_partials = false;
};
// "noise,holes"; throws InvalidInput with the known flaws for another.
ScanFlaws scan_flaws_from(std::string_view names);

struct ScanOptions {
  std::size_t triangles = 264'000;
  ScanFlaws flaws;
  std::uint32_t seed = 1;
};

// Without flaws: vertices on `surface`, its topology, the very number of triangles (one more if a closed surface is
// asked for an odd number). With holes or partials the number is met within half a percent. Throws InvalidInput as
// dense_surface does, and for no triangles.
recon::TriangleMesh scan_of(const recon::TriangleMesh& surface, const SurfaceTexture& texture,
                            const ScanOptions& options = {});

}  // namespace rotunda::simulator
