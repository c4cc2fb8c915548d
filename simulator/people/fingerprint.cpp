#include "simulator/people/fingerprint.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <new>

namespace rotunda::simulator {

void Fingerprint::Free::operator()(XXH3_state_s* state) const noexcept {
  XXH3_freeState(state);
}

Fingerprint::Fingerprint() : state_(XXH3_createState()) {
  if (!state_) throw std::bad_alloc();
  XXH3_128bits_reset(state_.get());
}

void Fingerprint::add(std::string_view text) {
  add(text.size());
  add_bytes(text.data(), text.size());
}

void Fingerprint::add_bytes(const void* bytes, std::size_t size) {
  XXH3_128bits_update(state_.get(), bytes, size);
}

std::string Fingerprint::text() const {
  const auto digest = XXH3_128bits_digest(state_.get());
  return fmt::format("{:016x}{:016x}", digest.high64, digest.low64);
}

}  // namespace rotunda::simulator
