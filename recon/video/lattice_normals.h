#pragma once
// Normals of a closed octahedral lattice, read off its positions: the area-weighted mean of the quads around each
// sample, those beyond the border taken by the lattice's own rule (sample i of a border line is sample N-1-i; the four
// corners are one point), so that both copies of a border sample agree. (Central differences vanish at the middle of
// a border line, where the lattice folds onto itself.)
#include <Eigen/Core>
#include <vector>

namespace rotunda::recon {

// Unit, outwards; (0, 0, 1) where the surface has no extent. `positions` row by row, (2^level + 1)^2.
std::vector<Eigen::Vector3f> lattice_normals(const std::vector<Eigen::Vector3f>& positions, int level);

}  // namespace rotunda::recon
