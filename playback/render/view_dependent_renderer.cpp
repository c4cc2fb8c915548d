#include "playback/render/view_dependent_renderer.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "config/errors.h"
#include "playback/render/view_dependent_shaders.h"

namespace rotunda::playback {
namespace {

using namespace view_dependent;

constexpr float kNoSurface = 1e9F;  // metres, in a depth map

template <class T>
void fill(GLenum target, const GlBuffer& buffer, const std::vector<T>& items) {
  glBindBuffer(target, buffer.get());
  glBufferData(target, static_cast<GLsizeiptr>(items.size() * sizeof(T)), items.data(), GL_DYNAMIC_DRAW);
}

bool has_extension(const char* wanted) {
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i)
    if (std::strcmp(reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))), wanted) == 0)
      return true;
  return false;
}

void check(const recon::TriangleMesh& surface, std::span<const SourceView> views) {
  if (views.empty()) throw InvalidInput("no camera has a picture to draw the surface with");
  if (surface.colours.size() != surface.positions.size() || surface.triangles.empty())
    throw InvalidInput("a surface to draw with its cameras' pictures needs triangles, and a colour a vertex");
  for (const auto& triangle : surface.triangles)
    for (const std::uint32_t vertex : triangle)
      if (vertex >= surface.positions.size())
        throw InvalidInput("a surface to draw has a triangle beyond its vertices");
  for (const auto& view : views)
    if (view.rgba.type() != CV_8UC4 || view.rgba.cols != view.camera.width || view.rgba.rows != view.camera.height)
      throw InvalidInput(fmt::format("{}: a picture of {} x {} is not of its calibration's size, {} x {}",
                                     view.camera.name, view.rgba.cols, view.rgba.rows, view.camera.width,
                                     view.camera.height));
}

double focal_of(const Eigen::Matrix3d& K) {
  return std::sqrt(std::abs(K(0, 0) * K(1, 1)));
}

void set(const GlProgram& program, const char* name, const Eigen::Matrix3d& value) {
  const Eigen::Matrix3f single = value.cast<float>();
  glUniformMatrix3fv(uniform(program, name), 1, GL_FALSE, single.data());
}
void set(const GlProgram& program, const char* name, const Eigen::Vector3d& value) {
  const Eigen::Vector3f single = value.cast<float>();
  glUniform3fv(uniform(program, name), 1, single.data());
}
void set(const GlProgram& program, const char* name, double value) {
  glUniform1f(uniform(program, name), static_cast<float>(value));
}
void set(const GlProgram& program, const char* name, GLenum unit, const GlTexture& texture) {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glUniform1i(uniform(program, name), static_cast<GLint>(unit));
}

// With all its coarser levels, for viewpoints from farther off.
GlTexture picture_texture(const cv::Mat& rgba) {
  auto texture = make_texture();
  const auto levels = static_cast<GLsizei>(1 + std::floor(std::log2(std::max(rgba.cols, rgba.rows))));
  const cv::Mat dense = rgba.isContinuous() ? rgba : rgba.clone();
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexStorage2D(GL_TEXTURE_2D, levels, GL_RGBA8, rgba.cols, rgba.rows);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, rgba.cols, rgba.rows, GL_RGBA, GL_UNSIGNED_BYTE, dense.data);
  glGenerateMipmap(GL_TEXTURE_2D);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

// Where the box is in the picture, pixels; the whole picture where a lens or an eye within it leaves that open.
cv::Rect place_in_picture(const Eigen::AlignedBox3d& box, const Viewpoint& viewpoint) {
  const cv::Rect whole(0, 0, viewpoint.width, viewpoint.height);
  if (!viewpoint.distortion.isZero()) return whole;
  Eigen::AlignedBox2d place;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d seen =
        viewpoint.R * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) + viewpoint.t;
    if (seen.z() < 1e-3) return whole;
    place.extend((viewpoint.K * (seen / seen.z())).head<2>());
  }
  constexpr double kFarOff = 1e6;  // pixels: what lies beyond is outside of any picture
  const Eigen::Vector2d from = place.min().array().max(-kFarOff).min(kFarOff).floor(),
                        to = place.max().array().max(-kFarOff).min(kFarOff).ceil() + 1.0;
  return whole & cv::Rect(cv::Point(static_cast<int>(from.x()), static_cast<int>(from.y())),
                          cv::Point(static_cast<int>(to.x()), static_cast<int>(to.y())));
}

