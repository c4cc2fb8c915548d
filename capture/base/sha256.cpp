#include "capture/base/sha256.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <new>
#include <vector>

#include "capture/base/readable_file.h"

namespace rotunda::capture {

void Sha256::Free::operator()(evp_md_ctx_st* context) const noexcept {
  EVP_MD_CTX_free(context);
}

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) throw std::bad_alloc();
}

// OpenSSL's digests in memory fail only for want of memory.
void Sha256::add(std::span<const std::uint8_t> bytes) {
  if (EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) != 1) throw std::bad_alloc();
}

std::string Sha256::hex() {
  std::array<std::uint8_t, 32> digest{};
  if (EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr) != 1) throw std::bad_alloc();
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

std::string sha256_of(const std::filesystem::path& file) {
  constexpr std::size_t piece = 1 << 20;
  const ReadableFile input(file);
  std::vector<std::uint8_t> bytes(piece);
  Sha256 sum;
  for (std::int64_t at = 0;;) {
    const std::size_t got = input.read(at, bytes);
    sum.add(std::span(bytes).first(got));
    if (got < piece) return sum.hex();
    at += static_cast<std::int64_t>(got);
  }
}

}  // namespace rotunda::capture
