#include "capture/take/camera_file_rest.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>

#include "capture/base/crc32c.h"
#include "capture/base/readable_file.h"
#include "capture/take/new_file.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "RotRest1";
constexpr std::size_t kHeader = 32;  // magic, size of the file, of a frame, number of frames
constexpr std::size_t kCheckSum = 4;

template <class Unsigned>
void put(std::vector<std::uint8_t>& bytes, Unsigned value) {
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

template <class Unsigned>
Unsigned number_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  Unsigned value = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) value |= static_cast<Unsigned>(bytes[at + i]) << (8 * i);
  return value;
}

std::vector<std::uint8_t> read_all(const fs::path& file) {
  const ReadableFile input(file);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(input.size()));
  bytes.resize(input.read(0, bytes));
  return bytes;
}

// Its own CRC holds: what is told here would be a mistake of the writer, or of someone with time to spare.
void check_places(const CameraFileRest& rest, const fs::path& file) {
  const std::uint64_t pixels = rest.frame_bytes * rest.pixel_places.size();
  if (rest.file_bytes != pixels + rest.bytes.size()) throw CorruptData(file, 8, "its sizes do not add up");
  std::uint64_t free_from = 0;
  for (std::size_t i = 0; i < rest.pixel_places.size(); ++i) {
    const std::uint64_t place = rest.pixel_places[i];
    if (place < free_from || place > rest.file_bytes - rest.frame_bytes)
      throw CorruptData(file, kHeader + 8 * i, fmt::format("frame {} lies where none can", i));
    free_from = place + rest.frame_bytes;
  }
}

}  // namespace

std::vector<StoredFrame> separable_frames(const CameraFileReader& file, std::uint64_t frame_bytes) {
  std::vector<StoredFrame> frames;
  std::int64_t free_from = 0;
  for (const auto& frame : file.frames()) {
    if (!frame.record || frame.size != frame_bytes || frame.offset < free_from) continue;
    free_from = frame.offset + static_cast<std::int64_t>(frame.size);
    frames.push_back(frame);
  }
  return frames;
}

CameraFileRest take_apart(const fs::path& file, std::span<const StoredFrame> frames, std::uint64_t frame_bytes,
                          const std::function<void(std::size_t, std::vector<std::uint8_t>)>& pixels,
                          const ByteSink& all) {
  const ReadableFile input(file);
  CameraFileRest rest{.file_bytes = static_cast<std::uint64_t>(input.size()),
                      .frame_bytes = frame_bytes,
                      .pixel_places = {},
                      .bytes = {}};
  const auto bytes_between = [&](std::uint64_t from, std::uint64_t to) {
    std::vector<std::uint8_t> bytes(to - from);
    if (input.read(static_cast<std::int64_t>(from), bytes) != bytes.size())
      throw CorruptData(file, from, "ended while it was read: is it still being written?");
    all(bytes);
    return bytes;
  };
  std::uint64_t done = 0;
  const auto keep_until = [&](std::uint64_t place) {
    const auto bytes = bytes_between(done, place);
    rest.bytes.insert(rest.bytes.end(), bytes.begin(), bytes.end());
    done = place;
  };
  for (std::size_t i = 0; i < frames.size(); ++i) {
    keep_until(static_cast<std::uint64_t>(frames[i].offset));
    rest.pixel_places.push_back(done);
    pixels(i, bytes_between(done, done + frame_bytes));
    done += frame_bytes;
  }
  keep_until(rest.file_bytes);
  return rest;
}

void put_together(const CameraFileRest& rest, const std::function<std::vector<std::uint8_t>(std::size_t)>& pixels,
                  const ByteSink& all) {
  std::span<const std::uint8_t> others = rest.bytes;
  std::uint64_t done = 0;
  const auto others_until = [&](std::uint64_t place) {
    all(others.first(place - done));
    others = others.subspan(place - done);
    done = place;
  };
  for (std::size_t i = 0; i < rest.pixel_places.size(); ++i) {
    others_until(rest.pixel_places[i]);
    const auto bytes = pixels(i);
    if (bytes.size() != rest.frame_bytes) throw CorruptData(fmt::format("frame {} has not the size it had", i));
    all(bytes);
    done += rest.frame_bytes;
  }
  others_until(rest.file_bytes);
}

void write_rest(const fs::path& file, const CameraFileRest& rest) {
  std::vector<std::uint8_t> bytes(kMagic.begin(), kMagic.end());
  put(bytes, rest.file_bytes);
  put(bytes, rest.frame_bytes);
  put(bytes, static_cast<std::uint64_t>(rest.pixel_places.size()));
  for (const auto place : rest.pixel_places) put(bytes, place);
  bytes.insert(bytes.end(), rest.bytes.begin(), rest.bytes.end());
  put(bytes, crc32c(bytes));
  NewFile output(file);
  output.write(bytes);
  output.close();
}

CameraFileRest read_rest(const fs::path& file) {
  const auto bytes = read_all(file);
  const std::span<const std::uint8_t> all(bytes);
  if (bytes.size() < kHeader + kCheckSum || !std::equal(kMagic.begin(), kMagic.end(), bytes.begin()))
    throw CorruptData(file, 0, "is not the rest of a camera's file, or cut short");
  const std::size_t end = bytes.size() - kCheckSum;
  if (crc32c(all.first(end)) != number_at<std::uint32_t>(all, end))
    throw CorruptData(file, end, "has changed since it was written: its check sum does not hold");
  CameraFileRest rest{.file_bytes = number_at<std::uint64_t>(all, 8),
                      .frame_bytes = number_at<std::uint64_t>(all, 16),
                      .pixel_places = {},
                      .bytes = {}};
  const auto frames = number_at<std::uint64_t>(all, 24);
  if (frames > (end - kHeader) / 8 || rest.file_bytes > std::uint64_t{1} << 62U || rest.frame_bytes > rest.file_bytes ||
      (frames > 0 && rest.frame_bytes > rest.file_bytes / frames))
    throw CorruptData(file, 24, "its sizes do not add up");
  for (std::size_t i = 0; i < frames; ++i) rest.pixel_places.push_back(number_at<std::uint64_t>(all, kHeader + 8 * i));
  rest.bytes.assign(bytes.begin() + static_cast<std::ptrdiff_t>(kHeader + 8 * frames),
                    bytes.begin() + static_cast<std::ptrdiff_t>(end));
  check_places(rest, file);
  return rest;
}

}  // namespace rotunda::capture
