#include "simulator/scan/dense_surface.h"

#include <Eigen/Dense>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <cmath>
#include <map>
#include <queue>

#include "config/errors.h"
#include "recon/mesh/simplify.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;
using recon::Colour;
using recon::TriangleMesh;

// Colours anywhere on the surface given.
class Paint {
 public:
  Paint(const TriangleMesh& surface, const SurfaceTexture& texture) : surface_(surface), texture_(texture) {
    if (surface.triangles.empty() || texture.corners.size() != 3 * surface.triangles.size() || texture.picture.empty())
      throw InvalidInput("a surface to scan needs triangles and a texture with three corners each");
  }

  Colour at(std::size_t triangle, const Vector3d& p) const {
    const auto corner = [&](std::size_t i) -> Vector3d {
      return surface_.positions[surface_.triangles[triangle][i]].cast<double>();
    };
    Eigen::Matrix<double, 3, 2> edges;
    edges << corner(1) - corner(0), corner(2) - corner(0);
    const Eigen::Vector2d part = edges.colPivHouseholderQr().solve(p - corner(0));
    const auto* texel = &texture_.corners[3 * triangle];
    const Eigen::Vector2d at = (1.0 - part.sum()) * texel[0].cast<double>() + part.x() * texel[1].cast<double>() +
                               part.y() * texel[2].cast<double>();
    return sample(at - Eigen::Vector2d::Constant(0.5));  // (0.5, 0.5) is the first texel's centre
  }

 private:
  Colour sample(const Eigen::Vector2d& at) const {
    const cv::Mat& picture = texture_.picture;
    const double x = std::clamp(at.x(), 0.0, picture.cols - 1.0), y = std::clamp(at.y(), 0.0, picture.rows - 1.0);
    const int x0 = std::min(static_cast<int>(x), std::max(0, picture.cols - 2));
    const int y0 = std::min(static_cast<int>(y), std::max(0, picture.rows - 2));
    const int x1 = std::min(x0 + 1, picture.cols - 1), y1 = std::min(y0 + 1, picture.rows - 1);
    Colour colour{};
    for (int c = 0; c < 3; ++c) {
      const auto texel = [&](int row, int column) { return double{1.0} * picture.at<cv::Vec3b>(row, column)[c]; };
      const double top = std::lerp(texel(y0, x0), texel(y0, x1), x - x0);
      const double bottom = std::lerp(texel(y1, x0), texel(y1, x1), x - x0);
      colour[static_cast<std::size_t>(c)] = cv::saturate_cast<std::uint8_t>(std::lerp(top, bottom, y - y0));
    }
    return colour;
  }

  const TriangleMesh& surface_;
  const SurfaceTexture& texture_;
};

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Kernel = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;
using Edge = OpenMesh::EdgeHandle;
using Face = OpenMesh::FaceHandle;
using Vertex = OpenMesh::VertexHandle;

struct ByLength {  // the longest first; the older of equals
  double length;
  Edge edge;
  bool operator<(const ByLength& other) const {
    return length != other.length ? length < other.length : edge.idx() > other.edge.idx();
  }
};

