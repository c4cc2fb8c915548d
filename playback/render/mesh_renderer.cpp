#include "playback/render/mesh_renderer.h"

#include "config/errors.h"

namespace rotunda::playback {
namespace {

constexpr std::string_view kVertex = R"(
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec3 a_colour;
#ifndef GREY
out vec3 v_colour;
void paint() { v_colour = a_colour; }
#endif
vec3 place() { return a_position; }
vec3 outwards() { return a_normal; }
)";

constexpr std::string_view kFragment = R"(
in vec3 v_colour;
vec3 colour() { return v_colour; }
)";

template <class T>
void fill(GLenum target, const GlBuffer& buffer, const std::vector<T>& items) {
  glBindBuffer(target, buffer.get());
  glBufferData(target, static_cast<GLsizeiptr>(items.size() * sizeof(T)), items.data(), GL_DYNAMIC_DRAW);
}

void check_mesh(const recon::TriangleMesh& mesh) {
  const std::size_t count = mesh.positions.size();
  if ((!mesh.normals.empty() && mesh.normals.size() != count) ||
      (!mesh.colours.empty() && mesh.colours.size() != count))
    throw InvalidInput("a mesh to draw has another number of normals or colours than of positions");
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle)
      if (vertex >= count) throw InvalidInput("a mesh to draw has a triangle beyond its vertices");
}

}  // namespace

MeshRenderer::MeshRenderer()
    : program_(kVertex, kFragment),
      vertices_(make_vertex_array()),
      positions_(make_buffer()),
      normals_(make_buffer()),
      colours_(make_buffer()),
      triangles_(make_buffer()) {}

void MeshRenderer::upload(const recon::TriangleMesh& mesh) {
  check_mesh(mesh);
  recon::TriangleMesh with_normals;
  if (mesh.normals.empty()) {
    with_normals = mesh;
    recon::compute_normals(with_normals);
  }
  glBindVertexArray(vertices_.get());
  fill(GL_ARRAY_BUFFER, positions_, mesh.positions);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  glEnableVertexAttribArray(0);
  fill(GL_ARRAY_BUFFER, normals_, mesh.normals.empty() ? with_normals.normals : mesh.normals);
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  glEnableVertexAttribArray(1);
  coloured_ = !mesh.colours.empty();
  if (coloured_) {
    fill(GL_ARRAY_BUFFER, colours_, mesh.colours);
    glVertexAttribPointer(2, 3, GL_UNSIGNED_BYTE, GL_TRUE, 0, nullptr);
    glEnableVertexAttribArray(2);
  } else {
    glDisableVertexAttribArray(2);
  }
  fill(GL_ELEMENT_ARRAY_BUFFER, triangles_, mesh.triangles);
  indices_ = static_cast<GLsizei>(3 * mesh.triangles.size());
  box_.setEmpty();
  for (const Eigen::Vector3f& position : mesh.positions) box_.extend(position.cast<double>());
}

void MeshRenderer::draw(const Viewpoint& viewpoint, const DrawOptions& options) {
  if (indices_ == 0) return;
  DrawOptions possible = options;
  if (!coloured_) possible.shading = Shading::grey;
  program_.use(viewpoint, depth_range(viewpoint, box_), possible);
  glBindVertexArray(vertices_.get());
  glDrawElements(GL_TRIANGLES, indices_, GL_UNSIGNED_INT, nullptr);
}

cv::Mat render_mesh(const recon::TriangleMesh& mesh, const Viewpoint& viewpoint, const DrawOptions& options,
                    const std::optional<recon::Colour>& background) {
  const RenderTarget target(viewpoint.width, viewpoint.height);
  MeshRenderer renderer;
  renderer.upload(mesh);
  target.bind();
  clear(background);
  renderer.draw(viewpoint, options);
  return target.read_rgba();
}

}  // namespace rotunda::playback
