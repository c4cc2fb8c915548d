#include "capture/take/archived_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "capture/base/readable_file.h"
#include "capture/base/sha256.h"
#include "capture/take/archive_manifest.h"
#include "capture/take/new_file.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPiece = 1 << 20;  // bytes copied at once

void require_nameable(const fs::path& path) {
  const auto name = path.string();
  const bool odd = std::any_of(name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r' || c == '\\'; });
  if (odd) throw InvalidInput(path.string() + ": a file of this name cannot be archived; rename it");
}

CameraFileRest matching_rest(const fs::path& archive, const TakeCamera& camera, const CameraFileReader& reader) {
  const auto file = camera_file(archive, camera.name);
  if (!reader.problem().empty()) throw CorruptData(reader.problem());
  auto rest = read_rest(rest_file(archive, camera.name));
  if (rest.pixel_places.size() != reader.frames().size())
    throw CorruptData(fmt::format("{}: holds {} frames, {} were archived", file.string(), reader.frames().size(),
                                  rest.pixel_places.size()));
  return rest;
}

}  // namespace

SharedProgress::SharedProgress(const Progress& progress, std::stop_token stop, std::string what)
    : progress_(progress), stop_(std::move(stop)), what_(std::move(what)) {}

void SharedProgress::step() {
  throw_if_stopped();
  const std::lock_guard lock(mutex_);
  ++done_;
  if (progress_) progress_(done_, total_);
}

void SharedProgress::throw_if_stopped() const {
  if (stop_.stop_requested()) throw std::system_error(std::make_error_code(std::errc::operation_canceled), what_);
}

std::string new_take_name(const fs::path& folder) {
  const auto name = folder.filename().string();
  if (!valid_take_name(name)) throw InvalidInput("'" + name + "' cannot be the name of a take");
  if (fs::exists(folder)) throw InvalidInput(folder.string() + " exists already: choose another place or name");
  return name;
}

std::vector<std::string> files_of_take(const fs::path& folder) {
  std::vector<std::string> files;
  for (auto entry = fs::recursive_directory_iterator(folder); entry != fs::recursive_directory_iterator(); ++entry) {
    const auto path = entry->path().lexically_relative(folder);
    if (entry.depth() == 0 && entry->is_directory() && (path == "recon" || path == "archive")) {
      entry.disable_recursion_pending();
      continue;
    }
    if (entry->is_directory() && !entry->is_symlink()) continue;
    if (!entry->is_regular_file()) throw InvalidInput(entry->path().string() + ": is neither a file nor a folder");
    require_nameable(path);
    files.push_back(path.string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::uint64_t bytes_of_take(const fs::path& folder) {
  std::uint64_t bytes = 0;
  for (const auto& file : files_of_take(folder)) bytes += fs::file_size(folder / file);
  if (fs::exists(folder / "archive"))
    for (const auto& entry : fs::directory_iterator(folder / "archive")) bytes += entry.file_size();
  return bytes;
}

std::string write_hashed(const fs::path& file, const std::function<void(const ByteSink&)>& write) {
  fs::create_directories(file.parent_path());
  NewFile output(file);
  Sha256 sum;
  write([&](std::span<const std::uint8_t> bytes) {
    sum.add(bytes);
    output.write(bytes);
  });
  output.close();
  return sum.hex();
}

std::string copy_file_hashed(const fs::path& from, const fs::path& to) {
  const ReadableFile input(from);
  return write_hashed(to, [&](const ByteSink& all) {
    std::vector<std::uint8_t> bytes(kPiece);
    for (std::int64_t at = 0;;) {
      const std::size_t got = input.read(at, bytes);
      all(std::span(bytes).first(got));
      if (got < kPiece) return;
      at += static_cast<std::int64_t>(got);
    }
  });
}

void put_camera_file_together(const fs::path& archive, const TakeCamera& camera, const ByteSink& all,
                              const std::function<void()>& step) {
  const auto file = camera_file(archive, camera.name);
  const CameraFileReader reader(file, camera);
  const auto rest = matching_rest(archive, camera, reader);
  const auto pixels = [&](std::size_t i) {
    auto bytes = reader.read_bytes(reader.frames()[i]);
    if (!bytes)
      throw CorruptData(file, static_cast<std::uint64_t>(reader.frames()[i].offset),
                        fmt::format("frame {} cannot be decoded", i));
    step();
    return std::move(*bytes);
  };
  put_together(rest, pixels, all);
}

}  // namespace rotunda::capture
