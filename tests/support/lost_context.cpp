#include "tests/support/lost_context.h"

#include <EGL/egl.h>
#include <GLES3/gl32.h>
#include <dlfcn.h>

#include <atomic>
#include <string_view>

namespace {

std::atomic<int> to_lose{0}, lost{0}, last_question{0}, questions{0};
std::atomic<bool> dead{false};

template <class Function>
Function real(Function, const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

GLenum status() {
  if (!dead && lost < to_lose && ++questions == last_question) {
    dead = true;
    ++lost;
  }
  return dead ? GL_UNKNOWN_CONTEXT_RESET : GL_NO_ERROR;
}

}  // namespace

extern "C" {

// Every new context asks anew.
__eglMustCastToProperFunctionPointerType eglGetProcAddress(const char* name) {
  static const auto next = real(&eglGetProcAddress, "eglGetProcAddress");
  if (!std::string_view(name).starts_with("glGetGraphicsResetStatus")) return next(name);
  dead = false;
  questions = 0;
  return reinterpret_cast<__eglMustCastToProperFunctionPointerType>(&status);
}

void glDrawElements(GLenum mode, GLsizei count, GLenum type, const void* indices) {
  static const auto next = real(&glDrawElements, "glDrawElements");
  if (!dead) next(mode, count, type, indices);
}
}

void rotunda::tests::lose_contexts(int times, int shown) {
  to_lose = times;
  last_question = shown;
  lost = 0;
}

int rotunda::tests::contexts_lost() {
  return lost;
}
