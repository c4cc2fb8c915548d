#pragma once
// Private to recon/sphere: the vertices of a mesh in sets of which no two are neighbours (greedy colouring in the
// vertices' order), so that a set's vertices may move side by side and the outcome does not depend on threads.
#include <algorithm>
#include <cstdint>
#include <vector>

namespace rotunda::recon {

// `ring(v)`: the neighbours of v.
template <class Ring>
std::vector<std::vector<std::uint32_t>> independent_sets(std::size_t vertex_count, const Ring& ring) {
  constexpr std::uint32_t kNone = 0xffffffff;
  std::vector<std::uint32_t> set_of(vertex_count, kNone);
  std::vector<std::uint32_t> taken_by;  // for each set the last vertex that found it among its neighbours
  std::vector<std::vector<std::uint32_t>> sets;
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    for (const auto r : ring(v))
      if (set_of[r] != kNone) taken_by[set_of[r]] = v;
    const auto free = std::find_if(taken_by.begin(), taken_by.end(), [&](std::uint32_t by) { return by != v; });
    set_of[v] = static_cast<std::uint32_t>(free - taken_by.begin());
    if (free == taken_by.end()) {
      taken_by.push_back(kNone);
      sets.emplace_back();
    }
    sets[set_of[v]].push_back(v);
  }
  return sets;
}

}  // namespace rotunda::recon
