#include "playback/display/kms_surface.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>
#include <drm_fourcc.h>
#include <fmt/format.h>
#include <gbm.h>
#include <xf86drmMode.h>

#include <array>
#include <utility>
#include <vector>

#include "config/errors.h"
#include "playback/display/display.h"

namespace rotunda::playback {
namespace {

constexpr std::uint32_t kFormat = GBM_FORMAT_XRGB8888;  // the one that every driver scans out

[[noreturn]] void fail(const char* step) {
  const EGLint error = eglGetError();
  if (error == EGL_CONTEXT_LOST) throw ContextLost();
  throw DeviceError("display", fmt::format("{} failed (EGL error 0x{:x}); is Mesa's renderer (libgl1-mesa-dri) "
                                           "installed?",
                                           step, error));
}

EGLConfig config_of(EGLDisplay display) {
  constexpr std::array<EGLint, 7> kWanted = {
      EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE, EGL_WINDOW_BIT, EGL_DEPTH_SIZE, 24, EGL_NONE};
  EGLint count = 0;
  eglChooseConfig(display, kWanted.data(), nullptr, 0, &count);
  std::vector<EGLConfig> configs(static_cast<std::size_t>(count));
  eglChooseConfig(display, kWanted.data(), configs.data(), count, &count);
  for (EGLConfig config : configs) {
    EGLint format = 0;
    if (eglGetConfigAttrib(display, config, EGL_NATIVE_VISUAL_ID, &format) && format == static_cast<EGLint>(kFormat))
      return config;
  }
  fail("eglChooseConfig");
}

// Goes with its buffer.
struct ScanOut {
  int card = -1;
  std::uint32_t framebuffer = 0;
};

void forget(gbm_bo*, void* data) {
  const std::unique_ptr<ScanOut> owned(static_cast<ScanOut*>(data));
  drmModeRmFB(owned->card, owned->framebuffer);
}

std::uint32_t framebuffer_of(int card, gbm_bo* buffer) {
  if (const auto* known = static_cast<ScanOut*>(gbm_bo_get_user_data(buffer))) return known->framebuffer;
  auto made = std::make_unique<ScanOut>(ScanOut{.card = card});
  const std::uint32_t handles[4] = {gbm_bo_get_handle(buffer).u32}, strides[4] = {gbm_bo_get_stride(buffer)},
                      offsets[4] = {};
  if (drmModeAddFB2(card, gbm_bo_get_width(buffer), gbm_bo_get_height(buffer), kFormat, handles, strides, offsets,
                    &made->framebuffer, 0) != 0)
    throw DeviceError("display", "the graphics device does not take the renderer's pictures (drmModeAddFB2)");
  const auto framebuffer = made->framebuffer;
  gbm_bo_set_user_data(buffer, made.release(), forget);
  return framebuffer;
}

struct GbmFree {
  void operator()(gbm_device* device) const noexcept { gbm_device_destroy(device); }
  void operator()(gbm_surface* surface) const noexcept { gbm_surface_destroy(surface); }
};

}  // namespace

struct KmsSurface::Handles {
  int card = -1;
  std::unique_ptr<gbm_device, GbmFree> device;
  std::unique_ptr<gbm_surface, GbmFree> buffers;
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLConfig config = nullptr;
  EGLContext context = EGL_NO_CONTEXT;
  EGLSurface surface = EGL_NO_SURFACE;
  gbm_bo *seen = nullptr, *finished = nullptr;

  void make_current() const {
    if (!eglMakeCurrent(display, surface, surface, context)) fail("eglMakeCurrent");
  }
  void give_back(gbm_bo*& buffer) const {
    if (buffer) gbm_surface_release_buffer(buffers.get(), buffer);
    buffer = nullptr;
  }
  void drop_buffers() {
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (surface != EGL_NO_SURFACE) eglDestroySurface(display, std::exchange(surface, EGL_NO_SURFACE));
    give_back(seen);
    give_back(finished);
    buffers.reset();
  }
  ~Handles() {
    if (display == EGL_NO_DISPLAY) return;
    drop_buffers();
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    eglTerminate(display);
  }
};

KmsSurface::KmsSurface(int card) : handles_(std::make_unique<Handles>()) {
  auto& handles = *handles_;
  handles.card = card;
  handles.device.reset(gbm_create_device(card));
  if (!handles.device) fail("gbm_create_device");
  handles.display = eglGetPlatformDisplay(EGL_PLATFORM_GBM_KHR, handles.device.get(), nullptr);
  if (handles.display == EGL_NO_DISPLAY) fail("eglGetPlatformDisplay");
  if (!eglInitialize(handles.display, nullptr, nullptr)) fail("eglInitialize");
  eglBindAPI(EGL_OPENGL_ES_API);
  handles.config = config_of(handles.display);
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0, EGL_NONE};
  handles.context = eglCreateContext(handles.display, handles.config, EGL_NO_CONTEXT, version);
  if (handles.context == EGL_NO_CONTEXT) fail("eglCreateContext");
}

KmsSurface::~KmsSurface() = default;

void KmsSurface::resize(int width, int height) {
  auto& handles = *handles_;
  handles.drop_buffers();
  handles.buffers.reset(gbm_surface_create(handles.device.get(), static_cast<std::uint32_t>(width),
                                           static_cast<std::uint32_t>(height), kFormat,
                                           GBM_BO_USE_SCANOUT | GBM_BO_USE_RENDERING));
  if (!handles.buffers) fail("gbm_surface_create");
  handles.surface = eglCreatePlatformWindowSurface(handles.display, handles.config, handles.buffers.get(), nullptr);
  if (handles.surface == EGL_NO_SURFACE) fail("eglCreatePlatformWindowSurface");
  handles.make_current();
}

std::uint32_t KmsSurface::finish_picture() {
  auto& handles = *handles_;
  glFinish();  // software renderers have no fence that the kernel could wait for
  if (!eglSwapBuffers(handles.display, handles.surface)) fail("eglSwapBuffers");
  handles.finished = gbm_surface_lock_front_buffer(handles.buffers.get());
  if (!handles.finished) fail("gbm_surface_lock_front_buffer");
  return framebuffer_of(handles.card, handles.finished);
}

void KmsSurface::shown() {
  handles_->give_back(handles_->seen);
  handles_->seen = std::exchange(handles_->finished, nullptr);
}

void KmsSurface::dropped() {
  handles_->give_back(handles_->finished);
}

std::string KmsSurface::renderer() const {
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return name ? name : "unknown";
}

}  // namespace rotunda::playback
