#pragma once
// A short text that differs wherever what was added differs (XXH3, 128 bits): a key for caches, not for secrets.
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

struct XXH3_state_s;

namespace rotunda::simulator {

class Fingerprint {
 public:
  Fingerprint();
  void add(std::string_view text);  // "ab", "c" differs from "a", "bc"
  // Numbers and what consists of nothing else: no padding, no pointers.
  template <class T>
  requires std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>
  void add(const T& value) { add_bytes(&value, sizeof value); }
  void add_bytes(const void* bytes, std::size_t size);
  std::string text() const;  // 32 hexadecimal digits

 private:
  struct Free {
    void operator()(XXH3_state_s* state) const noexcept;
  };
  std::unique_ptr<XXH3_state_s, Free> state_;
};

}  // namespace rotunda::simulator
