#include "recon/video/geometry_picture.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>

namespace rotunda::recon {
namespace {

// Vectors as colours: `low` becomes black, `low + extent` white.
cv::Mat vector_picture(const std::vector<Eigen::Vector3f>& vectors, int side, const Eigen::Vector3f& low,
                       const Eigen::Vector3f& extent) {
  cv::Mat picture(side, side, CV_8UC3);
  auto* pixel = picture.ptr<cv::Vec3b>();
  for (const Eigen::Vector3f& vector : vectors) {
    for (int axis = 0; axis < 3; ++axis)
      (*pixel)[axis] = cv::saturate_cast<std::uint8_t>(255.0F * (vector[axis] - low[axis]) / extent[axis]);
    ++pixel;
  }
  return picture;
}

}  // namespace

cv::Mat position_picture(const GeometryImage& image) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& position : image.positions) box.extend(position);
  const Eigen::Vector3f extent = box.sizes().cwiseMax(1e-6F);  // a flat surface is black along its thickness
  return vector_picture(image.positions, image.side(), box.min(), extent);
}

cv::Mat normal_picture(const GeometryImage& image) {
  return vector_picture(image.normals, image.side(), Eigen::Vector3f::Constant(-1.0F), Eigen::Vector3f::Constant(2.0F));
}

cv::Mat colour_picture(const GeometryImage& image) {
  cv::Mat picture(image.colour_side(), image.colour_side(), CV_8UC3);
  std::memcpy(picture.data, image.colours.data(), picture.total() * 3);
  return picture;
}

}  // namespace rotunda::recon
