#pragma once
// Move-only owners of OpenGL ES names. Only the thread that holds the context may use or destroy them.
#include <GLES3/gl3.h>

#include <opencv2/core.hpp>
#include <string_view>
#include <utility>

namespace rotunda::playback {

// One GL name and the call that gives it back.
template <void (*Delete)(GLuint)>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) : name_(name) {}
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlName() {
    if (name_ != 0) Delete(name_);
  }
  GLuint get() const { return name_; }

 private:
  GLuint name_ = 0;
};

void delete_buffer(GLuint name);
void delete_texture(GLuint name);
void delete_vertex_array(GLuint name);
void delete_framebuffer(GLuint name);
void delete_program(GLuint name);
using GlBuffer = GlName<delete_buffer>;
using GlTexture = GlName<delete_texture>;
using GlVertexArray = GlName<delete_vertex_array>;
using GlFramebuffer = GlName<delete_framebuffer>;
using GlProgram = GlName<delete_program>;

GlBuffer make_buffer();
GlTexture make_texture();
GlVertexArray make_vertex_array();
// Of a picture (CV_8UC4, red first, continuous) as it is, without filtering; bound to unit 0.
GlTexture make_picture(const cv::Mat& rgba);

// Compiles and links; throws DeviceError with the driver's log.
GlProgram make_program(std::string_view vertex_source, std::string_view fragment_source);
GLint uniform(const GlProgram& program, const char* name);

// Lets the driver lag one frame behind the program and no more: vertex work of one frame overlaps the pixels of the one
// before (a fifth faster than waiting each frame out with llvmpipe).
class FrameFence {
 public:
  FrameFence() = default;
  ~FrameFence();
  FrameFence(const FrameFence&) = delete;
  FrameFence& operator=(const FrameFence&) = delete;
  void frame_drawn();  // hands the frame to the driver, waits for the one before

 private:
  GLsync before_ = nullptr;
};

// A picture to draw into: RGBA8 with a 24-bit depth buffer.
class RenderTarget {
 public:
  RenderTarget(int width, int height);  // throws DeviceError if the driver refuses the size
  void bind() const;                    // also sets the viewport
  cv::Mat read_rgba() const;            // CV_8UC4, red first, top row first
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_, height_;
  GlTexture colour_, depth_;
  GlFramebuffer framebuffer_;
};

}  // namespace rotunda::playback
