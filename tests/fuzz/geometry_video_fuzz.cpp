// Any bytes as a geometry video: refused, or its frames are read, each of the size the header promises and finite.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

#include "config/errors.h"
#include "recon/video/geometry_video.h"

namespace rotunda::recon {
namespace {

constexpr int kFrames = 3;       // of each input
constexpr int kFinestLevel = 7;  // larger ones only take longer

void require(bool claim) {
  if (!claim) std::abort();
}

void read_frames(const std::filesystem::path& file) {
  GeometryVideoReader reader(file);
  const auto& header = reader.header();
  require(reader.frame_count() > 0);
  if (header.level > kFinestLevel || header.colour_level > kFinestLevel) return;
  for (int frame = std::min(kFrames, reader.frame_count()) - 1; frame >= 0; --frame) {
    const auto image = reader.read(frame);
    const auto side = static_cast<std::size_t>(image.side()),
               colour_side = static_cast<std::size_t>(image.colour_side());
    require(image.positions.size() == side * side && image.normals.size() == side * side);
    require(image.colours.size() == colour_side * colour_side && image.coverage.size() == colour_side * colour_side);
    for (const auto& position : image.positions) require(position.allFinite());
  }
}

void run(const std::uint8_t* data, std::size_t size) {
  const int file = ::memfd_create("geometry_video", 0);
  require(file >= 0 && ::write(file, data, size) == static_cast<ssize_t>(size));
  try {
    read_frames("/proc/self/fd/" + std::to_string(file));
  } catch (const CorruptData&) {
  } catch (const std::system_error&) {
  }
  ::close(file);
}

}  // namespace
}  // namespace rotunda::recon

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  rotunda::recon::run(data, size);
  return 0;
}
