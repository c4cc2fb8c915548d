#include "recon/sphere/sphere_file.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <system_error>

#include "config/errors.h"

namespace rotunda::recon {

void write_sphere_ply(const std::filesystem::path& file, const TriangleMesh& mesh, const SphereMap& map) {
  if (map.points.size() != mesh.positions.size())
    throw InvalidInput(fmt::format("a sphere map of {} points is not one of a mesh of {} vertices", map.points.size(),
                                   mesh.positions.size()));
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      map.points.size(), mesh.triangles.size());
  auto out = std::back_inserter(text);
  for (const auto& p : map.points) fmt::format_to(out, "{:.17g} {:.17g} {:.17g}\n", p.x(), p.y(), p.z());
  for (const auto& t : mesh.triangles) fmt::format_to(out, "3 {} {} {}\n", t[0], t[1], t[2]);
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream.flush())
    throw std::system_error(std::make_error_code(std::errc::io_error), "cannot write " + file.string());
}

}  // namespace rotunda::recon
