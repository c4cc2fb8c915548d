#include "recon/whole_file.h"

#include <cerrno>
#include <fstream>
#include <iterator>

namespace rotunda::recon {

void write_text(const std::filesystem::path& file, const std::string& text) {
  write_whole(file, [&](const std::filesystem::path& part) {
    errno = 0;
    std::ofstream out(part, std::ios::binary);
    out << text << std::flush;
    if (!out) throw std::system_error(errno ? errno : EIO, std::generic_category(), "writing " + file.string());
  });
}

std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace rotunda::recon
