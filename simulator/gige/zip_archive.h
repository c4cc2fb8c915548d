#pragma once
// One file as a ZIP archive in memory: cameras keep their GenICam description so (GigE Vision 2.x, "Local:NAME.zip"),
// since clients fetch it 512 bytes at a time. The same bytes for the same text, whatever the time.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace rotunda::simulator {

// Throws std::runtime_error if libzip does not play along.
std::vector<std::uint8_t> zip_archive(const std::string& file_name, std::string_view text);

}  // namespace rotunda::simulator
