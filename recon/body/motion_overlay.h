#pragma once
// The template over what the cameras saw: its rim and its bones drawn into every view, the views side by side.
#include <opencv2/core.hpp>
#include <span>

#include "capture/camera_model.h"
#include "recon/body/captured_motion.h"

namespace rotunda::recon {

// CV_8UC3, RGB, half size, in a grid about as wide as high; a view without a picture stays dark. Rim: yellow, red where
// the frame was lost; left limbs' bones blue, right ones' orange. Sides are even, as films ask.
cv::Mat overlay_picture(std::span<const capture::CameraModel> cameras, std::span<const cv::Mat> rgb,
                        const BodyTemplate& body, const TrackedPose& tracked);

}  // namespace rotunda::recon
