#include "playback/display/context_reset.h"

#include <EGL/egl.h>
#include <GLES3/gl3.h>

#include <string_view>

namespace rotunda::playback {
namespace {

bool has_extension(std::string_view wanted) {
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i)
    if (reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))) == wanted) return true;
  return false;
}

// EGL gives an address for every name: only those that the driver speaks of are called.
const char* name_of_status() {
  GLint major = 0, minor = 0;
  glGetIntegerv(GL_MAJOR_VERSION, &major);
  glGetIntegerv(GL_MINOR_VERSION, &minor);
  if (major > 3 || (major == 3 && minor >= 2)) return "glGetGraphicsResetStatus";
  if (has_extension("GL_KHR_robustness")) return "glGetGraphicsResetStatusKHR";
  if (has_extension("GL_EXT_robustness")) return "glGetGraphicsResetStatusEXT";
  return nullptr;
}

}  // namespace

ContextReset::ContextReset() {
  if (const char* name = name_of_status()) status_ = reinterpret_cast<Status>(eglGetProcAddress(name));
}

bool ContextReset::happened() const {
  return eglGetError() == EGL_CONTEXT_LOST || (status_ && status_() != GL_NO_ERROR);
}

}  // namespace rotunda::playback
