#pragma once
// Pictures of boards from a folder, DIR/<camera>/*.png|jpg|jpeg: files of one name (without its ending) are one moment,
// moments in the order of their names, numbers counted. A camera may miss moments.
#include <filesystem>

#include "capture/calibration/calibrate.h"

namespace rotunda::capture {

struct BoardFolder {
  BoardPictures pictures;
  std::vector<std::string> skipped;  // what cannot be read, a sentence each with the file's name
};

// Reads every file once; as many pictures as 512 MiB hold are kept, the others read again when they are asked for.
// Throws InvalidInput if there is no folder or no picture in it.
BoardFolder read_board_folder(const std::filesystem::path& folder);

// The picture as boards are looked for: of colour its green, which lenses and mosaics show best; 16 bits stay. Throws
// CorruptData for what is damaged, cut short or empty.
cv::Mat read_board_picture(const std::filesystem::path& file);

}  // namespace rotunda::capture
