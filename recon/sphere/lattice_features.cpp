#include "recon/sphere/lattice_features.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "recon/sphere/octahedral_lattice.h"

namespace rotunda::recon {

std::vector<Feature> lattice_features(const GeometryImage& image, int level, const Eigen::Vector3f& middle,
                                      const MatchingOptions& options) {
  const auto side = static_cast<std::size_t>(lattice_side(level));
  const auto stride = (static_cast<std::size_t>(image.side()) - 1) / (side - 1),
             colour_stride = (static_cast<std::size_t>(image.colour_side()) - 1) / (side - 1);
  std::vector<Feature> features;
  for (const auto sample : weld_lattice(level).sample_of_vertex) {
    const auto x = sample % side, y = sample / side;
    const auto at = y * stride * static_cast<std::size_t>(image.side()) + x * stride;
    const auto& colour =
        image.colours[y * colour_stride * static_cast<std::size_t>(image.colour_side()) + x * colour_stride];
    auto& feature = features.emplace_back(Feature::Zero());
    feature.segment<3>(0) = ((image.positions[at] - middle) / static_cast<float>(options.position_sigma)).array();
    feature.segment<3>(3) = (image.normals[at] / static_cast<float>(options.normal_sigma)).array();
    for (Eigen::Index c = 0; c < 3; ++c)
      feature[6 + c] =
          static_cast<float>(colour[static_cast<std::size_t>(c)]) / static_cast<float>(options.colour_sigma);
  }
  return features;
}

double edge_length(int level) {
  const auto directions = lattice_directions(level);
  double sum = 0.0;
  std::size_t count = 0;
  for (const auto& t : lattice_triangles(level))
    for (std::size_t i = 0; i < 3; ++i, ++count) sum += (directions[t[i]] - directions[t[(i + 1) % 3]]).norm();
  return sum / static_cast<double>(count);
}

Eigen::Vector3f middle_of(const GeometryImage& image) {
  constexpr int kCoarse = 5;  // a middle needs no more
  const int level = std::min(kCoarse, image.level);
  const auto side = static_cast<std::size_t>(lattice_side(level)),
             stride = (static_cast<std::size_t>(image.side()) - 1) / (side - 1);
  const auto at = [&](std::uint32_t sample) {
    return image.positions[sample / side * stride * static_cast<std::size_t>(image.side()) + sample % side * stride]
        .cast<double>();
  };
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 1e-12;
  for (const auto& t : lattice_triangles(level)) {
    const Eigen::Vector3d a = at(t[0]), b = at(t[1]), c = at(t[2]);
    const double part = (b - a).cross(c - a).norm();
    sum += part * (a + b + c) / 3.0;
    area += part;
  }
  return (sum / area).cast<float>();
}

}  // namespace rotunda::recon
