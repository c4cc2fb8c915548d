#pragma once
// One live surface as it travels from the daemon to its viewers. World frame, the calibration's unit. Packed, all
// numbers with the lower byte first:
//   "RSF1", u64 trigger, i64 exposure and i64 made (ns TAI), u32 vertices, u32 triangles, 6 f32 box (least, greatest),
//   3 u16 a vertex: position, 0 to 65535 over the box (0.05 mm in a box of 3 m),
//   3 u8 a vertex: colour, 3 u32 a triangle: vertices, u32 CRC-32C of all before.
// Normals do not travel: who draws makes them.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "capture/frame.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct LiveSurface {
  std::uint64_t trigger = 0;
  capture::Timestamp exposure;  // the moment it shows
  capture::Timestamp made;      // when it was ready
  TriangleMesh mesh;            // positions, colours, triangles
};

inline constexpr std::size_t kMostLiveVertices = std::size_t{1} << 22;  // and twice as many triangles, 12 + 25 MB

// Throws InvalidInput for a mesh that could not be unpacked again: too large, without a colour a vertex, a position
// that is no number, a triangle beyond its vertices.
std::vector<std::uint8_t> pack_surface(const LiveSurface& surface);
// Throws CorruptData, with the offset, for anything that pack_surface does not make; never reserves more than the bytes
// that came can hold.
LiveSurface unpack_surface(std::span<const std::uint8_t> bytes);

}  // namespace rotunda::recon
