#pragma once
// How far points lie from a body, sampled on a lattice: for who asks millions of times. Trilinear between the samples.
// Metres, bind pose, person frame.
#include <Eigen/Geometry>
#include <functional>
#include <vector>

namespace rotunda::simulator {

class BodyField {
 public:
  BodyField() = default;
  // `distance`: thread-safe, negative inside.
  BodyField(const Eigen::AlignedBox3d& box, double cell,
            const std::function<double(const Eigen::Vector3d& point)>& distance);

  struct Sample {
    double distance;
    Eigen::Vector3d gradient;
  };
  // Outside the box: far from the body.
  Sample at(const Eigen::Vector3d& point) const;
  // The nearest point, to first order, that is at least `off` outside the body.
  Eigen::Vector3d pushed_out(Eigen::Vector3d point, double off) const;

 private:
  double value_at(const Eigen::Array3i& i) const {
    return static_cast<double>(values_[static_cast<std::size_t>((i.z() * count_.y() + i.y()) * count_.x() + i.x())]);
  }

  Eigen::Vector3d low_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i count_ = Eigen::Vector3i::Zero();
  double cell_ = 1.0;
  std::vector<float> values_;
};

}  // namespace rotunda::simulator
