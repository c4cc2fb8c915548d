#include "simulator/people/body_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace rotunda::simulator {

using Eigen::Vector3d;

BodyField::BodyField(const Eigen::AlignedBox3d& box, double cell,
                     const std::function<double(const Vector3d& point)>& distance)
    : low_(box.min()), count_((box.sizes() / cell).array().ceil().cast<int>() + 1), cell_(cell) {
  values_.resize(static_cast<std::size_t>(count_.prod()));
  tbb::parallel_for(0, count_.z(), [&](int z) {
    auto* row = values_.data() + static_cast<std::ptrdiff_t>(z) * count_.y() * count_.x();
    for (int y = 0; y < count_.y(); ++y)
      for (int x = 0; x < count_.x(); ++x) *row++ = static_cast<float>(distance(low_ + cell_ * Vector3d(x, y, z)));
  });
}

BodyField::Sample BodyField::at(const Vector3d& point) const {
  const Eigen::Array3d place = (point - low_).array() / cell_;
  if (values_.empty() || !(place >= 0.0).all() ||
      !(place < (count_ - Eigen::Vector3i::Ones()).cast<double>().array()).all())
    return {1.0, Vector3d::UnitZ()};
  const Eigen::Array3i cell = place.cast<int>();
  const Eigen::Array3d t = place - cell.cast<double>();
  Sample sample{0.0, Vector3d::Zero()};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3i far(corner & 1, corner >> 1 & 1, corner >> 2);
    const Eigen::Array3d is_far = far.cast<double>(), share = is_far * t + (1.0 - is_far) * (1.0 - t);
    const double value = value_at(cell + far);
    sample.distance += share.prod() * value;
    for (int axis = 0; axis < 3; ++axis)
      sample.gradient[axis] +=
          (2.0 * is_far[axis] - 1.0) * share[(axis + 1) % 3] * share[(axis + 2) % 3] * value / cell_;
  }
  return sample;
}

Vector3d BodyField::pushed_out(Vector3d point, double off) const {
  constexpr int kRounds = 3;
  constexpr double kLeastSlope = 0.3;  // in the middle of the body no way out is steeper than another
  for (int round = 0; round < kRounds; ++round) {
    const Sample here = at(point);
    if (here.distance >= off) break;
    point += (off - here.distance) * here.gradient / std::max(here.gradient.squaredNorm(), kLeastSlope);
  }
  return point;
}

}  // namespace rotunda::simulator
