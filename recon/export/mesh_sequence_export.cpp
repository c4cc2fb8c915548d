// A clip as one mesh file a frame.
#include <fmt/format.h>

#include <iterator>

#include "capture/picture.h"
#include "recon/export/clip_surface.h"
#include "recon/mesh/mesh_file.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/resample.h"
#include "recon/video/geometry_picture.h"

namespace rotunda::recon {
namespace {

// Positions and normals of joined vertices, so that the surface is closed; texture coordinates of all samples, since
// the texture is open along its border. OBJ counts from 1, and its textures from the bottom left.
std::string obj_text(const GeometryImage& image, const WeldedLattice& lattice,
                     const std::vector<std::array<std::uint32_t, 3>>& samples, const std::string& material) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "# metres, z up\nmtllib {}\nusemtl colours\n", material);
  for (const auto sample : lattice.sample_of_vertex) {
    const auto& p = image.positions[sample];
    fmt::format_to(out, "v {:.6f} {:.6f} {:.6f}\n", p.x(), p.y(), p.z());
  }
  for (const auto& t : texture_coordinates(image.level, image.colour_level))
    fmt::format_to(out, "vt {:.6f} {:.6f}\n", t.x(), 1.0F - t.y());
  for (const auto sample : lattice.sample_of_vertex) {
    const auto& n = image.normals[sample];
    fmt::format_to(out, "vn {:.4f} {:.4f} {:.4f}\n", n.x(), n.y(), n.z());
  }
  for (const auto& triangle : samples) {
    fmt::format_to(out, "f");
    for (const auto sample : triangle) {
      const auto vertex = lattice.vertex_of_sample[sample] + 1;
      fmt::format_to(out, " {}/{}/{}", vertex, sample + 1, vertex);
    }
    fmt::format_to(out, "\n");
  }
  return fmt::to_string(text);
}

}  // namespace

void export_obj(ClipExport& clip) {
  const auto lattice = weld_lattice(clip.level());
  const auto samples = lattice_triangles(clip.level());
  clip.set_surface(lattice.sample_of_vertex.size(), samples.size());
  for (int i = 0; i < clip.count(); ++i) {
    const auto image = clip.read(i);
    const auto obj = clip.frame_name(i, "obj"), mtl = clip.frame_name(i, "mtl"), png = clip.frame_name(i, "png");
    write_whole(clip.output() / png, [&](const auto& part) { capture::write_png(part, colour_picture(image)); });
    write_text(clip.output() / mtl, "newmtl colours\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd " + png + "\n");
    write_text(clip.output() / obj, obj_text(image, lattice, samples, mtl));
    for (const auto& name : {png, mtl, obj}) clip.written(clip.output() / name);
  }
}

void export_ply(ClipExport& clip) {
  for (int i = 0; i < clip.count(); ++i) {
    const auto mesh = remesh(clip.read(i));
    clip.set_surface(mesh.positions.size(), mesh.triangles.size());
    const auto file = clip.output() / clip.frame_name(i, "ply");
    write_whole(file, [&](const auto& part) { write_ply(part, mesh); });
    clip.written(file);
  }
}

}  // namespace rotunda::recon
