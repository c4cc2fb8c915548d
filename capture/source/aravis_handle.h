#pragma once
// Owners for what Aravis and GLib hand out, and its errors as ours.
#include <arv.h>

#include <memory>
#include <string>

#include "config/errors.h"

namespace rotunda::capture {

struct GObjectUnref {
  void operator()(gpointer object) const noexcept { g_object_unref(object); }
};
template <class T>
using GRef = std::unique_ptr<T, GObjectUnref>;

struct GFree {
  void operator()(gconstpointer memory) const noexcept { g_free(const_cast<gpointer>(memory)); }
};

// What Aravis says, which may be nothing.
inline std::string or_empty(const char* text) {
  return text ? text : "";
}

// The GError** of one call; throws afterwards if it was set.
class ErrorCatcher {
 public:
  ErrorCatcher() = default;
  ErrorCatcher(const ErrorCatcher&) = delete;
  ErrorCatcher& operator=(const ErrorCatcher&) = delete;
  ~ErrorCatcher() { g_clear_error(&error_); }

  GError** out() { return &error_; }
  explicit operator bool() const { return error_ != nullptr; }
  std::string message() const { return error_ ? error_->message : ""; }
  bool is(int device_error) const { return error_ && g_error_matches(error_, ARV_DEVICE_ERROR, device_error); }

 private:
  GError* error_ = nullptr;
};

}  // namespace rotunda::capture
