#pragma once
// Whether the current OpenGL ES context was lost: by the driver's own word (OpenGL ES 3.2, KHR_robustness or
// EXT_robustness), and by EGL's after a picture was shown.

namespace rotunda::playback {

class ContextReset {
 public:
  ContextReset();         // of the context that is current now
  bool happened() const;  // to be asked right after the picture was shown

 private:
  using Status = unsigned (*)();
  Status status_ = nullptr;  // none: the driver does not tell
};

}  // namespace rotunda::playback
