#pragma once
// Settings of a GenICam camera beyond picture and exposure: the user set to start from, white balance, and any feature
// by its own name. Each is read back; what the camera made of it is told. Names as in GenICam SFNC 2.7.
#include <string>
#include <vector>

#include "capture/frame.h"
#include "capture/source/feature_access.h"
#include "capture/source/source.h"

namespace rotunda::capture {

// What a camera has where something else was asked.
struct SettingDifference {
  std::string feature, asked, got;
};
std::string to_string(const SettingDifference& difference);  // "Gain: asked 3, the camera has 2.9"

// Whether a camera that answers `got` has what was asked: numbers to a thousandth, true is 1.
bool is_same_setting(const std::string& asked, const std::string& got);

// Each throws DeviceError naming camera, feature and cure when the camera has no such feature or refuses the value.
void load_user_set(FeatureAccess& camera, const CameraId& name, const std::string& user_set);
std::vector<SettingDifference> set_white_balance(FeatureAccess& camera, const CameraId& name,
                                                 const WhiteBalance& balance);
// In the order given: one feature may open another.
std::vector<SettingDifference> set_features(FeatureAccess& camera, const CameraId& name,
                                            const std::vector<CameraControl>& features);

}  // namespace rotunda::capture
