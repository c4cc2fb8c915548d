#include "simulator/scan/scan.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "config/errors.h"
#include "simulator/people/solid_noise.h"
#include "simulator/scan/body_scanner.h"
#include "simulator/scan/dense_surface.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;
using recon::TriangleMesh;
using Triangle = std::array<std::uint32_t, 3>;

constexpr double kLeastNoise = 0.0005, kMostNoise = 0.0015;  // metres, standard deviation along the ray
constexpr double kNoiseLength = 0.008;                       // metres over which it is alike
constexpr double kSolidNoiseDeviation = 0.27;                // of solid_noise
constexpr double kPartialShift = 0.0015;                     // metres
constexpr double kPartialTurn = 0.15 * std::numbers::pi / 180.0;
constexpr double kLeastFragment = 0.001;  // of the triangles: a smaller piece is swept away, as scanners' programs do

// About normal, variance one: the sum of twelve uniform numbers.
double hashed_normal(std::int64_t i, std::int64_t j, std::uint32_t seed) {
  double sum = -6.0;
  for (std::int64_t k = 0; k < 12; ++k) sum += hashed_unit(i, j, k, seed);
  return sum;
}

const Sighting& best_sighting(const std::array<Sighting, kScannerColumns>& sightings) {
  return *std::max_element(sightings.begin(), sightings.end(), [](const Sighting& a, const Sighting& b) {
    return std::pair(a.measured, a.cosine) < std::pair(b.measured, b.cosine);
  });
}

// How far off a measurement at p is, metres along its ray. Each column makes its own mistakes.
double range_error(const Vector3d& p, float cosine, std::uint32_t seed) {
  const double deviation = std::min(kLeastNoise / std::max(static_cast<double>(cosine), 0.1), kMostNoise);
  return deviation * solid_noise(p / kNoiseLength, seed) / kSolidNoiseDeviation;
}

class Scanner {
 public:
  Scanner(TriangleMesh surface, const ScanOptions& options)
      : surface_(std::move(surface)), options_(options), sightings_(scanner_sightings(surface_, options.seed)) {}

  TriangleMesh scan() const {
    TriangleMesh scan;
    if (options_.flaws.misaligned_partials)
      for (std::size_t column = 0; column < kScannerColumns; ++column) add_partial(column, scan);
    else
      add(
          triangles_of_all(), [&](std::size_t v) { return best_sighting(sightings_[v]); }, scan, options_.seed);
    return scan;
  }

 private:
  bool measures(std::size_t column, const Triangle& t) const {
    return std::all_of(t.begin(), t.end(), [&](auto v) { return sightings_[v][column].measured; });
  }
  bool is_measured(const Triangle& t) const {
    return std::all_of(t.begin(), t.end(), [&](auto v) { return best_sighting(sightings_[v]).measured; });
  }
  // The column that faces a triangle most.
  std::size_t facing(const Triangle& t) const {
    const auto cosine = [&](std::size_t column) {
      return std::accumulate(t.begin(), t.end(), 0.0F,
                             [&](float sum, auto v) { return sum + sightings_[v][column].cosine; });
    };
    std::size_t best = 0;
    for (std::size_t column = 1; column < kScannerColumns; ++column)
      if (cosine(column) > cosine(best)) best = column;
    return best;
  }

  std::vector<Triangle> triangles_of_all() const {
    std::vector<Triangle> kept;
    for (const auto& t : surface_.triangles)
      if (!options_.flaws.holes || is_measured(t)) kept.push_back(t);
    return kept;
  }

  std::vector<Triangle> triangles_of(std::size_t column) const {
    std::vector<Triangle> kept;
    for (const auto& t : surface_.triangles) {
      bool keep = measures(column, t);
      if (!keep && !options_.flaws.holes) {  // what nobody measures still belongs to somebody
        bool seen = false;
        for (std::size_t other = 0; other < kScannerColumns; ++other) seen = seen || measures(other, t);
        keep = !seen && facing(t) == column;
      }
      if (keep) kept.push_back(t);
    }
    return kept;
  }

  void add_partial(std::size_t column, TriangleMesh& scan) const {
    const auto begin = scan.positions.size();
    const auto seed = options_.seed + 101 * (static_cast<std::uint32_t>(column) + 1);
    add(
        triangles_of(column), [&](std::size_t v) { return sightings_[v][column]; }, scan, seed);
    const auto random = [&](std::int64_t i) { return hashed_normal(i, static_cast<std::int64_t>(column), seed); };
    const Vector3d turn = kPartialTurn * Vector3d(random(0), random(1), random(2));
    const Vector3d shift = kPartialShift * Vector3d(random(3), random(4), random(5));
    const Eigen::AngleAxisd rotation(turn.norm(), turn.normalized());
    const Vector3d centre(0.0, 0.0, 0.9);
    for (auto v = begin; v < scan.positions.size(); ++v)
      scan.positions[v] = (rotation * (scan.positions[v].cast<double>() - centre) + centre + shift).cast<float>();
  }

