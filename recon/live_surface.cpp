#include "recon/live_surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "capture/base/crc32c.h"
#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic{'R', 'S', 'F', '1'};
constexpr std::size_t kHeaderBytes = 4 + 8 + 8 + 8 + 4 + 4 + 24;
constexpr std::size_t kVertexBytes = 3 * 2 + 3, kTriangleBytes = 3 * 4, kSumBytes = 4;
constexpr float kSteps = 65535.0F;

class Packer {
 public:
  explicit Packer(std::size_t bytes) { bytes_.reserve(bytes); }
  template <class T>
  void number(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void real(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    number(bits);
  }
  void raw(std::span<const std::uint8_t> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  std::vector<std::uint8_t>& bytes() { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

// Over bytes whose number was checked before.
class Unpacker {
 public:
  explicit Unpacker(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  template <class T>
  T number() {
    T value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      value = static_cast<T>(value | static_cast<T>(T{bytes_[at_ + i]} << (8 * i)));
    at_ += sizeof(T);
    return value;
  }
  float real() {
    const auto bits = number<std::uint32_t>();
    float value = 0.0F;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  std::size_t at() const { return at_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

[[noreturn]] void refuse(std::size_t offset, const std::string& why) {
  throw CorruptData("live surface", offset, why);
}

void check_to_pack(const TriangleMesh& mesh) {
  if (mesh.positions.size() > kMostLiveVertices || mesh.triangles.size() > 2 * kMostLiveVertices)
    throw InvalidInput(
        fmt::format("{} vertices are too many for a live surface: cut it into larger cells", mesh.positions.size()));
  if (mesh.colours.size() != mesh.positions.size()) throw InvalidInput("a live surface needs a colour a vertex");
  for (const auto& position : mesh.positions)
    if (!position.allFinite()) throw InvalidInput("a live surface has a position that is no number");
  for (const auto& triangle : mesh.triangles)
    for (const auto vertex : triangle)
      if (vertex >= mesh.positions.size()) throw InvalidInput("a live surface has a triangle beyond its vertices");
}

Eigen::AlignedBox3f box_of(const TriangleMesh& mesh) {
  if (mesh.positions.empty()) return {Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
  Eigen::AlignedBox3f box;
  for (const auto& position : mesh.positions) box.extend(position);
  return box;
}

std::int64_t ns_of(capture::Timestamp time) {
  return time.time_since_epoch().count();
}

capture::Timestamp time_of(std::int64_t ns) {
  return capture::Timestamp(std::chrono::nanoseconds(ns));
}

struct Header {
  LiveSurface surface;  // without its mesh
  std::size_t vertices = 0, triangles = 0;
  Eigen::AlignedBox3f box;
};

Header read_header(std::span<const std::uint8_t> bytes, Unpacker& from) {
  Header header;
  for (const auto letter : kMagic)
    if (from.number<std::uint8_t>() != letter) refuse(0, "this is no live surface, or one of another version");
  header.surface.trigger = from.number<std::uint64_t>();
  header.surface.exposure = time_of(static_cast<std::int64_t>(from.number<std::uint64_t>()));
  header.surface.made = time_of(static_cast<std::int64_t>(from.number<std::uint64_t>()));
  header.vertices = from.number<std::uint32_t>();
  header.triangles = from.number<std::uint32_t>();
  for (int i = 0; i < 3; ++i) header.box.min()[i] = from.real();
  for (int i = 0; i < 3; ++i) header.box.max()[i] = from.real();
  if (header.vertices > kMostLiveVertices || header.triangles > 2 * kMostLiveVertices)
    refuse(28, fmt::format("{} vertices and {} triangles are more than a live surface has", header.vertices,
                           header.triangles));
  const auto wanted = kHeaderBytes + header.vertices * kVertexBytes + header.triangles * kTriangleBytes + kSumBytes;
  if (bytes.size() != wanted)
    refuse(28, fmt::format("{} vertices and {} triangles take {} bytes, but {} came", header.vertices, header.triangles,
                           wanted, bytes.size()));
  const Eigen::Vector3f sides = header.box.max() - header.box.min();
  if (!header.box.min().allFinite() || !sides.allFinite() || sides.minCoeff() < 0.0F) refuse(36, "the box is none");
  return header;
}

}  // namespace

std::vector<std::uint8_t> pack_surface(const LiveSurface& surface) {
  const auto& mesh = surface.mesh;
  check_to_pack(mesh);
  Packer to(kHeaderBytes + mesh.positions.size() * kVertexBytes + mesh.triangles.size() * kTriangleBytes + kSumBytes);
  to.raw(kMagic);
  to.number(surface.trigger);
  to.number(static_cast<std::uint64_t>(ns_of(surface.exposure)));
  to.number(static_cast<std::uint64_t>(ns_of(surface.made)));
  to.number(static_cast<std::uint32_t>(mesh.positions.size()));
  to.number(static_cast<std::uint32_t>(mesh.triangles.size()));
  const auto box = box_of(mesh);
  for (int i = 0; i < 3; ++i) to.real(box.min()[i]);
  for (int i = 0; i < 3; ++i) to.real(box.max()[i]);
  const Eigen::Vector3f scale = kSteps * (box.max() - box.min()).cwiseMax(1e-30F).cwiseInverse();
  for (const auto& position : mesh.positions)
    for (int i = 0; i < 3; ++i)
      to.number(static_cast<std::uint16_t>(
          std::clamp(std::lround((position[i] - box.min()[i]) * scale[i]), 0L, static_cast<long>(kSteps))));
  for (const auto& colour : mesh.colours) to.raw(colour);
  for (const auto& triangle : mesh.triangles)
    for (const auto vertex : triangle) to.number(vertex);
  to.number(capture::crc32c(to.bytes()));
  return std::move(to.bytes());
}

LiveSurface unpack_surface(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kHeaderBytes + kSumBytes) refuse(bytes.size(), "it ends within its header");
  Unpacker from(bytes);
  auto header = read_header(bytes, from);
  const auto body = bytes.first(bytes.size() - kSumBytes);
  if (Unpacker(bytes.last(kSumBytes)).number<std::uint32_t>() != capture::crc32c(body))
    refuse(body.size(), "its check sum is wrong");
  auto& mesh = header.surface.mesh;
  const Eigen::Vector3f step = (header.box.max() - header.box.min()) / kSteps;
  mesh.positions.resize(header.vertices);
  for (auto& position : mesh.positions)
    for (int i = 0; i < 3; ++i)
      position[i] = header.box.min()[i] + step[i] * static_cast<float>(from.number<std::uint16_t>());
  mesh.colours.resize(header.vertices);
  for (auto& colour : mesh.colours)
    for (auto& channel : colour) channel = from.number<std::uint8_t>();
  mesh.triangles.resize(header.triangles);
  for (auto& triangle : mesh.triangles)
    for (auto& vertex : triangle) {
      vertex = from.number<std::uint32_t>();
      if (vertex >= header.vertices) refuse(from.at() - 4, "a triangle points beyond the vertices");
    }
  return std::move(header.surface);
}

}  // namespace rotunda::recon
