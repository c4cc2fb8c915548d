#include "recon/mesh/textured_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "capture/srgb.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int kMostSteps = 64;  // along a triangle's edge: pictures a thousand times finer than the mesh are thinned

// The texel at a place along one axis, wherever that is; NaN and what no int holds is the first.
int wrapped(float texel, int size, PictureWrap wrap) {
  const float count = static_cast<float>(size);
  if (!(std::abs(texel) < 1e9F)) return 0;
  if (wrap == PictureWrap::clamp) return static_cast<int>(std::clamp(texel, 0.0F, count - 1.0F));
  const float period = wrap == PictureWrap::mirrored ? 2.0F * count : count;
  const int at =
      std::clamp(static_cast<int>(texel - period * std::floor(texel / period)), 0, static_cast<int>(period) - 1);
  return at < size ? at : 2 * size - 1 - at;
}

Vector3f bilinear(const cv::Mat& picture, const SurfaceMaterial& material, const Vector2f& uv) {
  const Vector2f at(uv.x() * static_cast<float>(picture.cols) - 0.5F, uv.y() * static_cast<float>(picture.rows) - 0.5F);
  const Vector2f low = at.array().floor(), share = at - low;
  Vector3f sum = Vector3f::Zero();
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const float weight = (dx == 1 ? share.x() : 1.0F - share.x()) * (dy == 1 ? share.y() : 1.0F - share.y());
      if (!(weight > 0.0F)) continue;
      const int x = wrapped(low.x() + static_cast<float>(dx), picture.cols, material.wrap[0]);
      const int y = wrapped(low.y() + static_cast<float>(dy), picture.rows, material.wrap[1]);
      sum += weight * capture::linear_of(picture.at<cv::Vec3b>(y, x)).cast<float>();
    }
  return sum;
}

int steps_for(const std::array<Vector2f, 3>& uv, const cv::Mat& picture) {
  const Vector2f size(static_cast<float>(picture.cols), static_cast<float>(picture.rows));
  float longest = 0.0F;
  for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, (uv[(k + 1) % 3] - uv[k]).cwiseProduct(size).norm());
  return longest < static_cast<float>(kMostSteps) ? std::max(1, static_cast<int>(std::ceil(longest))) : kMostSteps;
}

// The colours of a triangle's corners: samples on a lattice a texel wide, each for the corner it is near.
std::array<Vector3f, 3> corners_in(const cv::Mat& picture, const SurfaceMaterial& material,
                                   const std::array<Vector2f, 3>& uv) {
  std::array<Vector3f, 3> sum;
  sum.fill(Vector3f::Zero());
  std::array<float, 3> weights{};
  const int n = steps_for(uv, picture);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j) {
      const std::array<int, 3> share = {i, j, n - i - j};
      const auto most = static_cast<std::size_t>(std::max_element(share.begin(), share.end()) - share.begin());
      const auto weight = static_cast<float>(2 * share[most] - n);
      if (weight <= 0.0F) continue;
      const Vector2f at = (static_cast<float>(share[0]) * uv[0] + static_cast<float>(share[1]) * uv[1] +
                           static_cast<float>(share[2]) * uv[2]) /
                          static_cast<float>(n);
      sum[most] += weight * bilinear(picture, material, at);
      weights[most] += weight;
    }
  for (std::size_t k = 0; k < 3; ++k) sum[k] /= weights[k];  // the corner itself is always among them
  return sum;
}

std::array<Vector3f, 3> corner_colours(const TexturedMesh& textured, std::size_t triangle) {
  const int named = textured.material[triangle];
  const auto material = named < 0 ? SurfaceMaterial{} : textured.materials[static_cast<std::size_t>(named)];
  const auto& corners = textured.mesh.triangles[triangle];
  const bool has_picture = material.picture >= 0, has_shades = !textured.shades.empty();
  std::array<Vector3f, 3> colours;
  colours.fill(Vector3f::Ones());
  if (has_picture)
    colours =
        corners_in(textured.pictures[static_cast<std::size_t>(material.picture)], material, textured.uv[triangle]);
  const bool is_shaded = has_shades && (textured.shades_tint || !has_picture);
  const bool has_factor = textured.shades_tint || !is_shaded;
  for (std::size_t k = 0; k < 3; ++k) {
    if (has_factor) colours[k] = colours[k].cwiseProduct(material.factor);
    if (is_shaded) colours[k] = colours[k].cwiseProduct(textured.shades[corners[k]]);
  }
  return colours;
}

// A number for each vertex, equal where they lie at exactly the same place.
std::vector<std::uint32_t> places_of(const std::vector<Vector3f>& positions) {
  std::vector<std::uint32_t> order(positions.size()), place(positions.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](std::uint32_t v) { return std::tuple(positions[v].x(), positions[v].y(), positions[v].z()); };
  const auto is_number = [&](std::uint32_t v) { return positions[v].allFinite(); };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (is_number(a) != is_number(b)) return is_number(a);
    return is_number(a) ? key(a) < key(b) : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i)
    place[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? place[order[i - 1]] : order[i];
  return place;
}

}  // namespace

void paint_vertices(TexturedMesh& textured) {
  auto& mesh = textured.mesh;
  const auto place = places_of(mesh.positions);
  std::vector<Vector3f> sum(mesh.positions.size(), Vector3f::Zero());
  std::vector<float> count(mesh.positions.size(), 0.0F);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    const auto colours = corner_colours(textured, t);
    for (std::size_t k = 0; k < 3; ++k) {
      sum[place[corners[k]]] += colours[k];
      count[place[corners[k]]] += 1.0F;
    }
  }
  mesh.colours.resize(mesh.positions.size());
  for (std::size_t v = 0; v < place.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c)
      mesh.colours[v][c] =
          capture::srgb8_of(sum[place[v]][static_cast<Eigen::Index>(c)] / std::max(1.0F, count[place[v]]));
}

}  // namespace rotunda::recon
