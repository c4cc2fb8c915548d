#include "recon/mesh/simplify.h"

#include <Eigen/Geometry>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <algorithm>
#include <vector>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Surgery = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

Surgery to_surgery(const TriangleMesh& mesh) {
  Surgery surgery;
  surgery.request_vertex_status();
  surgery.request_edge_status();
  surgery.request_halfedge_status();
  surgery.request_face_status();
  surgery.request_face_normals();
  surgery.reserve(mesh.positions.size(), mesh.triangles.size() * 3 / 2, mesh.triangles.size());
  std::vector<Surgery::VertexHandle> handles(mesh.positions.size());
  for (std::size_t v = 0; v < handles.size(); ++v) {
    const Eigen::Vector3d p = mesh.positions[v].cast<double>();
    handles[v] = surgery.add_vertex({p.x(), p.y(), p.z()});
  }
  for (const auto& t : mesh.triangles)
    if (!surgery.add_face(handles[t[0]], handles[t[1]], handles[t[2]]).is_valid())
      throw InvalidInput("a mesh to simplify must be a manifold surface");
  surgery.update_face_normals();
  return surgery;
}

TriangleMesh from_surgery(Surgery& surgery) {
  surgery.garbage_collection();
  TriangleMesh mesh;
  mesh.positions.reserve(surgery.n_vertices());
  mesh.triangles.reserve(surgery.n_faces());
  for (const auto v : surgery.vertices()) {
    const auto& p = surgery.point(v);
    mesh.positions.push_back(Eigen::Vector3d(p[0], p[1], p[2]).cast<float>());
  }
  for (const auto f : surgery.faces()) {
    std::array<std::uint32_t, 3> triangle{};
    std::size_t i = 0;
    for (const auto v : surgery.fv_range(f)) triangle[i++] = static_cast<std::uint32_t>(v.idx());
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

// Would moving `vertex` to `target` turn a triangle around it, other than those with `partner`, by over 60 degrees?
bool turns_a_triangle(const Surgery& surgery, Surgery::VertexHandle vertex, Surgery::VertexHandle partner,
                      const Surgery::Point& target) {
  for (const auto outgoing : surgery.voh_range(vertex)) {
    const auto a = surgery.to_vertex_handle(outgoing);
    const auto b = surgery.to_vertex_handle(surgery.next_halfedge_handle(outgoing));
    if (a == partner || b == partner) continue;
    const auto before = (surgery.point(a) - surgery.point(vertex)) % (surgery.point(b) - surgery.point(vertex));
    const auto after = (surgery.point(a) - target) % (surgery.point(b) - target);
    if ((before | after) <= 0.5 * before.norm() * after.norm()) return true;
  }
  return false;
}

bool try_collapse(Surgery& surgery, Surgery::HalfedgeHandle halfedge) {
  const auto from = surgery.from_vertex_handle(halfedge), to = surgery.to_vertex_handle(halfedge);
  const auto middle = (surgery.point(from) + surgery.point(to)) * 0.5;
  if (!surgery.is_collapse_ok(halfedge) || turns_a_triangle(surgery, from, to, middle) ||
      turns_a_triangle(surgery, to, from, middle))
    return false;
  surgery.set_point(to, middle);
  surgery.collapse(halfedge);
  return true;
}

}  // namespace

void simplify(TriangleMesh& mesh, std::size_t triangles) {
  if (mesh.triangles.size() <= triangles) return;
  auto surgery = to_surgery(mesh);
  OpenMesh::Decimater::DecimaterT<Surgery> decimater(surgery);
  OpenMesh::Decimater::ModQuadricT<Surgery>::Handle quadric;
  OpenMesh::Decimater::ModNormalFlippingT<Surgery>::Handle flipping;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();
  decimater.add(flipping);
  decimater.module(flipping).set_max_normal_deviation(60.0F);
  decimater.initialize();
  decimater.decimate_to_faces(0, triangles);
  mesh = from_surgery(surgery);
}

std::size_t collapse_slivers(TriangleMesh& mesh, double shortest) {
  auto surgery = to_surgery(mesh);
  std::size_t collapsed = 0;
  for (bool any = true; any;) {
    any = false;
    for (const auto edge : surgery.edges()) {
      if (surgery.status(edge).deleted() || surgery.calc_edge_length(edge) >= shortest) continue;
      if (!try_collapse(surgery, surgery.halfedge_handle(edge, 0))) continue;
      ++collapsed;
      any = true;
    }
  }
  mesh = from_surgery(surgery);
  return collapsed;
}

}  // namespace rotunda::recon
