// Any bytes as a glTF file: read or refused; a character that is read can be posed at any moment of its clips.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "config/errors.h"
#include "recon/gltf/gltf_character.h"

namespace rotunda::recon {
namespace {

void require(bool claim) {
  if (!claim) std::abort();
}

// A file in memory that holds these bytes, for readers that want a path.
std::filesystem::path file_of(const std::uint8_t* data, std::size_t size) {
  static const int file = memfd_create("fuzzed.glb", 0);
  require(ftruncate(file, 0) == 0 && pwrite(file, data, size, 0) == static_cast<ssize_t>(size));
  return "/proc/self/fd/" + std::to_string(file);
}

void pose(const GltfCharacter& character, const CharacterClip* clip, double seconds) {
  const auto state = state_at(character, clip, seconds);
  for (const auto& part : character.parts)
    require(posed_positions(character, part, state).size() == part.positions.size());
}

void run(const std::uint8_t* data, std::size_t size) {
  try {
    const auto character = read_gltf_character(file_of(data, size));
    pose(character, nullptr, 0.0);
    for (const auto& clip : character.clips)
      for (const double seconds : {clip.begin - 1.0, 0.5 * (clip.begin + clip.end), clip.end + 1.0})
        pose(character, &clip, seconds);
  } catch (const CorruptData&) {
  } catch (const InvalidInput&) {
  }
}

}  // namespace
}  // namespace rotunda::recon

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  rotunda::recon::run(data, size);
  return 0;
}
