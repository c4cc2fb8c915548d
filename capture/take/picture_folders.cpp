#include "capture/take/picture_folders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <system_error>

#include "capture/picture.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

bool is_picture(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    if (entry.is_regular_file() && is_picture(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

// Folders with pictures in them that are no camera's: a slip of the pen in a camera's name shows here.
void find_strangers(const fs::path& folder, std::span<const CameraModel> cameras, Problems& problems) {
  std::set<std::string> strangers;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && !pictures_in(entry.path()).empty()) strangers.insert(entry.path().filename().string());
  for (const auto& camera : cameras) strangers.erase(camera.name);
  for (const auto& name : strangers)
    problems.push_back(fmt::format("{}: has pictures in {}, but is not in the calibration", name, folder.string()));
}

void compare_counts(const fs::path& folder, std::span<const CameraModel> cameras,
                    const std::vector<std::vector<fs::path>>& files, Problems& problems) {
  std::size_t most = 0;
  for (const auto& list : files) most = std::max(most, list.size());
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (!files[i].empty() && files[i].size() < most)
      problems.push_back(fmt::format("{}: {} pictures in {}, other cameras have {}", cameras[i].name, files[i].size(),
                                     (folder / cameras[i].name).string(), most));
}

cv::Mat fitting(cv::Mat (*read)(const fs::path&), const fs::path& file, const CameraModel& camera, Problems& problems) {
  try {
    cv::Mat picture = read(file);
    if (picture.cols == camera.width && picture.rows == camera.height) return picture;
    problems.push_back(fmt::format("{}: {} is {} x {}, the calibration is for {} x {}", camera.name, file.string(),
                                   picture.cols, picture.rows, camera.width, camera.height));
  } catch (const CorruptData& error) {
    problems.push_back(camera.name + ": " + error.what());
  }
  return {};
}

}  // namespace

std::vector<std::vector<fs::path>> list_pictures(const fs::path& folder, std::span<const CameraModel> cameras,
                                                 Problems& problems) {
  std::vector<std::vector<fs::path>> files(cameras.size());
  if (!fs::is_directory(folder)) {
    problems.push_back(folder.string() + " is not a folder");
    return files;
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    files[i] = pictures_in(folder / cameras[i].name);
    if (files[i].empty())
      problems.push_back(fmt::format("{}: is in the calibration, but {} holds no PNG or JPEG pictures", cameras[i].name,
                                     (folder / cameras[i].name).string()));
  }
  find_strangers(folder, cameras, problems);
  compare_counts(folder, cameras, files, problems);
  return files;
}

std::vector<fs::path> list_backgrounds(const fs::path& folder, std::span<const CameraModel> cameras,
                                       Problems& problems) {
  const auto pictures = pictures_in(folder);
  std::vector<fs::path> files;
  for (const auto& camera : cameras) {
    const auto file =
        std::find_if(pictures.begin(), pictures.end(), [&](const auto& path) { return path.stem() == camera.name; });
    files.push_back(file == pictures.end() ? fs::path() : *file);
    if (file == pictures.end())
      problems.push_back(
          fmt::format("{}: has no background; {} is missing", camera.name, (folder / (camera.name + ".png")).string()));
  }
  return files;
}

cv::Mat read_fitting_rgb(const fs::path& file, const CameraModel& camera, Problems& problems) {
  return fitting(&read_rgb, file, camera, problems);
}

cv::Mat read_fitting_matte(const fs::path& file, const CameraModel& camera, Problems& problems) {
  return fitting(&read_matte, file, camera, problems);
}

}  // namespace rotunda::capture
