#include "capture/source/user_name.h"

#include "capture/source/gvcp_memory.h"

namespace rotunda::capture {

std::string read_user_name(const std::string& address) {
  constexpr std::uint32_t kPlace = 0xE8;
  constexpr std::uint16_t kBytes = 16;
  return text_in(read_gvcp_memory(address, kPlace, kBytes).value_or(""));
}

}  // namespace rotunda::capture
