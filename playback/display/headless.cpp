#include "playback/display/headless.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>
#include <malloc.h>

#include "config/errors.h"

namespace rotunda::playback {
namespace {

[[noreturn]] void fail(const char* step) {
  throw DeviceError("display", fmt::format("{} failed (EGL error 0x{:x}); is Mesa's software renderer "
                                           "(libgl1-mesa-dri) installed?",
                                           step, eglGetError()));
}

}  // namespace

struct HeadlessDisplay::Handles {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
};

HeadlessDisplay::HeadlessDisplay() : handles_(std::make_unique<Handles>()) {
  handles_->display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (handles_->display == EGL_NO_DISPLAY) fail("eglGetPlatformDisplay");
  if (!eglInitialize(handles_->display, nullptr, nullptr)) fail("eglInitialize");
  eglBindAPI(EGL_OPENGL_ES_API);
  const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(handles_->display, wanted, &config, 1, &count) || count < 1) fail("eglChooseConfig");
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0, EGL_NONE};
  handles_->context = eglCreateContext(handles_->display, config, EGL_NO_CONTEXT, version);
  if (handles_->context == EGL_NO_CONTEXT) fail("eglCreateContext");
  if (!eglMakeCurrent(handles_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, handles_->context)) fail("eglMakeCurrent");
}

HeadlessDisplay::~HeadlessDisplay() {
  eglMakeCurrent(handles_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(handles_->display, handles_->context);
}

void keep_scene_memory() {
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
}

}  // namespace rotunda::playback
