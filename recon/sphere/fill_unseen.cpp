// Multi-resolution blending of unseen texels: pull down the nested lattices, push back up (Burt, Adelson 1983;
// Gortler, Grzeszczuk, Szeliski, Cohen 1996, section 3.4).
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "config/errors.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/resample.h"

namespace rotunda::recon {
namespace {

// Colour times weight, and weight; raster order, equal on identified samples.
using Layer = std::vector<Eigen::Vector4f>;

// Applies f(x, y) to the canonical samples of a lattice and copies the results to the samples identified with them.
template <class SampleFunction>
Layer over_lattice(int level, const SampleFunction& f) {
  const int side = lattice_side(level);
  Layer layer(lattice_size(level));
  for (std::size_t i = 0; i < layer.size(); ++i) {
    const int x = static_cast<int>(i) % side, y = static_cast<int>(i) / side;
    const auto from = canonical_sample(level, x, y);
    layer[i] = from == i ? f(x, y) : layer[from];
  }
  return layer;
}

// Each coarse sample: the fine ones around it under a tent; its weight saturates at 1.
Layer pull(const Layer& fine, int coarse_level) {
  return over_lattice(coarse_level, [&](int x, int y) {
    Eigen::Vector4f sum = Eigen::Vector4f::Zero();
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const float tent = 1.0F / static_cast<float>((1 << std::abs(dx)) * (1 << std::abs(dy)));
        sum += tent * fine[continued_sample(coarse_level + 1, 2 * x + dx, 2 * y + dy)];
      }
    return Eigen::Vector4f(sum[3] > 1.0F ? sum / sum[3] : sum);
  });
}

// What a fine sample lacks in weight comes from the coarse samples beside it.
Layer push(const Layer& coarse, const Layer& fine, int fine_level) {
  const int side = lattice_side(fine_level), coarse_side = lattice_side(fine_level - 1);
  const auto at = [&](int x, int y) { return coarse[static_cast<std::size_t>(y * coarse_side + x)]; };
  return over_lattice(fine_level, [&](int x, int y) {
    const Eigen::Vector4f& own = fine[static_cast<std::size_t>(y * side + x)];
    const int x0 = x / 2, y0 = y / 2, x1 = (x + 1) / 2, y1 = (y + 1) / 2;
    const Eigen::Vector4f beside = 0.25F * (at(x0, y0) + at(x1, y0) + at(x0, y1) + at(x1, y1));
    return Eigen::Vector4f(own + std::max(0.0F, 1.0F - own[3]) * beside);
  });
}

// The coarsest layer, completed with the mean of what it has; grey if nothing was seen at all.
Layer completed(const Layer& layer) {
  Eigen::Vector4f mean = Eigen::Vector4f::Zero();
  for (const auto& sample : layer) mean += sample;
  mean = mean[3] > 0.0F ? Eigen::Vector4f(mean / mean[3]) : Eigen::Vector4f(128.0F, 128.0F, 128.0F, 1.0F);
  Layer full = layer;
  for (auto& sample : full) sample += std::max(0.0F, 1.0F - sample[3]) * mean;
  return full;
}

Layer filled(const Layer& layer, int level) {
  if (level == kMinLatticeLevel) return completed(layer);
  return push(filled(pull(layer, level - 1), level - 1), layer, level);
}

}  // namespace

void fill_unseen(GeometryImage& image) {
  const int level = image.colour_level;
  check_lattice_level(level);
  if (image.colours.size() != lattice_size(level) || image.coverage.size() != image.colours.size())
    throw InvalidInput("the geometry image needs " + std::to_string(lattice_size(level)) +
                       " colours and as many coverage values before unseen texels can be filled");
  Layer seen(image.colours.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const float weight = static_cast<float>(image.coverage[i]) / 255.0F;
    const auto& c = image.colours[i];
    seen[i] = weight * Eigen::Vector4f(c[0], c[1], c[2], 1.0F);
  }
  const auto full = filled(seen, level);
  for (std::size_t i = 0; i < full.size(); ++i) {
    if (image.coverage[i] == 255) continue;
    for (int k = 0; k < 3; ++k)
      image.colours[i][static_cast<std::size_t>(k)] =
          static_cast<std::uint8_t>(std::clamp(std::lround(full[i][k] / full[i][3]), 0L, 255L));
  }
}

}  // namespace rotunda::recon
