#include "simulator/studio/frame_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <system_error>

#include "capture/base/crc32c.h"
#include "config/errors.h"

namespace rotunda::simulator {
namespace fs = std::filesystem;
namespace {

using capture::UniqueFd;

constexpr std::array<char, 8> kMagic{'R', 'T', 'N', 'D', 'P', 'I', 'C', '1'};
constexpr std::uint64_t kSpareBytes = 500'000'000;  // the disk keeps so much free
constexpr auto kAbandoned = std::chrono::hours{1};  // a half written frame nobody works at any more

[[noreturn]] void fail(const fs::path& file, const char* what) {
  throw std::system_error(errno, std::generic_category(), fmt::format("{}: {}", file.string(), what));
}

// Head of a frame's file: the magic, then each camera's CRC-32C, little-endian.
std::uint64_t head_bytes(std::size_t cameras) {
  return kMagic.size() + cameras * sizeof(std::uint32_t);
}

std::uint64_t sum(const std::vector<std::uint64_t>& bytes) {
  return std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0});
}

void write_all(int fd, std::span<const std::uint8_t> bytes, const fs::path& file) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(file, "cannot be written");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

// Under another name first, which nobody else has: whoever sees the file sees all of it.
void write_whole(const fs::path& file, std::span<const std::span<const std::uint8_t>> pieces) {
  constexpr std::string_view kEnding = ".part";
  std::string part = file.string() + ".XXXXXX" + std::string(kEnding);
  {
    const UniqueFd out(::mkostemps(part.data(), static_cast<int>(kEnding.size()), O_CLOEXEC));
    if (!out) fail(part, "cannot be created");
    for (const auto piece : pieces) write_all(out.get(), piece, part);
    fchmod(out.get(), 0644);
  }
  fs::rename(part, file);
}

