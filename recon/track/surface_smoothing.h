#pragma once
// Values on a surface evened out over its vertices' neighbours.
#include <cstddef>
#include <vector>

#include "recon/mesh/vertex_rings.h"

namespace rotunda::recon {

// Each sweep, every value becomes half itself and half the mean of its neighbours'.
template <class Value>
void even_out(const VertexRings& rings, int sweeps, std::vector<Value>& values) {
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const auto before = values;
    for (std::size_t v = 0; v < values.size(); ++v) {
      if (rings[v].empty()) continue;
      Value sum = 0.0 * before[v];
      for (const auto neighbour : rings[v]) sum += before[neighbour];
      values[v] = Value(0.5 * before[v] + 0.5 / static_cast<double>(rings[v].size()) * sum);
    }
  }
}

}  // namespace rotunda::recon
