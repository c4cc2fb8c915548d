#pragma once
// The features of a camera that Aravis has open.
#include "capture/frame.h"
#include "capture/source/aravis_handle.h"
#include "capture/source/feature_access.h"

namespace rotunda::capture {

class AravisFeatures final : public FeatureAccess {
 public:
  AravisFeatures(ArvCamera* camera, CameraId name) : device_(arv_camera_get_device(camera)), name_(std::move(name)) {}

  bool has(const std::string& name) override;
  std::string read(const std::string& name) override;
  void write(const std::string& name, const std::string& value) override;
  void execute(const std::string& name) override;

  // Whether the last call failed because the camera did not answer.
  bool is_gone() const { return gone_; }

 private:
  ArvGcNode* node(const std::string& name);  // throws if there is none
  void check(const ErrorCatcher& error, const std::string& doing);

  ArvDevice* device_;  // the camera's
  CameraId name_;
  bool gone_ = false;
};

}  // namespace rotunda::capture
