#include "simulator/people/gltf_surface.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "simulator/people/gltf_texture.h"

namespace rotunda::simulator {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// Everything that moves a vertex, as bytes: equal ones stay together for ever.
std::string motion_key(const recon::CharacterPart& part, std::size_t v) {
  std::string key;
  const auto add = [&](const void* bytes, std::size_t size) { key.append(static_cast<const char*>(bytes), size); };
  add(&part.node, sizeof part.node);
  add(&part.skin, sizeof part.skin);
  add(part.positions[v].data(), sizeof(float) * 3);
  if (!part.influences.empty()) add(part.influences[v].data(), sizeof(recon::Influences));
  for (const auto& morph : part.morphs) add(morph[v].data(), sizeof(float) * 3);
  return key;
}

// A character's vertices with one number for all that move as one: the first such vertex of all parts.
std::vector<std::uint32_t> welded(const recon::GltfCharacter& character) {
  std::unordered_map<std::string, std::uint32_t> first;
  std::vector<std::uint32_t> number;
  for (const auto& part : character.parts)
    for (std::size_t v = 0; v < part.positions.size(); ++v) {
      const auto own = static_cast<std::uint32_t>(number.size());
      number.push_back(first.try_emplace(motion_key(part, v), own).first->second);
    }
  return number;
}

// Vertices with copies of themselves: gives triangles their corners so that no edge is used twice in one direction.
class EdgeSplitter {
 public:
  explicit EdgeSplitter(CharacterSurface& surface) : surface_(surface) {}

  void add(const Triangle& corners) {
    Triangle own = corners;
    while (!fits(own))
      for (auto& corner : own) corner = next_copy(corner);
    for (std::size_t i = 0; i < 3; ++i) edges_.insert(edge(own[i], own[(i + 1) % 3]));
    surface_.figure.bind.triangles.push_back(own);
  }

 private:
  static std::uint64_t edge(std::uint32_t from, std::uint32_t to) { return (std::uint64_t{from} << 32) | to; }
  bool fits(const Triangle& t) const {
    return !edges_.contains(edge(t[0], t[1])) && !edges_.contains(edge(t[1], t[2])) &&
           !edges_.contains(edge(t[2], t[0]));
  }
  std::uint32_t next_copy(std::uint32_t vertex) {
    const auto [known, is_new] = copies_.try_emplace(vertex, static_cast<std::uint32_t>(surface_.source.size()));
    if (is_new) surface_.source.push_back(surface_.source[vertex]);
    return known->second;
  }

  CharacterSurface& surface_;
  std::unordered_set<std::uint64_t> edges_;
  std::unordered_map<std::uint32_t, std::uint32_t> copies_;  // the next copy of a vertex or copy
};

// Triangles around a vertex that hang together by edges at it are one fan; every fan but the first gets its own copy.
void split_fans(CharacterSurface& surface) {
  auto& triangles = surface.figure.bind.triangles;
  // Corners are numbered 3 t + i; those of one fan are joined (union-find).
  std::vector<std::uint32_t> fan(3 * triangles.size());
  std::iota(fan.begin(), fan.end(), 0U);
  const auto root = [&](std::uint32_t c) {
    while (fan[c] != c) c = fan[c] = fan[fan[c]];
    return c;
  };
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    fan[std::max(root(a), root(b))] = std::min(root(a), root(b));
  };
  std::unordered_map<std::uint64_t, std::uint32_t> corner_at;  // the corner an edge starts from
  for (std::uint32_t c = 0; c < fan.size(); ++c) {
    const auto& t = triangles[c / 3];
    const std::uint64_t from = t[c % 3], to = t[(c + 1) % 3];
    corner_at[(from << 32) | to] = c;
    if (const auto other = corner_at.find((to << 32) | from); other != corner_at.end()) {
      const auto next_of = [](std::uint32_t corner) { return corner - corner % 3 + (corner + 1) % 3; };
      join(c, next_of(other->second));
      join(next_of(c), other->second);
    }
  }
  std::unordered_map<std::uint32_t, std::uint32_t> first_fan;  // of a vertex
  std::unordered_map<std::uint32_t, std::uint32_t> copy_of;    // of a fan
  for (std::uint32_t c = 0; c < fan.size(); ++c) {
    auto& vertex = triangles[c / 3][c % 3];
    if (first_fan.try_emplace(vertex, root(c)).first->second == root(c)) continue;
    const auto [known, is_new] = copy_of.try_emplace(root(c), static_cast<std::uint32_t>(surface.source.size()));
    if (is_new) surface.source.push_back(surface.source[vertex]);
    vertex = known->second;
  }
}

void drop_unused(CharacterSurface& surface) {
  std::vector<std::uint32_t> number(surface.source.size(), 0);
  for (const auto& t : surface.figure.bind.triangles)
    for (const auto v : t) number[v] = 1;
  std::vector<std::uint32_t> kept;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] == 0) continue;
    number[v] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(surface.source[v]);
  }
  surface.source = std::move(kept);
  for (auto& t : surface.figure.bind.triangles)
    for (auto& v : t) v = number[v];
}

// The colour of the texture at the first corner a vertex has.
void colour_vertices(Figure& figure) {
  figure.bind.colours.assign(figure.bind.positions.size(), recon::Colour{});
  const auto& picture = figure.texture.picture;
  for (std::size_t t = figure.bind.triangles.size(); t-- > 0;)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& corner = figure.texture.corners[3 * t + i];
      const auto& texel = picture.at<cv::Vec3b>(std::clamp(static_cast<int>(corner.y()), 0, picture.rows - 1),
                                                std::clamp(static_cast<int>(corner.x()), 0, picture.cols - 1));
      figure.bind.colours[figure.bind.triangles[t][i]] = {texel[0], texel[1], texel[2]};
    }
}

}  // namespace

CharacterSurface assemble_surface(const recon::GltfCharacter& character, const std::vector<Eigen::Vector3f>& at_rest) {
  CharacterSurface surface;
  const auto number = welded(character);
  surface.source.resize(number.size());
  std::iota(surface.source.begin(), surface.source.end(), 0U);
  auto texture = character_texture(character);
  EdgeSplitter splitter(surface);
  std::uint32_t first = 0;
  std::size_t corner = 0;
  for (const auto& part : character.parts) {
    for (const auto& t : part.triangles) {
      const Triangle joined = {number[first + t[0]], number[first + t[1]], number[first + t[2]]};
      const auto from = texture.corners.begin() + static_cast<std::ptrdiff_t>(corner);
      corner += 3;
      if (joined[0] == joined[1] || joined[1] == joined[2] || joined[2] == joined[0]) continue;  // without area
      splitter.add(joined);
      surface.figure.texture.corners.insert(surface.figure.texture.corners.end(), from, from + 3);
    }
    first += static_cast<std::uint32_t>(part.positions.size());
  }
  surface.figure.texture.picture = texture.picture;
  split_fans(surface);
  drop_unused(surface);
  for (const auto v : surface.source) surface.figure.bind.positions.push_back(at_rest[v]);
  surface.figure.openness.assign(surface.source.size(), 1.0F);
  colour_vertices(surface.figure);
  return surface;
}

}  // namespace rotunda::simulator
