#pragma once
// What an archived take is made of, as sha256sum(1) writes and checks it. archive/recorded.sha256 has the files as they
// were recorded; archive/SHA256SUMS those of the archive itself, is written last, and makes a folder an archive.
#include <filesystem>
#include <map>
#include <string>

#include "capture/take/take.h"

namespace rotunda::capture {

// By path in the take ("cam00.mkv", "background/cam00.png"), its SHA-256 in hexadecimal.
using FileSums = std::map<std::string, std::string>;

bool is_archive(const std::filesystem::path& folder);
std::filesystem::path recorded_sums(const std::filesystem::path& folder);
std::filesystem::path archive_sums(const std::filesystem::path& folder);

// Reading throws CorruptData (empty, a line that is none, a path that leaves the take) or std::system_error; writing
// replaces the file in one step and throws std::system_error.
FileSums read_sums(const std::filesystem::path& file);
void write_sums(const std::filesystem::path& file, const FileSums& sums);

// Where archive/<camera>.rest lies (camera_file_rest.h).
std::filesystem::path rest_file(const std::filesystem::path& folder, const CameraId& camera);

}  // namespace rotunda::capture