bool read_at(int fd, std::uint64_t offset, std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    offset += static_cast<std::uint64_t>(got);
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

std::optional<EntryShape> read_shape(const fs::path& folder) {
  std::ifstream file(folder / "entry.json");
  if (!file) return std::nullopt;
  const auto json = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  const auto is_number = [](const nlohmann::json& value) { return value.is_number_unsigned(); };
  if (!json.is_object() || !json.contains("frames") || !is_number(json["frames"]) || !json.contains("picture_bytes") ||
      !json["picture_bytes"].is_array() || json["picture_bytes"].empty() ||
      !std::all_of(json["picture_bytes"].begin(), json["picture_bytes"].end(), is_number))
    return std::nullopt;  // damaged: made again
  return EntryShape{json["frames"].get<int>(), json["picture_bytes"].get<std::vector<std::uint64_t>>()};
}

// Shared with other users; nothing if somebody is removing the entry.
UniqueFd lock_in(const fs::path& folder) {
  for (;;) {
    fs::create_directories(folder);
    const auto file = folder / "lock";
    UniqueFd lock(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
    if (!lock && errno == ENOENT) continue;  // just removed
    if (!lock) fail(file, "cannot be opened");
    if (flock(lock.get(), LOCK_SH) != 0) fail(file, "cannot be locked");
    struct stat ours {
    }, theirs{};
    if (fstat(lock.get(), &ours) != 0) fail(file, "cannot be examined");
    if (stat(file.c_str(), &theirs) == 0 && ours.st_ino == theirs.st_ino) {
      futimens(lock.get(), nullptr);  // used now
      return lock;
    }
  }
}

void sweep_abandoned(const fs::path& folder) {
  for (const auto& item : fs::directory_iterator(folder)) {
    std::error_code gone;
    const auto age = fs::file_time_type::clock::now() - fs::last_write_time(item, gone);
    if (!gone && item.path().extension() == ".part" && age > kAbandoned) fs::remove(item, gone);
  }
}

struct KeptEntry {
  fs::path folder;
  fs::file_time_type used;
  std::uint64_t bytes = 0;
};

std::vector<KeptEntry> kept_entries(const fs::path& cache) {
  std::vector<KeptEntry> entries;
  std::error_code gone;  // others may be removing what we look at
  for (const auto& item : fs::directory_iterator(cache)) {
    if (!fs::exists(item.path() / "lock", gone)) continue;
    KeptEntry entry{item.path(), fs::last_write_time(item.path() / "lock", gone), 0};
    for (fs::directory_iterator file(item.path(), gone), end; !gone && file != end; file.increment(gone)) {
      const auto size = fs::file_size(file->path(), gone);
      if (!gone) entry.bytes += size;
    }
    entries.push_back(entry);
  }
  return entries;
}

// False if somebody uses it.
bool remove_unused(const fs::path& entry) {
  const UniqueFd lock(::open((entry / "lock").c_str(), O_RDWR | O_CLOEXEC));
  if (!lock || flock(lock.get(), LOCK_EX | LOCK_NB) != 0) return false;
  const auto aside = entry.parent_path() / fmt::format(".gone-{}-{}", getpid(), entry.filename().string());
  std::error_code failed;
  fs::rename(entry, aside, failed);
  if (failed) return false;
  fs::remove_all(aside, failed);
  return true;
}

}  // namespace

std::uint64_t EntryShape::bytes() const {
  return static_cast<std::uint64_t>(frames) * (head_bytes(picture_bytes.size()) + sum(picture_bytes));
}

CacheEntry::CacheEntry(fs::path folder, UniqueFd lock, EntryShape shape)
    : folder_(std::move(folder)), lock_(std::move(lock)), shape_(std::move(shape)) {}

fs::path CacheEntry::file_of(int frame) const {
  return folder_ / fmt::format("frame{:06}.pictures", frame);
}

std::uint64_t CacheEntry::offset_of(std::size_t camera) const {
  const auto first = shape_.picture_bytes.begin();
  return std::accumulate(first, first + static_cast<std::ptrdiff_t>(camera), head_bytes(shape_.picture_bytes.size()));
}

bool CacheEntry::has(int frame) const {
  std::error_code failed;
  const auto size = fs::file_size(file_of(frame), failed);
  return !failed && size == offset_of(shape_.picture_bytes.size());
}

std::vector<int> CacheEntry::missing() const {
  std::vector<int> missing;
  for (int frame = 0; frame < shape_.frames; ++frame)
    if (!has(frame)) missing.push_back(frame);
  return missing;
}

void CacheEntry::write(int frame, const PictureSet& pictures) {
  std::vector<std::uint8_t> head(kMagic.begin(), kMagic.end());
  for (const auto& picture : pictures)
    for (const std::uint32_t crc = capture::crc32c(picture); const int shift : {0, 8, 16, 24})
      head.push_back(static_cast<std::uint8_t>(crc >> shift));
  const bool fits = std::equal(pictures.begin(), pictures.end(), shape_.picture_bytes.begin(),
                               shape_.picture_bytes.end(), [](const auto& p, auto bytes) { return p.size() == bytes; });
  if (!fits || frame < 0 || frame >= shape_.frames) throw InvalidInput("these pictures are not of this cache entry");
  std::vector<std::span<const std::uint8_t>> pieces{head};
  pieces.insert(pieces.end(), pictures.begin(), pictures.end());
  write_whole(file_of(frame), pieces);
}

bool CacheEntry::read(int frame, std::size_t camera, std::span<std::uint8_t> picture) const {
  const auto path = file_of(frame);
  const UniqueFd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file && errno == ENOENT) return false;
  if (!file) fail(path, "cannot be opened");
  std::array<std::uint8_t, 8> magic{};
  std::array<std::uint8_t, 4> crc{};
  const bool is_whole = read_at(file.get(), 0, magic) && std::equal(magic.begin(), magic.end(), kMagic.begin()) &&
                        read_at(file.get(), head_bytes(camera), crc) && read_at(file.get(), offset_of(camera), picture);
  std::uint32_t wanted = 0;
  for (std::size_t i = 0; i < crc.size(); ++i) wanted |= static_cast<std::uint32_t>(crc[i]) << (8 * i);
  if (is_whole && capture::crc32c(picture) == wanted) return true;
  spdlog::warn("frame cache: {} is damaged and was removed; it is rendered again at the next start", path.string());
  std::error_code gone;
  fs::remove(path, gone);
  return false;
}

void CacheEntry::announce(int frame) const {
  const UniqueFd file(::open(file_of(frame).c_str(), O_RDONLY | O_CLOEXEC));
  if (file) posix_fadvise(file.get(), 0, 0, POSIX_FADV_WILLNEED);
}

