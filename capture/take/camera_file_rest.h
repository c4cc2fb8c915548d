#pragma once
// What is left of a camera's file when its frames' pixels are taken out: headers, records, indices, and whatever was
// damaged. An archived take keeps it beside the compressed pixels (archive/<camera>.rest), so that the file as it was
// recorded can be put together again to the last bit. docs/take-format.md has the bytes.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "capture/take/camera_file_reader.h"

namespace rotunda::capture {

struct CameraFileRest {
  std::uint64_t file_bytes = 0;             // of the whole file
  std::uint64_t frame_bytes = 0;            // of one frame's pixels
  std::vector<std::uint64_t> pixel_places;  // where in the file the pixels of each frame begin, rising
  std::vector<std::uint8_t> bytes;          // all others, in their order
};

// Takes bytes of a file, one piece after another.
using ByteSink = std::function<void(std::span<const std::uint8_t>)>;

// The frames whose pixels can be taken out: those with a record, of the size a frame has, none over another.
std::vector<StoredFrame> separable_frames(const CameraFileReader& file, std::uint64_t frame_bytes);

// Reads it all, in order: the rest into `rest.bytes`; pixels are handed to `pixels` with their frame's number and, as
// everything, to `all`. Throws std::system_error.
CameraFileRest take_apart(const std::filesystem::path& file, std::span<const StoredFrame> frames,
                          std::uint64_t frame_bytes,
                          const std::function<void(std::size_t, std::vector<std::uint8_t>)>& pixels,
                          const ByteSink& all);

// The whole file again. `pixels` gives each frame's; throws CorruptData for a frame of another size.
void put_together(const CameraFileRest& rest, const std::function<std::vector<std::uint8_t>(std::size_t)>& pixels,
                  const ByteSink& all);

// Writing makes a new file and throws std::system_error. Reading throws CorruptData (with what
// is wrong, at which byte) or std::system_error.
void write_rest(const std::filesystem::path& file, const CameraFileRest& rest);
CameraFileRest read_rest(const std::filesystem::path& file);

}  // namespace rotunda::capture
