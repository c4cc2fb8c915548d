#include "simulator/gige/zip_archive.h"

#include <zip.h>

#include <memory>
#include <stdexcept>

namespace rotunda::simulator {
namespace {

struct FreeSource {
  void operator()(zip_source_t* source) const noexcept { zip_source_free(source); }
};
using Source = std::unique_ptr<zip_source_t, FreeSource>;

struct Discard {
  void operator()(zip_t* archive) const noexcept { zip_discard(archive); }
};

[[noreturn]] void fail(const std::string& doing) {
  throw std::runtime_error("packing a camera's description: " + doing);
}

// Writes the archive into `memory`.
void write(zip_source_t* memory, const std::string& file_name, std::string_view text) {
  constexpr zip_uint16_t kMidnight = 0, kFirstDay = 1 << 5 | 1;  // 1980-01-01, as MS-DOS counts
  std::unique_ptr<zip_t, Discard> archive(zip_open_from_source(memory, ZIP_TRUNCATE, nullptr));
  if (!archive) fail("zip_open_from_source");
  zip_source_keep(memory);  // the archive takes one reference, the caller has the other
  Source file(zip_source_buffer(archive.get(), text.data(), text.size(), 0));
  const auto index = file ? zip_file_add(archive.get(), file_name.c_str(), file.get(), 0) : -1;
  if (index < 0) fail(zip_strerror(archive.get()));
  file.release();  // the archive's now
  const auto place = static_cast<zip_uint64_t>(index);
  if (zip_file_set_dostime(archive.get(), place, kMidnight, kFirstDay, 0) != 0 ||
      zip_set_file_compression(archive.get(), place, ZIP_CM_DEFLATE, 9) != 0 || zip_close(archive.get()) != 0)
    fail(zip_strerror(archive.get()));
  archive.release();  // closed
}

std::vector<std::uint8_t> read(zip_source_t* memory) {
  zip_stat_t about{};
  if (zip_source_stat(memory, &about) != 0 || zip_source_open(memory) != 0) fail("zip_source_open");
  std::vector<std::uint8_t> bytes(about.size);
  const auto got = zip_source_read(memory, bytes.data(), bytes.size());
  zip_source_close(memory);
  if (got != static_cast<zip_int64_t>(bytes.size())) fail("zip_source_read");
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> zip_archive(const std::string& file_name, std::string_view text) {
  const Source memory(zip_source_buffer_create(nullptr, 0, 0, nullptr));
  if (!memory) fail("zip_source_buffer_create");
  write(memory.get(), file_name, text);
  return read(memory.get());
}

}  // namespace rotunda::simulator
