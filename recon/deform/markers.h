#pragma once
// Which triangle of the body template belongs to which triangle of a scan: the sparse correspondences of de Aguiar et
// al. 2007, section 4, numbered pairs. Here they are proposed by a template fitted to the scan (template_fit.h); in
// `markers.yaml` a person changes, adds and takes away.
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "recon/deform/template_fit.h"

namespace rotunda::recon {

struct Marker {
  int number = 0;                       // for people: unique, positive
  std::uint32_t template_triangle = 0;  // of pose_template()'s mesh
  std::uint32_t scan_triangle = 0;      // of the scan as its file numbers them
  bool operator==(const Marker&) const = default;
};

struct Markers {
  std::vector<Marker> pairs;
  double radius = 0.012;  // metres: how far about a marked triangle the scan is held, too; 0: the triangle alone
  // The body the markers are put on, where it is known: else it is fitted anew.
  std::optional<TemplateFit> fit;
};

// The segment of the body a template triangle belongs to, and its name ("forearm_left").
std::size_t segment_of_triangle(std::uint32_t template_triangle);
std::string_view segment_name(std::size_t segment);

// What markers may not be beside each other, whether they come from a file or from a person's hand.
struct MarkerConflict {
  std::string key;       // of markers.yaml
  std::string expected;  // in its place
};
class MarkerRules {
 public:
  // Takes the pair in, and says what is wrong with it beside those taken in before.
  std::vector<MarkerConflict> admit(const Marker& marker);

 private:
  std::set<int> numbers_;
  std::map<std::uint32_t, std::size_t> segment_on_scan_;
};

// Where a marked triangle is.
inline Eigen::Vector3f middle_of(const TriangleMesh& mesh, std::uint32_t triangle) {
  const auto& c = mesh.triangles[triangle];
  return (mesh.positions[c[0]] + mesh.positions[c[1]] + mesh.positions[c[2]]) / 3.0F;
}

// Why a pair cannot be meant: its triangles lie far from each other. `triangle`: the marker's in the prepared scan;
// `posed`: the fitted template as the scan stands.
std::optional<std::string> misplacement(const Marker& marker, const TriangleMesh& scan, std::uint32_t triangle,
                                        const TriangleMesh& posed);

// Reads and checks what can be checked without the scan. Throws ConfigError with every mistake: unknown keys, triangles
// the template does not have, a number twice, a scan triangle in two segments, a segment that is not its triangle's.
Markers read_markers(const std::filesystem::path& file);
// Whole or not at all. Throws std::system_error.
void write_markers(const std::filesystem::path& file, const Markers& markers, const std::string& scan);

// On every segment's middle, away from its joints, where the fitted template lies close to the scan; all that are
// found, numbered from 1. `scan`: as fitted, with normals; `number`: of its triangles in the scan's file.
Markers propose_markers(const TriangleMesh& scan, const std::vector<std::uint32_t>& number, const TemplateFit& fit);

}  // namespace rotunda::recon
