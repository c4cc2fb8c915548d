#include "recon/mesh/simplify.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <queue>
#include <tuple>
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

bool try_collapse(Surgery& surgery, Surgery::HalfedgeHandle halfedge, const Surgery::Point& target) {
  const auto from = surgery.from_vertex_handle(halfedge), to = surgery.to_vertex_handle(halfedge);
  if (!surgery.is_collapse_ok(halfedge) || turns_a_triangle(surgery, from, to, target) ||
      turns_a_triangle(surgery, to, from, target))
    return false;
  surgery.set_point(to, target);
  surgery.collapse(halfedge);
  return true;
}

Eigen::Vector3d place(const Surgery& surgery, Surgery::VertexHandle vertex) {
  const auto& p = surgery.point(vertex);
  return {p[0], p[1], p[2]};
}

// x^T A x + 2 b^T x + c: the sum of squared distances to planes, each times its triangle's area.
struct Quadric {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0.0;

  void add(const Quadric& other) {
    A += other.A;
    b += other.b;
    c += other.c;
  }
  double at(const Eigen::Vector3d& x) const { return x.dot(A * x + 2.0 * b) + c; }
};

// Edges by what their collapse costs; an entry that was overtaken is known by its edge's stamp.
class CheapestEdges {
 public:
  explicit CheapestEdges(Surgery& surgery)
      : surgery_(surgery), quadrics_(surgery.n_vertices()), stamps_(surgery.n_edges(), 0U) {
    for (const auto face : surgery.faces()) add_plane(face);
    std::vector<Entry> entries;
    entries.reserve(surgery.n_edges());
    for (const auto edge : surgery.edges()) entries.push_back(entry_of(edge));
    queue_ = decltype(queue_)(std::greater<>(), std::move(entries));
  }

  // How many triangles went; 0 if no edge is left whose collapse is allowed.
  std::size_t collapse_one() {
    while (!queue_.empty()) {
      const Entry entry = queue_.top();
      queue_.pop();
      const Surgery::EdgeHandle edge(static_cast<int>(entry.edge));
      if (entry.stamp != stamps_[entry.edge] || surgery_.status(edge).deleted()) continue;
      const std::size_t sides = surgery_.is_boundary(edge) ? 1 : 2;
      if (collapse(cheaper_way(edge))) return sides;
    }
    return 0;
  }

 private:
  struct Entry {
    double cost;
    std::uint32_t edge, stamp;
    bool operator>(const Entry& other) const { return std::tie(cost, edge) > std::tie(other.cost, other.edge); }
  };
  static constexpr double kShort = 1e-6;  // prefers short edges where planes tell nothing, as on a flat piece

  void add_plane(Surgery::FaceHandle face) {
    auto corner = surgery_.cfv_begin(face);
    const auto a = *corner, b = *++corner, c = *++corner;
    const Eigen::Vector3d p = place(surgery_, a);
    const Eigen::Vector3d twice = (place(surgery_, b) - p).cross(place(surgery_, c) - p);
    const double area2 = twice.norm();
    if (area2 == 0.0) return;
    const Eigen::Vector3d normal = twice / area2;
    const double offset = -normal.dot(p), weight = 0.5 * area2;
    const Quadric plane{weight * normal * normal.transpose(), weight * offset * normal, weight * offset * offset};
    for (const auto v : {a, b, c}) quadrics_[static_cast<std::size_t>(v.idx())].add(plane);
  }

  Quadric quadric_of(Surgery::HalfedgeHandle halfedge) const {
    Quadric sum = quadrics_[static_cast<std::size_t>(surgery_.from_vertex_handle(halfedge).idx())];
    sum.add(quadrics_[static_cast<std::size_t>(surgery_.to_vertex_handle(halfedge).idx())]);
    return sum;
  }

  double cost_of(const Quadric& quadric, Surgery::VertexHandle kept) const { return quadric.at(place(surgery_, kept)); }

  // Towards the end that costs less: positions are kept.
  Surgery::HalfedgeHandle cheaper_way(Surgery::EdgeHandle edge) const {
    const auto there = surgery_.halfedge_handle(edge, 0), back = surgery_.halfedge_handle(edge, 1);
    const auto quadric = quadric_of(there);
    const bool back_is_cheaper =
        cost_of(quadric, surgery_.to_vertex_handle(back)) < cost_of(quadric, surgery_.to_vertex_handle(there));
    return back_is_cheaper ? back : there;
  }

  Entry entry_of(Surgery::EdgeHandle edge) const {
    const auto way = cheaper_way(edge);
    const auto quadric = quadric_of(way);
    const double cost = cost_of(quadric, surgery_.to_vertex_handle(way)) +
                        kShort * quadric.A.trace() * surgery_.calc_edge_sqr_length(edge);
    const auto index = static_cast<std::uint32_t>(edge.idx());
    return {cost, index, stamps_[index]};
  }

  bool collapse(Surgery::HalfedgeHandle halfedge) {
    const auto quadric = quadric_of(halfedge);
    const auto kept = surgery_.to_vertex_handle(halfedge);
    if (!try_collapse(surgery_, halfedge, surgery_.point(kept))) return false;
    quadrics_[static_cast<std::size_t>(kept.idx())] = quadric;
    for (const auto edge : surgery_.ve_range(kept)) {
      ++stamps_[static_cast<std::size_t>(edge.idx())];
      queue_.push(entry_of(edge));
    }
    return true;
  }

  Surgery& surgery_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> stamps_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace

void simplify(TriangleMesh& mesh, std::size_t triangles) {
  if (mesh.triangles.size() <= triangles) return;
  auto surgery = to_surgery(mesh);
  CheapestEdges edges(surgery);
  for (std::size_t left = mesh.triangles.size(); left > triangles;) {
    const std::size_t gone = edges.collapse_one();
    if (gone == 0) break;
    left -= gone;
  }
  mesh = from_surgery(surgery);
}

std::size_t collapse_slivers(TriangleMesh& mesh, double shortest) {
  auto surgery = to_surgery(mesh);
  std::size_t collapsed = 0;
  for (bool any = true; any;) {
    any = false;
    for (const auto edge : surgery.edges()) {
      if (surgery.status(edge).deleted() || surgery.calc_edge_length(edge) >= shortest) continue;
      const auto halfedge = surgery.halfedge_handle(edge, 0);
      const auto middle =
          (surgery.point(surgery.from_vertex_handle(halfedge)) + surgery.point(surgery.to_vertex_handle(halfedge))) *
          0.5;
      if (!try_collapse(surgery, halfedge, middle)) continue;
      ++collapsed;
      any = true;
    }
  }
  mesh = from_surgery(surgery);
  return collapsed;
}

}  // namespace rotunda::recon
