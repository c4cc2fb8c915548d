#pragma once
// Replacing a small file in one step: temporary file beside it, fsync, rename, fsync of the folder. After a crash or
// a power cut the old text or the new one is there, never a part. Throws std::system_error naming the file.
#include <filesystem>
#include <string_view>

namespace rotunda::capture {

void replace_file(const std::filesystem::path& file, std::string_view text);
void sync_folder(const std::filesystem::path& folder);
// Everything written so far to the file system that holds `folder`.
void sync_filesystem(const std::filesystem::path& folder);

}  // namespace rotunda::capture
