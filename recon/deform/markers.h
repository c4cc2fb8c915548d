#pragma once
// Which triangle of the body template belongs to which triangle of a scan: the sparse correspondences of de Aguiar et
// al. 2007, section 4, numbered pairs. Here they are proposed by a template fitted to the scan (template_fit.h); in
// `markers.yaml` a person changes, adds and takes away.
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "recon/deform/template_fit.h"

namespace rotunda::recon {

struct Marker {
  int number = 0;                       // for people: unique, positive
  std::uint32_t template_triangle = 0;  // of pose_template()'s mesh
  std::uint32_t scan_triangle = 0;      // of the scan as its file numbers them
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

// Reads and checks what can be checked without the scan. Throws ConfigError with every mistake: unknown keys, triangles
// the template does not have, a number twice, a scan triangle in two segments, a segment that is not its triangle's.
Markers read_markers(const std::filesystem::path& file);
void write_markers(const std::filesystem::path& file, const Markers& markers, const std::string& scan);

// On every segment's middle, away from its joints, where the fitted template lies close to the scan; all that are
// found, numbered from 1. `scan`: as fitted, with normals; `number`: of its triangles in the scan's file.
Markers propose_markers(const TriangleMesh& scan, const std::vector<std::uint32_t>& number, const TemplateFit& fit);

}  // namespace rotunda::recon