// Drawing and emptying reaches this part of pictures alone; GL counts rows from the bottom.
class Scissors {
 public:
  Scissors(const cv::Rect& place, int height) {
    glEnable(GL_SCISSOR_TEST);
    glScissor(place.x, height - place.y - place.height, place.width, place.height);
  }
  ~Scissors() { glDisable(GL_SCISSOR_TEST); }
  Scissors(const Scissors&) = delete;
  Scissors& operator=(const Scissors&) = delete;
};

// The caller's framebuffer and viewport, put back when done.
class BoundTarget {
 public:
  BoundTarget() {
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer_);
    glGetIntegerv(GL_VIEWPORT, viewport_);
  }
  void restore() const {
    glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(framebuffer_));
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  }

 private:
  GLint framebuffer_ = 0, viewport_[4] = {};
};

}  // namespace

ViewDependentRenderer::ViewDependentRenderer(const ViewDependentOptions& options)
    : options_(options),
      places_(kSurface, kPlace),
      normals_(kSurface, kNormal),
      colours_(kSurface, kOwnColour),
      depths_(kSurface, kDepth),
      add_(make_program(kWholePicture, kAddCamera)),
      mix_(make_program(kWholePicture, kMix)),
      surface_(make_vertex_array()),
      nothing_(make_vertex_array()),
      positions_(make_buffer()),
      outwards_(make_buffer()),
      own_(make_buffer()),
      triangles_(make_buffer()) {
  for (const char* wanted : {"GL_EXT_color_buffer_float", "GL_EXT_float_blend"})
    if (!has_extension(wanted))
      throw DeviceError("display",
                        fmt::format("its driver lacks {}, which view-dependent drawing adds cameras up with; "
                                    "leave --view-dependent out",
                                    wanted));
}

ViewDependentRenderer::Layer ViewDependentRenderer::make_layer(GLenum format, int width, int height) {
  Layer layer{make_texture(), make_texture(), {}, width, height};
  glBindTexture(GL_TEXTURE_2D, layer.colour.get());
  glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glBindTexture(GL_TEXTURE_2D, layer.depth.get());
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH_COMPONENT24, width, height);
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  layer.framebuffer = GlFramebuffer(name);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, layer.colour.get(), 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, layer.depth.get(), 0);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw DeviceError("display", fmt::format("cannot draw into {} x {} floating-point pixels", width, height));
  return layer;
}

void ViewDependentRenderer::bind(const Layer& layer) {
  glBindFramebuffer(GL_FRAMEBUFFER, layer.framebuffer.get());
  glViewport(0, 0, layer.width, layer.height);
}

void ViewDependentRenderer::upload(const recon::TriangleMesh& surface, std::span<const SourceView> views) {
  check(surface, views);
  const BoundTarget target;
  upload_surface(surface);
  sources_.clear();
  for (const auto& view : views) sources_.push_back(make_source(view));
  target.restore();
}

void ViewDependentRenderer::upload_surface(const recon::TriangleMesh& surface) {
  recon::TriangleMesh with_normals;
  if (surface.normals.size() != surface.positions.size()) {
    with_normals = surface;
    recon::compute_normals(with_normals);
  }
  glBindVertexArray(surface_.get());
  fill(GL_ARRAY_BUFFER, positions_, surface.positions);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  fill(GL_ARRAY_BUFFER, outwards_, with_normals.normals.empty() ? surface.normals : with_normals.normals);
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  fill(GL_ARRAY_BUFFER, own_, surface.colours);
  glVertexAttribPointer(2, 3, GL_UNSIGNED_BYTE, GL_TRUE, 0, nullptr);
  for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
  fill(GL_ELEMENT_ARRAY_BUFFER, triangles_, surface.triangles);
  indices_ = static_cast<GLsizei>(3 * surface.triangles.size());
  box_.setEmpty();
  for (const Eigen::Vector3f& position : surface.positions) box_.extend(position.cast<double>());
}

