#pragma once
// Which camera is which: a contact sheet with a picture of each, its name, serial number and address.
#include <filesystem>
#include <opencv2/core.hpp>
#include <stop_token>
#include <vector>

#include "rig/client.h"

namespace rotunda::rig {

struct CameraPortrait {
  IdentifiedCamera camera;
  cv::Mat picture;  // RGB (CV_8UC3); empty: none came
};

// What a portrait's picture is made of: as wide as its place on the sheet, or smaller.
cv::Mat portrait_picture(const cv::Mat& rgb);

// Writes the sheet in one step, over one of the same name, and tells what is on it. Throws InvalidInput if it does not
// end in .png, std::system_error.
std::vector<IdentifiedCamera> write_contact_sheet(const std::filesystem::path& file,
                                                  const std::vector<CameraPortrait>& portraits);

// Opens every camera that answers, one after the other, for one picture; blinks its light meanwhile if it has one.
// `name`: only the camera with this user name, serial number or address (InvalidInput if none has). A camera that
// gives no picture has a problem instead.
std::vector<CameraPortrait> portraits_by_opening(const std::string& name, bool blink, std::stop_token stop);

}  // namespace rotunda::rig
