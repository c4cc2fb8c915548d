#pragma once
// Videos of boards, DIR/<camera>.mp4 (or .mkv, .avi, .mov, .webm, .m4v, .mpg, .ts): frame n of each is one moment, so
// they begin together and run at one rate. Of each stretch of half a second the frame in which least moves is kept as a
// picture (longer stretches in long videos), if it is nearly as still as the video's stillest; none where it shows
// nothing that the one kept before did not.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace rotunda::capture {

// Files in the order of their names; none where the folder holds no videos. Throws InvalidInput where two differ in
// their endings only.
std::vector<std::filesystem::path> videos_in(const std::filesystem::path& folder);

struct BoardStills {
  std::vector<std::size_t> frames;    // kept, in the order of time
  std::vector<std::string> troubles;  // videos that end early or are damaged, a sentence each with the file's name
};

// Writes OUT/<camera>/frame000123.png of every kept frame and camera. Throws CorruptData for a file that is no video,
// InvalidInput where their rates differ, std::system_error if a picture cannot be written.
BoardStills write_board_stills(const std::vector<std::filesystem::path>& videos, const std::filesystem::path& out,
                               const std::function<void(std::size_t done, std::size_t total)>& progress = {});

}  // namespace rotunda::capture
