#include "recon/body/motion_overlay.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "recon/body/template_rim.h"

namespace rotunda::recon {
namespace {

const cv::Scalar kFound(255, 220, 40), kLost(255, 50, 50), kMiddle(240, 240, 240), kLeft(70, 150, 255),
    kRight(255, 140, 40);

cv::Point halved(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround(0.5 * pixel.x())), static_cast<int>(std::lround(0.5 * pixel.y()))};
}

cv::Scalar colour_of(BodyJoint joint) {
  if (mirrored(joint) == joint) return kMiddle;
  return mirrored(joint) > joint ? kLeft : kRight;
}

void draw_bones(cv::Mat& picture, const capture::CameraModel& camera, const BodyTemplate& body, const Pose& pose) {
  const auto at = joint_positions(body.skeleton, pose);
  for (std::size_t j = 1; j < kBodyJoints; ++j) {
    const auto from = capture::project(camera, at[index(*parent_of(body_joint(j)))]),
               to = capture::project(camera, at[j]);
    if (from && to) cv::line(picture, halved(*from), halved(*to), colour_of(body_joint(j)), 1, cv::LINE_AA);
  }
}

void draw_view(cv::Mat& picture, const capture::CameraModel& camera, const BodyTemplate& body,
               const TrackedPose& tracked) {
  const auto vertices = posed_vertices(body, joint_transforms(body.skeleton, tracked.fit.pose));
  const auto& colour = tracked.state == TrackState::lost ? kLost : kFound;
  for (const auto& point : template_rim(vertices, camera, 2.0)) {
    const auto at = halved(point.pixel);
    if (cv::Rect({}, picture.size()).contains(at))
      picture.at<cv::Vec3b>(at) = cv::Vec3b(cv::saturate_cast<uchar>(colour[0]), cv::saturate_cast<uchar>(colour[1]),
                                            cv::saturate_cast<uchar>(colour[2]));
  }
  draw_bones(picture, camera, body, tracked.fit.pose);
}

}  // namespace

cv::Mat overlay_picture(std::span<const capture::CameraModel> cameras, std::span<const cv::Mat> rgb,
                        const BodyTemplate& body, const TrackedPose& tracked) {
  int width = 2, height = 2;
  for (const auto& camera : cameras) {
    width = std::max(width, camera.width / 2);
    height = std::max(height, camera.height / 2);
  }
  const int views = std::max(1, static_cast<int>(cameras.size()));
  const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(views)))),
            rows = (views + columns - 1) / columns;
  cv::Mat sheet((rows * height + 1) / 2 * 2, (columns * width + 1) / 2 * 2, CV_8UC3, cv::Scalar(24, 26, 30));
  for (int i = 0; i < static_cast<int>(cameras.size()); ++i) {
    const auto& picture = rgb[static_cast<std::size_t>(i)];
    const auto& camera = cameras[static_cast<std::size_t>(i)];
    cv::Mat place = sheet(cv::Rect((i % columns) * width, (i / columns) * height, camera.width / 2, camera.height / 2));
    if (!picture.empty()) cv::resize(picture, place, place.size(), 0, 0, cv::INTER_AREA);
    draw_view(place, camera, body, tracked);
  }
  return sheet;
}

}  // namespace rotunda::recon