ViewDependentRenderer::Source ViewDependentRenderer::make_source(const SourceView& view) {
  Source source{view.camera, picture_texture(view.rgba), make_layer(GL_R32F, view.camera.width, view.camera.height),
                focal_of(view.camera.K)};
  draw_surface(depths_, viewpoint_of(view.camera), source.depth, kNoSurface);
  return source;
}

// `empty`: red where nothing is; the other channels, and alpha, are 0 there.
void ViewDependentRenderer::draw_surface(ViewProgram& program, const Viewpoint& viewpoint, const Layer& into,
                                         float empty) {
  bind(into);
  glClearColor(empty, 0.0F, 0.0F, 0.0F);
  glDepthMask(GL_TRUE);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  program.use(viewpoint, depth_range(viewpoint, box_), {});
  glBindVertexArray(surface_.get());
  glDrawElements(GL_TRIANGLES, indices_, GL_UNSIGNED_INT, nullptr);
}

void ViewDependentRenderer::resize(int width, int height) {
  if (place_.width == width && place_.height == height) return;
  place_ = make_layer(GL_RGBA32F, width, height);
  normal_ = make_layer(GL_RGBA16F, width, height);
  colour_ = make_layer(GL_RGBA8, width, height);
  sum_ = make_layer(GL_RGBA32F, width, height);
}

// Into the sum's layer, which is bound and blends.
void ViewDependentRenderer::add(const Source& source, const Viewpoint& viewpoint) {
  glUseProgram(add_.get());
  set(add_, "u_places", 0, place_.colour);
  set(add_, "u_normals", 1, normal_.colour);
  set(add_, "u_picture", 2, source.picture);
  set(add_, "u_depths", 3, source.depth.colour);
  const auto& camera = source.camera;
  set(add_, "u_rotation", camera.R);
  set(add_, "u_k", camera.K);
  set(add_, "u_translation", camera.t);
  set(add_, "u_centre", camera.centre());
  set(add_, "u_eye", viewpoint.eye());
  const Eigen::Matrix<float, 5, 1> distortion = camera.distortion.cast<float>();
  glUniform1fv(uniform(add_, "u_distortion"), 5, distortion.data());
  set(add_, "u_fold", fold_radius_squared(viewpoint_of(camera)));
  set(add_, "u_focal", source.focal);
  set(add_, "u_eye_focal", focal_of(viewpoint.K));
  set(add_, "u_tolerance", options_.depth_tolerance_px);
  set(add_, "u_angle_power", options_.angle_power);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void ViewDependentRenderer::draw(const Viewpoint& viewpoint) {
  if (sources_.empty()) return;
  const BoundTarget target;
  resize(viewpoint.width, viewpoint.height);
  const Scissors scissors(place_in_picture(box_, viewpoint), viewpoint.height);
  draw_surface(places_, viewpoint, place_, 0.0F);
  draw_surface(normals_, viewpoint, normal_, 0.0F);
  draw_surface(colours_, viewpoint, colour_, 0.0F);
  bind(sum_);
  glClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  glClear(GL_COLOR_BUFFER_BIT);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glBindVertexArray(nothing_.get());
  for (const auto& source : sources_) add(source, viewpoint);
  glDisable(GL_BLEND);
  target.restore();
  glUseProgram(mix_.get());
  set(mix_, "u_places", 0, place_.colour);
  set(mix_, "u_own", 1, colour_.colour);
  set(mix_, "u_sum", 2, sum_.colour);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

cv::Mat render_view_dependent(const recon::TriangleMesh& surface, std::span<const SourceView> views,
                              const Viewpoint& viewpoint, const std::optional<recon::Colour>& background) {
  const RenderTarget target(viewpoint.width, viewpoint.height);
  ViewDependentRenderer renderer;
  renderer.upload(surface, views);
  target.bind();
  clear(background);
  renderer.draw(viewpoint);
  return target.read_rgba();
}

}  // namespace rotunda::playback
