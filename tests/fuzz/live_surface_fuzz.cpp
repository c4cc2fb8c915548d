// Any bytes as a live surface: refused, or a surface that packs to the same bytes' worth and is safe to draw. Half of
// the inputs get the check sum that belongs to them, or the fuzzer would never come past it.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "capture/base/crc32c.h"
#include "config/errors.h"
#include "recon/live_surface.h"

namespace rotunda::recon {
namespace {

void require(bool claim) {
  if (!claim) std::abort();
}

void unpack(const std::vector<std::uint8_t>& bytes) {
  try {
    const auto surface = unpack_surface(bytes);
    const auto& mesh = surface.mesh;
    require(mesh.colours.size() == mesh.positions.size());
    for (const auto& position : mesh.positions) require(position.allFinite());
    for (const auto& triangle : mesh.triangles)
      for (const auto vertex : triangle) require(vertex < mesh.positions.size());
    require(pack_surface(surface).size() == bytes.size());
  } catch (const CorruptData&) {
  }
}

}  // namespace
}  // namespace rotunda::recon

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> bytes(data, data + size);
  rotunda::recon::unpack(bytes);
  if (size < 4) return 0;
  const auto sum = rotunda::capture::crc32c({data, size - 4});
  for (std::size_t i = 0; i < 4; ++i) bytes[size - 4 + i] = static_cast<std::uint8_t>(sum >> (8 * i));
  rotunda::recon::unpack(bytes);
  return 0;
}