  // Appends those triangles with their vertices, which the noise moves.
  template <class SightingOf>
  void add(const std::vector<Triangle>& triangles, const SightingOf& sighting_of, TriangleMesh& scan,
           std::uint32_t seed) const {
    std::map<std::uint32_t, std::uint32_t> number;
    for (Triangle t : triangles) {
      for (auto& v : t) {
        const auto [found, is_new] = number.try_emplace(v, static_cast<std::uint32_t>(scan.positions.size()));
        if (is_new) {
          scan.positions.push_back(measured(v, sighting_of(v), seed));
          scan.colours.push_back(surface_.colours[v]);
        }
        v = found->second;
      }
      scan.triangles.push_back(t);
    }
  }

  Eigen::Vector3f measured(std::uint32_t v, const Sighting& sighting, std::uint32_t seed) const {
    const Eigen::Vector3f& p = surface_.positions[v];
    if (!options_.flaws.noise) return p;
    return p + static_cast<float>(range_error(p.cast<double>(), sighting.cosine, seed)) * sighting.towards;
  }

  TriangleMesh surface_;
  const ScanOptions& options_;
  Sightings sightings_;
};

std::uint32_t root(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Triangles joined by edges: for each corner of each triangle the fan it belongs to, so that fans which meet in a
// vertex only become two vertices; and pieces too small to keep go.
TriangleMesh cleaned(const TriangleMesh& mesh) {
  const auto count = mesh.triangles.size();
  std::vector<std::uint32_t> piece(count), fan(3 * count);
  std::iota(piece.begin(), piece.end(), 0U);
  std::iota(fan.begin(), fan.end(), 0U);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> directed;  // edge to the corner it starts at
  const auto corner = [&](std::uint32_t c) { return mesh.triangles[c / 3][c % 3]; };
  const auto next = [](std::uint32_t c) { return c % 3 == 2 ? c - 2 : c + 1; };
  for (std::uint32_t c = 0; c < 3 * count; ++c) directed[{corner(c), corner(next(c))}] = c;
  for (std::uint32_t c = 0; c < 3 * count; ++c) {
    const auto back = directed.find({corner(next(c)), corner(c)});
    if (back == directed.end()) continue;
    const std::uint32_t other = back->second;  // starts where this edge ends
    piece[root(piece, c / 3)] = root(piece, other / 3);
    fan[root(fan, c)] = root(fan, next(other));
    fan[root(fan, next(c))] = root(fan, other);
  }
  std::vector<std::size_t> size(count);
  for (std::uint32_t t = 0; t < count; ++t) ++size[root(piece, t)];
  const auto least = static_cast<std::size_t>(kLeastFragment * static_cast<double>(count));
  TriangleMesh clean;
  std::map<std::uint32_t, std::uint32_t> number;
  for (std::uint32_t t = 0; t < count; ++t) {
    if (size[root(piece, t)] < least) continue;
    Triangle triangle{};
    for (std::uint32_t i = 0; i < 3; ++i) {
      const auto [found, is_new] =
          number.try_emplace(root(fan, 3 * t + i), static_cast<std::uint32_t>(clean.positions.size()));
      if (is_new) {
        clean.positions.push_back(mesh.positions[corner(3 * t + i)]);
        clean.colours.push_back(mesh.colours[corner(3 * t + i)]);
      }
      triangle[i] = found->second;
    }
    clean.triangles.push_back(triangle);
  }
  return clean;
}

TriangleMesh flawed_scan(const TriangleMesh& surface, const SurfaceTexture& texture, const ScanOptions& options) {
  constexpr int kTries = 5;
  auto asked = static_cast<double>(options.triangles);
  TriangleMesh scan;
  for (int i = 0; i < kTries; ++i) {  // holes take away, overlaps add: ask for as much more or less
    scan = cleaned(Scanner(dense_surface(surface, texture, static_cast<std::size_t>(asked)), options).scan());
    if (scan.triangles.empty()) throw InvalidInput("the scanner sees nothing of this person");
    const double share = static_cast<double>(options.triangles) / static_cast<double>(scan.triangles.size());
    if (std::abs(share - 1.0) < 0.005) break;
    asked *= share;
  }
  recon::compute_normals(scan);
  return scan;
}

}  // namespace

ScanFlaws scan_flaws_from(std::string_view names) {
  ScanFlaws flaws;
  while (!names.empty()) {
    const auto comma = std::min(names.find(','), names.size());
    const auto name = names.substr(0, comma);
    names.remove_prefix(std::min(comma + 1, names.size()));
    if (name == "noise")
      flaws.noise = true;
    else if (name == "holes")
      flaws.holes = true;
    else if (name == "misaligned-partials")
      flaws.misaligned_partials = true;
    else
      throw InvalidInput(fmt::format("there is no flaw '{}'; scanners have: noise, holes, misaligned-partials", name));
  }
  return flaws;
}

recon::TriangleMesh scan_of(const recon::TriangleMesh& surface, const SurfaceTexture& texture,
                            const ScanOptions& options) {
  if (options.triangles == 0) throw InvalidInput("a scan needs triangles");
  const auto& flaws = options.flaws;
  if (flaws.noise || flaws.holes || flaws.misaligned_partials) return flawed_scan(surface, texture, options);
  return dense_surface(surface, texture, options.triangles);
}

}  // namespace rotunda::simulator