std::optional<PictureSet> CacheEntry::read(int frame) const {
  PictureSet pictures;
  for (std::size_t camera = 0; camera < shape_.picture_bytes.size(); ++camera) {
    pictures.emplace_back(shape_.picture_bytes[camera]);
    if (!read(frame, camera, pictures.back())) return std::nullopt;
  }
  return pictures;
}

std::optional<std::vector<PictureSet>> CacheEntry::read() const {
  std::vector<PictureSet> frames;
  for (int frame = 0; frame < shape_.frames; ++frame) {
    auto pictures = read(frame);
    if (!pictures) return std::nullopt;
    frames.push_back(std::move(*pictures));
  }
  return frames;
}

fs::path FrameCache::default_folder() {
  const auto variable = [](const char* name) -> fs::path {
    const char* value = std::getenv(name);
    return value != nullptr && *value == '/' ? value : "";  // XDG: relative paths are to be ignored
  };
  const auto cache = variable("XDG_CACHE_HOME"), home = variable("HOME");
  if (!cache.empty()) return cache / "rotunda/studio";
  return (home.empty() ? fs::temp_directory_path() / fmt::format("rotunda-{}", getuid()) : home / ".cache/rotunda") /
         "studio";
}

FrameCache::FrameCache(Options options) : options_(std::move(options)) {
  fs::create_directories(options_.folder);
}

std::optional<CacheEntry> FrameCache::find(const PictureKey& key) {
  const auto folder = options_.folder / key.digest;
  if (!read_shape(folder)) return std::nullopt;
  auto lock = lock_in(folder);
  auto shape = read_shape(folder);  // now that nobody removes it
  if (!shape) return std::nullopt;
  return CacheEntry(folder, std::move(lock), std::move(*shape));
}

CacheEntry FrameCache::open(const PictureKey& key, const EntryShape& shape) {
  if (auto found = find(key)) return std::move(*found);
  const auto folder = options_.folder / key.digest;
  make_room(shape.bytes(), folder);
  auto lock = lock_in(folder);
  sweep_abandoned(folder);
  const nlohmann::json entry{{"frames", static_cast<unsigned>(shape.frames)},
                             {"picture_bytes", shape.picture_bytes},
                             {"key", nlohmann::json::parse(key.text)}};
  const std::string text = entry.dump(1) + "\n";
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  write_whole(folder / "entry.json", {&bytes, 1});
  return CacheEntry(folder, std::move(lock), shape);
}

std::uint64_t FrameCache::bytes() const {
  std::uint64_t total = 0;
  for (const auto& entry : kept_entries(options_.folder)) total += entry.bytes;
  return total;
}

void FrameCache::make_room(std::uint64_t bytes, const fs::path& except) {
  constexpr double kMegabyte = 1e6;
  const auto megabytes = [](std::uint64_t count) { return static_cast<double>(count) / kMegabyte; };
  if (bytes > options_.most_bytes)
    throw InvalidInput(
        fmt::format("the act's pictures take {:.0f} MB, the frame cache may hold {:.0f} MB; allow more "
                    "with --cache-size, or render with --no-cache",
                    megabytes(bytes), megabytes(options_.most_bytes)));
  auto entries = kept_entries(options_.folder);
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.used < b.used; });
  std::uint64_t kept = 0;
  for (const auto& entry : entries) kept += entry.bytes;
  const auto is_full = [&] {
    return kept + bytes > options_.most_bytes || fs::space(options_.folder).available < bytes + kSpareBytes;
  };
  for (const auto& entry : entries) {
    if (!is_full()) return;
    if (entry.folder == except || !remove_unused(entry.folder)) continue;
    kept -= entry.bytes;
    spdlog::info("frame cache: {} made room ({:.0f} MB, unused for longest)", entry.folder.string(),
                 megabytes(entry.bytes));
  }
  if (fs::space(options_.folder).available < bytes + kSpareBytes)
    throw std::system_error(ENOSPC, std::generic_category(),
                            fmt::format("{}: the act's pictures take {:.0f} MB; name another folder with --cache, or "
                                        "render with --no-cache",
                                        options_.folder.string(), megabytes(bytes)));
}

}  // namespace rotunda::simulator