class Refinement {
 public:
  Refinement(const TriangleMesh& surface, const Paint& paint) : paint_(paint) {
    for (const auto& p : surface.positions) add_vertex(p.cast<double>());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) add_triangle(surface, t);
    for (const auto edge : mesh_.edges()) longest_.push({mesh_.calc_edge_length(edge), edge});
  }

  void refine_to(std::size_t triangles) {
    while (mesh_.n_faces() < triangles) {
      const auto [length, edge] = longest_.top();
      longest_.pop();
      if (length == mesh_.calc_edge_length(edge)) halve(edge);  // else it was halved since
    }
  }

  TriangleMesh result() const {
    TriangleMesh mesh;
    for (const auto v : mesh_.vertices()) {
      const auto& p = mesh_.point(v);
      mesh.positions.push_back(Vector3d(p[0], p[1], p[2]).cast<float>());
    }
    mesh.colours = colours_;
    for (const auto f : mesh_.faces()) {
      std::array<std::uint32_t, 3> triangle{};
      std::size_t i = 0;
      for (const auto v : mesh_.fv_range(f)) triangle[i++] = static_cast<std::uint32_t>(v.idx());
      mesh.triangles.push_back(triangle);
    }
    return mesh;
  }

 private:
  Vertex add_vertex(const Vector3d& p) {
    colours_.push_back({});
    return mesh_.add_vertex({p.x(), p.y(), p.z()});
  }

  void add_triangle(const TriangleMesh& surface, std::size_t t) {
    std::array<Vertex, 3> corner;
    for (std::size_t i = 0; i < 3; ++i) corner[i] = Vertex(static_cast<int>(surface.triangles[t][i]));
    Face face = mesh_.add_face(corner[0], corner[1], corner[2]);
    if (!face.is_valid()) {  // not manifold there
      for (std::size_t i = 0; i < 3; ++i)
        corner[i] = add_vertex(surface.positions[surface.triangles[t][i]].cast<double>());
      face = mesh_.add_face(corner[0], corner[1], corner[2]);
    }
    origin_.push_back(t);
    for (const auto v : corner) colours_[index(v)] = colour_at(v, t);
  }

  void halve(Edge edge) {
    std::array<Vertex, 2> opposite;  // of the triangles to either side
    std::array<std::size_t, 2> origin{};
    for (unsigned side = 0; side < 2; ++side) {
      const auto halfedge = mesh_.halfedge_handle(edge, side);
      const Face face = mesh_.face_handle(halfedge);
      if (!face.is_valid()) continue;
      opposite[side] = mesh_.to_vertex_handle(mesh_.next_halfedge_handle(halfedge));
      origin[side] = origin_[index(face)];
    }
    const unsigned side = opposite[0].is_valid() ? 0 : 1;
    const auto middle = mesh_.calc_edge_midpoint(edge);
    const Vertex v = add_vertex({middle[0], middle[1], middle[2]});
    colours_[index(v)] = colour_at(v, origin[side]);
    mesh_.split(edge, v);
    origin_.resize(mesh_.n_faces());
    for (const auto face : mesh_.vf_range(v))
      for (const auto corner : mesh_.fv_range(face))
        for (unsigned i = 0; i < 2; ++i)
          if (corner == opposite[i]) origin_[index(face)] = origin[i];
    for (const auto e : mesh_.ve_range(v)) longest_.push({mesh_.calc_edge_length(e), e});
  }

  Colour colour_at(Vertex v, std::size_t triangle) const {
    const auto& p = mesh_.point(v);
    return paint_.at(triangle, {p[0], p[1], p[2]});
  }

  template <class Handle>
  static std::size_t index(Handle handle) {
    return static_cast<std::size_t>(handle.idx());
  }

  const Paint& paint_;
  Kernel mesh_;
  std::vector<Colour> colours_;      // one a vertex
  std::vector<std::size_t> origin_;  // of each triangle: the one of the surface it is a part of
  std::priority_queue<ByLength> longest_;
};

using Place = std::array<float, 3>;
Place place(const Eigen::Vector3f& p) {
  return {p.x(), p.y(), p.z()};
}

TriangleMesh coarsened(const TriangleMesh& painted, std::size_t triangles) {
  std::map<Place, Colour> colours;  // collapses keep positions
  for (std::size_t v = 0; v < painted.positions.size(); ++v) colours[place(painted.positions[v])] = painted.colours[v];
  TriangleMesh mesh = painted;
  recon::simplify(mesh, triangles);
  for (const auto& p : mesh.positions) mesh.colours.push_back(colours.at(place(p)));
  return mesh;
}

}  // namespace

recon::TriangleMesh dense_surface(const recon::TriangleMesh& surface, const SurfaceTexture& texture,
                                  std::size_t triangles) {
  const Paint paint(surface, texture);
  Refinement refinement(surface, paint);
  refinement.refine_to(triangles);
  TriangleMesh mesh = refinement.result();
  if (triangles < mesh.triangles.size() && triangles < surface.triangles.size()) mesh = coarsened(mesh, triangles);
  recon::compute_normals(mesh);
  return mesh;
}

}  // namespace rotunda::simulator
