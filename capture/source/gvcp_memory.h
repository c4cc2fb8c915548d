#pragma once
// A look into a GigE Vision device's memory (GVCP READMEM), which needs no control of it and no library.
#include <cstdint>
#include <optional>
#include <string>

namespace rotunda::capture {

// `bytes` (a multiple of 4, at most 512) from `place` on, of the device at an IPv4 address; nothing if it does not
// answer within 0.3 s, nor twice more, or answers something else.
std::optional<std::string> read_gvcp_memory(const std::string& address, std::uint32_t place, std::uint16_t bytes);

// Whether anything answers there, if only that it may not be read; waits as long for it.
bool answers_gvcp(const std::string& address);

// The text in `memory` up to its first zero.
std::string text_in(const std::string& memory);

}  // namespace rotunda::capture
