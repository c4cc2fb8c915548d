#include "recon/mesh/picture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <system_error>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr int kLargestPicture = 16384;

std::string sniffed(const Bytes& bytes) {
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 16));
  if (head.substr(0, 4) == "\xABKTX") return "KTX";
  if (head.substr(0, 4) == "DDS ") return "DDS";
  if (head.size() > 12 && head.substr(8, 4) == "WEBP") return "WebP";
  return head.starts_with("\x89PNG") || head.starts_with("\xFF\xD8\xFF") ? "" : "unknown format";
}

// A PNG says its size at the front: a small file may hold an absurd one.
bool is_absurd_png(const Bytes& bytes) {
  if (bytes.size() < 24 || bytes[0] != 0x89) return false;
  const auto side = [&](std::size_t at) {
    return (std::uint32_t{bytes[at]} << 24) | (std::uint32_t{bytes[at + 1]} << 16) |
           (std::uint32_t{bytes[at + 2]} << 8) | bytes[at + 3];
  };
  return side(16) > kLargestPicture || side(20) > kLargestPicture;
}

}  // namespace

Bytes read_whole(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    throw std::system_error(ENOENT, std::generic_category(), path.string() + ": cannot be opened");
  if (!std::filesystem::is_regular_file(path, error)) throw InvalidInput(path.string() + ": is no file");
  const auto size = std::filesystem::file_size(path);
  if (size > kLargestInput) throw InvalidInput(fmt::format("{}: {} bytes; at most 1 GiB is read", path.string(), size));
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  Bytes bytes(size);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), path.string() + ": cannot be read");
  return bytes;
}

cv::Mat decode_picture(const std::filesystem::path& path, const std::string& what, const Bytes& bytes) {
  if (const auto format = sniffed(bytes); !format.empty())
    throw InvalidInput(fmt::format("{}: {}: {}; PNG and JPEG are read", path.string(), what, format));
  if (is_absurd_png(bytes))
    throw InvalidInput(fmt::format("{}: {}: wider or higher than {}", path.string(), what, kLargestPicture));
  cv::Mat found, rgba;
  try {
    found = cv::imdecode(bytes, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    found.release();
  }
  if (found.empty()) throw CorruptData(path.string() + ": " + what + ": its picture cannot be decoded");
  if (found.depth() == CV_16U) found.convertTo(found, CV_8U, 1.0 / 257.0);
  constexpr std::array<int, 5> to_rgba = {-1, cv::COLOR_GRAY2RGBA, -1, cv::COLOR_BGR2RGBA, cv::COLOR_BGRA2RGBA};
  const int code = found.channels() <= 4 ? to_rgba[static_cast<std::size_t>(found.channels())] : -1;
  if (found.depth() != CV_8U || code < 0)
    throw InvalidInput(fmt::format("{}: {}: an unusual picture", path.string(), what));
  cv::cvtColor(found, rgba, code);
  return rgba;
}

}  // namespace rotunda::recon
