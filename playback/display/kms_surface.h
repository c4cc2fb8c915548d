#pragma once
// Buffers that OpenGL ES draws into and a graphics device scans out (GBM, EGL), with a GLES 3 context, current on the
// thread that made it. Devices that cannot draw have Mesa's software renderer draw into theirs. Throws DeviceError.
#include <cstdint>
#include <memory>
#include <string>

namespace rotunda::playback {

class KmsSurface {
 public:
  explicit KmsSurface(int card);  // lent: stays open as long as this lives
  ~KmsSurface();
  KmsSurface(const KmsSurface&) = delete;
  KmsSurface& operator=(const KmsSurface&) = delete;

  // New buffers of this size, in pixels; the ones before must no longer be shown.
  void resize(int width, int height);
  // Finishes what was drawn. The framebuffer holds it until two more were finished and shown.
  std::uint32_t finish_picture();
  // What was finished last is what is seen now: the one before may be drawn into.
  void shown();
  // What was finished last is not going to be seen.
  void dropped();

  std::string renderer() const;  // "llvmpipe (LLVM 15.0.6, 256 bits)"

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace rotunda::playback
