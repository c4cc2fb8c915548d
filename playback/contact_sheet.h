#pragma once
// One picture that tells at a glance what a take holds: camera pictures, and once it is reconstructed their mattes,
// the surface in grey, the geometry image as colours, and views from where no camera stands.
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace rotunda::capture {
class TakeReader;
}
namespace rotunda::recon {
class GeometryVideoReader;
}

namespace rotunda::playback {

struct ContactSheetOptions {
  std::size_t frame = 0;  // of the take, counted from 0
  int cameras = 5;        // pictures in a row
  int tile_width = 288;   // pixels
  int tile_height = 230;
};

// CV_8UC3, RGB. Draws headless: no other GL context may be current on this thread. Throws what reading the take does.
cv::Mat contact_sheet(const std::filesystem::path& take, const ContactSheetOptions& options = {});

// A geometry video's frames side by side, as the paper's figure 2 lays them out: above, positions as red, green, blue;
// below, colours, and the surface drawn. `frames`: so many, spread evenly from the first to the last. Else as above.
cv::Mat clip_sheet(recon::GeometryVideoReader& video, int frames = 6, const ContactSheetOptions& options = {});

// Tiles of any size in rows, each scaled to fit, with a caption below each row's first line of pixels.
struct CaptionedPicture {
  cv::Mat picture;  // CV_8UC1, CV_8UC3 (RGB) or CV_8UC4 (RGBA, on dark grey)
  std::string caption;
};
// Of cameras spread over the rig: their pictures, their mattes.
std::vector<CaptionedPicture> camera_row(const capture::TakeReader& take, const ContactSheetOptions& options);
std::vector<CaptionedPicture> matte_row(const capture::TakeReader& take, const ContactSheetOptions& options);
cv::Mat tile(const std::vector<std::vector<CaptionedPicture>>& rows, const ContactSheetOptions& options);

}  // namespace rotunda::playback
