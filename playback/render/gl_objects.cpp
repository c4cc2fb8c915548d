#include "playback/render/gl_objects.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <string>

#include "config/errors.h"

namespace rotunda::playback {
namespace {

GLuint compile(GLenum stage, std::string_view source) {
  const GLuint shader = glCreateShader(stage);
  const auto* text = source.data();
  const auto length = static_cast<GLint>(source.size());
  glShaderSource(shader, 1, &text, &length);
  glCompileShader(shader);
  GLint compiled = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled) return shader;
  std::string log(4096, '\0');
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  glDeleteShader(shader);
  throw DeviceError("display", "a shader does not compile: " + std::string(log.c_str()));
}

}  // namespace

void delete_buffer(GLuint name) {
  glDeleteBuffers(1, &name);
}
void delete_texture(GLuint name) {
  glDeleteTextures(1, &name);
}
void delete_vertex_array(GLuint name) {
  glDeleteVertexArrays(1, &name);
}
void delete_framebuffer(GLuint name) {
  glDeleteFramebuffers(1, &name);
}
void delete_program(GLuint name) {
  glDeleteProgram(name);
}

GlBuffer make_buffer() {
  GLuint name = 0;
  glGenBuffers(1, &name);
  return GlBuffer(name);
}

GlTexture make_texture() {
  GLuint name = 0;
  glGenTextures(1, &name);
  return GlTexture(name);
}

GlTexture make_picture(const cv::Mat& rgba) {
  auto texture = make_texture();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, rgba.cols, rgba.rows);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, rgba.cols, rgba.rows, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data);
  return texture;
}

GlVertexArray make_vertex_array() {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  return GlVertexArray(name);
}

GlProgram make_program(std::string_view vertex_source, std::string_view fragment_source) {
  GlProgram program(glCreateProgram());
  const GLuint vertex = compile(GL_VERTEX_SHADER, vertex_source);
  const GLuint fragment = compile(GL_FRAGMENT_SHADER, fragment_source);
  glAttachShader(program.get(), vertex);
  glAttachShader(program.get(), fragment);
  glLinkProgram(program.get());
  glDeleteShader(vertex);
  glDeleteShader(fragment);
  GLint linked = 0;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &linked);
  if (linked) return program;
  std::string log(4096, '\0');
  glGetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw DeviceError("display", "a shader program does not link: " + std::string(log.c_str()));
}

GLint uniform(const GlProgram& program, const char* name) {
  return glGetUniformLocation(program.get(), name);
}

FrameFence::~FrameFence() {
  glDeleteSync(before_);
}

void FrameFence::frame_drawn() {
  const GLsync now = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glFlush();
  constexpr GLuint64 kGiveUp = 5'000'000'000;  // nanoseconds: a driver that hangs is not waited for for ever
  if (before_) glClientWaitSync(before_, 0, kGiveUp);
  glDeleteSync(before_);
  before_ = now;
}

RenderTarget::RenderTarget(int width, int height)
    : width_(width), height_(height), colour_(make_texture()), depth_(make_texture()) {
  glBindTexture(GL_TEXTURE_2D, colour_.get());
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, width, height);
  glBindTexture(GL_TEXTURE_2D, depth_.get());
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH_COMPONENT24, width, height);
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  framebuffer_ = GlFramebuffer(name);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour_.get(), 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_.get(), 0);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw DeviceError("display",
                      glGetString(GL_VERSION) == nullptr
                          ? "no graphics context is current on this thread"
                          : fmt::format("cannot draw into {} x {} pixels; ask for a smaller --size", width, height));
}

void RenderTarget::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glViewport(0, 0, width_, height_);
}

cv::Mat RenderTarget::read_rgba() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  cv::Mat rows_from_below(height_, width_, CV_8UC4), picture;
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, rows_from_below.data);
  cv::flip(rows_from_below, picture, 0);
  return picture;
}

}  // namespace rotunda::playback
