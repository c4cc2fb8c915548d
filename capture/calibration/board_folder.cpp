#include "capture/calibration/board_folder.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <span>

#include "capture/ycbcr_picture.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostKept = 512U << 20U;  // bytes

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_picture(const fs::path& file) {
  const auto extension = lower_extension(file);
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

// Numbers by their value: frame2 comes before frame10.
struct ByNumber {
  bool operator()(const std::string& a, const std::string& b) const {
    std::size_t i = 0, j = 0;
    const auto digit = [](const std::string& s, std::size_t at) {
      return at < s.size() && std::isdigit(static_cast<unsigned char>(s[at])) != 0;
    };
    const auto number = [&](const std::string& s, std::size_t& at) {
      while (at + 1 < s.size() && s[at] == '0' && digit(s, at + 1)) ++at;
      const std::size_t begin = at;
      while (digit(s, at)) ++at;
      return s.substr(begin, at - begin);
    };
    while (i < a.size() && j < b.size()) {
      if (digit(a, i) && digit(b, j)) {
        const auto x = number(a, i), y = number(b, j);
        if (x.size() != y.size()) return x.size() < y.size();
        if (x != y) return x < y;
      } else if (a[i] != b[j]) {
        return a[i] < b[j];
      } else {
        ++i, ++j;
      }
    }
    return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
  }
};

using Files = std::map<std::string, std::map<std::string, fs::path, ByNumber>>;  // camera, moment

Files list_files(const fs::path& folder, std::vector<std::string>& skipped) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw InvalidInput(folder.string() + " is no folder; expected DIR/<camera>/*.png or *.jpg");
  Files files;
  for (const auto& camera : fs::directory_iterator(folder)) {
    if (!camera.is_directory()) continue;
    const auto name = camera.path().filename().string();
    for (const auto& entry : fs::directory_iterator(camera.path()))
      if (entry.is_regular_file() && is_picture(entry.path()))
        files[name].insert_or_assign(entry.path().stem().string(), entry.path());
    if (!files.contains(name)) skipped.push_back(camera.path().string() + " holds no pictures: left out");
  }
  std::sort(skipped.begin(), skipped.end());
  if (files.empty()) throw InvalidInput(folder.string() + " holds no pictures; expected DIR/<camera>/*.png or *.jpg");
  return files;
}

bool ends_early(const std::vector<char>& bytes, const fs::path& file) {
  if (lower_extension(file) == ".png") {
    constexpr std::string_view kEnd = "IEND";
    return std::search(bytes.end() - std::min<std::ptrdiff_t>(64, std::ssize(bytes)), bytes.end(), kEnd.begin(),
                       kEnd.end()) == bytes.end();
  }
  constexpr std::array kEnd = {'\xff', '\xd9'};
  return std::search(bytes.begin(), bytes.end(), kEnd.begin(), kEnd.end()) == bytes.end();
}

// OpenCV fills in what of a damaged JPEG it cannot read, and says so to nobody.
void refuse_damaged_jpeg(std::span<const char> bytes, const cv::Mat& picture, const fs::path& file) {
  constexpr std::array kEnd = {'\xff', '\xd9'};
  const auto end = std::find_end(bytes.begin(), bytes.end(), kEnd.begin(), kEnd.end());  // some programs add to it
  const std::vector<std::uint8_t> jpeg(bytes.begin(), end + kEnd.size());
  try {
    jpeg_to_rgb(make_image(picture.cols, picture.rows, PixelFormat::mjpeg, jpeg));
  } catch (const CorruptData& error) {
    throw CorruptData(file, 0, error.what());
  }
}

using Pictures = std::vector<std::vector<cv::Mat>>;

// Forgets files that cannot be read, and says why, in the order of the table.
std::shared_ptr<const Pictures> keep_readable(std::vector<std::vector<fs::path>>& table,
                                              std::vector<std::string>& skipped) {
  auto kept = std::make_shared<Pictures>(table.size(), std::vector<cv::Mat>(table.front().size()));
  const std::size_t moments = table.front().size();
  std::vector<std::string> troubles(table.size() * moments);
  std::atomic<std::size_t> bytes = 0;
  tbb::parallel_for(std::size_t{0}, troubles.size(), [&](std::size_t i) {
    auto& file = table[i / moments][i % moments];
    if (file.empty()) return;
    try {
      cv::Mat picture = read_board_picture(file);
      const std::size_t size = picture.total() * picture.elemSize();
      if (bytes.fetch_add(size) + size <= kMostKept) (*kept)[i / moments][i % moments] = std::move(picture);
    } catch (const CorruptData& error) {
      troubles[i] = std::string(error.what()) + ": left out";
      file.clear();
    }
  });
  std::copy_if(troubles.begin(), troubles.end(), std::back_inserter(skipped), [](const auto& t) { return !t.empty(); });
  return kept;
}

}  // namespace

cv::Mat read_board_picture(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
  if (bytes.empty()) throw CorruptData(file, 0, "is empty or cannot be read");
  if (ends_early(bytes, file)) throw CorruptData(file, bytes.size(), "is cut short");
  cv::Mat picture;
  try {
    picture = cv::imdecode(bytes, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    throw CorruptData(file, 0, "is no picture: " + error.err);
  }
  if (picture.empty()) throw CorruptData(file, 0, "is no picture");
  if (picture.depth() != CV_8U && picture.depth() != CV_16U) throw CorruptData(file, 0, "has neither 8 nor 16 bits");
  if (lower_extension(file) != ".png") refuse_damaged_jpeg(bytes, picture, file);
  if (picture.channels() > 1) cv::extractChannel(picture, picture, 1);
  return picture;
}

BoardFolder read_board_folder(const fs::path& folder) {
  BoardFolder result;
  const auto files = list_files(folder, result.skipped);
  std::set<std::string, ByNumber> moments;
  for (const auto& [camera, by_moment] : files) {
    result.pictures.cameras.push_back(camera);
    for (const auto& [moment, file] : by_moment) moments.insert(moment);
  }
  result.pictures.moments.assign(moments.begin(), moments.end());
  auto table = std::make_shared<std::vector<std::vector<fs::path>>>();
  for (const auto& [camera, by_moment] : files) {
    auto& row = table->emplace_back();
    for (const auto& moment : moments) {
      const auto file = by_moment.find(moment);
      row.push_back(file == by_moment.end() ? fs::path{} : file->second);
    }
  }
  const auto kept = keep_readable(*table, result.skipped);
  result.pictures.file = [table](std::size_t camera, std::size_t moment) { return (*table)[camera][moment]; };
  result.pictures.grey = [table, kept](std::size_t camera, std::size_t moment) {
    const auto& file = (*table)[camera][moment];
    const auto& picture = (*kept)[camera][moment];
    return file.empty() || !picture.empty() ? picture : read_board_picture(file);
  };
  return result;
}

}  // namespace rotunda::capture
