#pragma once
// SHA-256 (FIPS 180-4), by which files are compared that must be the same to the last bit; the sums are those of
// sha256sum(1).
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

struct evp_md_ctx_st;

namespace rotunda::capture {

class Sha256 {
 public:
  Sha256();  // throws std::bad_alloc
  void add(std::span<const std::uint8_t> bytes);
  std::string hex();  // of all that was added, 64 lower-case digits; nothing may be added afterwards

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const noexcept;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

// Throws std::system_error if the file cannot be read.
std::string sha256_of(const std::filesystem::path& file);

}  // namespace rotunda::capture
