#pragma once
// Pictures that come with a scan or a character: PNG and JPEG, told by their first bytes.
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace rotunda::recon {

using Bytes = std::vector<unsigned char>;
constexpr std::uintmax_t kLargestInput = std::uintmax_t{1} << 30;  // bytes, of a file that is read whole

// Throws std::system_error if the file cannot be read, InvalidInput if it is none or larger than kLargestInput.
Bytes read_whole(const std::filesystem::path& path);

// CV_8UC4, sRGB, red first, straight alpha. Throws CorruptData if it cannot be decoded, InvalidInput for other formats
// and absurd sizes; both name `path` and `what` of it.
cv::Mat decode_picture(const std::filesystem::path& path, const std::string& what, const Bytes& bytes);

}  // namespace rotunda::recon
