#include "recon/hull/photo_fit.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "recon/mesh/vertex_rings.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kBestViews = 3;
constexpr double kDepthTolerance = 3.0;  // pixels at the vertex

struct Facing {
  double cosine;
  const PhotoView* view;
};

bool is_hidden(const PhotoView& view, const Eigen::Vector3d& point, const Eigen::Vector2d& pixel, double cosine) {
  const int x = static_cast<int>(std::lround(view.surface.from_picture(pixel.x())));
  const int y = static_cast<int>(std::lround(view.surface.from_picture(pixel.y())));
  if (x < 0 || y < 0 || x >= view.surface.depth.cols || y >= view.surface.depth.rows) return true;
  const double depth = view.camera.R.row(2).dot(point) + view.camera.t.z();
  const double footprint = depth / std::sqrt(std::abs(view.camera.K(0, 0) * view.camera.K(1, 1)));
  const double slope = std::sqrt(std::max(0.0, 1.0 - cosine * cosine)) / cosine;
  return static_cast<double>(view.surface.depth.at<float>(y, x)) <
         depth - footprint * (kDepthTolerance + 1.5 * view.surface.downscale * slope);
}

// The views that see the vertex, those that face it most squarely first.
std::vector<Facing> best_views(std::span<const PhotoView> views, const Eigen::Vector3d& point,
                               const Eigen::Vector3d& normal, double least_cosine) {
  std::vector<Facing> best;
  for (const auto& view : views) {
    const double cosine = normal.dot((view.camera.centre() - point).normalized());
    if (cosine < least_cosine) continue;
    const auto pixel = capture::project(view.camera, point);
    if (pixel && !is_hidden(view, point, *pixel, cosine)) best.push_back({cosine, &view});
  }
  std::stable_sort(best.begin(), best.end(), [](const Facing& a, const Facing& b) { return a.cosine > b.cosine; });
  best.resize(std::min(best.size(), kBestViews));
  return best;
}

// A square patch of the tangent plane.
struct Patch {
  Eigen::Vector3d centre, along, across;  // one sample's step
  int side;
};

Patch patch_at(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double pitch, int side) {
  const Eigen::Vector3d up = std::abs(normal.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d along = up.cross(normal).normalized();
  return {point, pitch * along, pitch * normal.cross(along), side};
}

struct PatchPixels {
  std::vector<float> value;  // without their mean
  float norm = 0.0F;         // root of the sum of squares
  bool valid = false;
};

// To first order about the centre: a patch is a few pixels wide.
void read_patch(const PhotoView& view, const Patch& patch, PatchPixels& pixels) {
  pixels.valid = false;
  const double half = 0.5 * (patch.side - 1);
  const auto middle = capture::project(view.camera, patch.centre);
  const auto right = capture::project(view.camera, patch.centre + half * patch.along);
  const auto up = capture::project(view.camera, patch.centre + half * patch.across);
  if (!middle || !right || !up) return;
  const Eigen::Vector2f dx = ((*right - *middle) / half).cast<float>(), dy = ((*up - *middle) / half).cast<float>();
  const Eigen::Vector2f corner = middle->cast<float>() - static_cast<float>(half) * (dx + dy);
  const float reach =
      static_cast<float>(half) * (std::abs(dx.x()) + std::abs(dy.x()) + std::abs(dx.y()) + std::abs(dy.y()));
  if (middle->x() < static_cast<double>(reach) || middle->y() < static_cast<double>(reach) ||
      middle->x() > view.grey.cols - 2 - static_cast<double>(reach) ||
      middle->y() > view.grey.rows - 2 - static_cast<double>(reach))
    return;
  pixels.value.resize(static_cast<std::size_t>(patch.side * patch.side));
  float sum = 0.0F;
  for (int j = 0; j < patch.side; ++j)
    for (int i = 0; i < patch.side; ++i) {
      const Eigen::Vector2f at = corner + static_cast<float>(i) * dx + static_cast<float>(j) * dy;
      const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
      const float u = at.x() - static_cast<float>(x), v = at.y() - static_cast<float>(y);
      const auto* row = view.grey.ptr<float>(y) + x;
      const auto* below = view.grey.ptr<float>(y + 1) + x;
      const float top = row[0] + u * (row[1] - row[0]), bottom = below[0] + u * (below[1] - below[0]);
      const float value = top + v * (bottom - top);
      pixels.value[static_cast<std::size_t>(j * patch.side + i)] = value;
      sum += value;
    }
  const float mean = sum / static_cast<float>(pixels.value.size());
  float squares = 0.0F;
  for (auto& value : pixels.value) {
    value -= mean;
    squares += value * value;
  }
  pixels.norm = std::sqrt(squares);
  pixels.valid = true;
}

// Normalised cross-correlation, less where there is little but noise to compare.
float correlation(const PatchPixels& a, const PatchPixels& b, double noise) {
  float sum = 0.0F;
  for (std::size_t i = 0; i < a.value.size(); ++i) sum += a.value[i] * b.value[i];
  const auto floor = static_cast<float>(noise * noise) * static_cast<float>(a.value.size());
  return sum / std::sqrt((a.norm * a.norm + floor) * (b.norm * b.norm + floor));
}

// Vertices of which no two are neighbours, as many as their order allows.
std::vector<char> every_other(const VertexRings& rings) {
  std::vector<char> chosen(rings.size(), 0);
  for (std::size_t v = 0; v < chosen.size(); ++v)
    chosen[v] = std::none_of(rings[v].begin(), rings[v].end(), [&](std::uint32_t n) { return chosen[n] != 0; }) ? 1 : 0;
  return chosen;
}

class PhotoFit {
 public:
  PhotoFit(const TriangleMesh& mesh, std::span<const float> rim_distance, std::span<const PhotoView> views,
           const PhotoFitOptions& options)
      : mesh_(mesh),
        rings_(mesh),
        rim_distance_(rim_distance),
        views_(views),
        options_(options),
        labels_(static_cast<std::size_t>(2 * options.steps + 1)),
        step_(options.reach / options.steps),
        is_matched_(options.thinned ? every_other(rings_) : std::vector<char>(mesh.positions.size(), 1)),
        cost_(mesh.positions.size() * labels_) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.positions.size(), 256), [&](const auto& range) {
      for (auto v = range.begin(); v != range.end(); ++v)
        if (is_matched_[v] != 0) fill_cost(v);
    });
  }

  std::vector<float> offsets() const {
    const std::size_t count = mesh_.positions.size();
    std::vector<float> smooth(count, 0.0F), found(count, 0.0F);
    constexpr int kRounds = 12, kSweeps = 4;
    float coupling = 0.02F;  // of a step's difference between what was found and the smooth field, squared
    for (int round = 0; round < kRounds; ++round, coupling *= 1.7F) {
      for (std::size_t v = 0; v < count; ++v)
        if (is_matched_[v] != 0) found[v] = best_near(v, smooth[v], coupling);
      for (int sweep = 0; sweep < kSweeps; ++sweep)
        for (std::size_t v = 0; v < count; ++v)
          smooth[v] = evened(v, smooth, found[v], is_matched_[v] != 0 ? coupling : 0.0F);
    }
    for (auto& offset : smooth) offset *= static_cast<float>(step_);
    return smooth;
  }

 private:
  void fill_cost(std::size_t v) {
    const Eigen::Vector3d point = mesh_.positions[v].cast<double>(), normal = mesh_.normals[v].cast<double>();
    const double sigma = options_.prior_sigma + options_.prior_slope * static_cast<double>(rim_distance_[v]);
    float* cost = &cost_[v * labels_];
    for (std::size_t l = 0; l < labels_; ++l) {
      const double off = offset_of(l) / sigma;
      cost[l] = static_cast<float>(0.5 * off * off);
    }
    const auto best = best_views(views_, point, normal, options_.least_cosine);
    if (best.size() < 2) return;
    const auto& front = *best.front().view;
    const double depth = front.camera.R.row(2).dot(point) + front.camera.t.z();
    const double pitch = depth / std::sqrt(std::abs(front.camera.K(0, 0) * front.camera.K(1, 1)));
    std::array<PatchPixels, kBestViews> pixels;
    for (std::size_t l = 0; l < labels_; ++l) {
      const auto patch = patch_at(point + offset_of(l) * normal, normal, pitch, options_.patch);
      for (std::size_t i = 0; i < best.size(); ++i) read_patch(*best[i].view, patch, pixels[i]);
      cost[l] += static_cast<float>(options_.photo_weight) * (1.0F - agreement(pixels, best.size()));
    }
  }

  // Of two views that agree the third may be hidden.
  float agreement(const std::array<PatchPixels, kBestViews>& pixels, std::size_t count) const {
    float best = 0.0F;
    float sum = 0.0F;
    int pairs = 0;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = i + 1; j < count; ++j) {
        if (!pixels[i].valid || !pixels[j].valid) continue;
        const float c = correlation(pixels[i], pixels[j], options_.noise);
        if (i == 0 && j == 1) best = c;
        sum += c;
        ++pairs;
      }
    return pairs == 0 ? 0.0F : std::max(best, sum / static_cast<float>(pairs));
  }

  double offset_of(std::size_t label) const { return (static_cast<double>(label) - options_.steps) * step_; }

  // In steps.
  float best_near(std::size_t v, float smooth, float coupling) const {
    const float* cost = &cost_[v * labels_];
    float best = 0.0F, least = 1e30F;
    for (std::size_t l = 0; l < labels_; ++l) {
      const float at = static_cast<float>(l) - static_cast<float>(options_.steps);
      const float energy = cost[l] + coupling * (at - smooth) * (at - smooth);
      if (energy < least) {
        least = energy;
        best = at;
      }
    }
    return best;
  }

  float evened(std::size_t v, const std::vector<float>& smooth, float found, float coupling) const {
    float sum = 0.0F;
    for (const auto n : rings_[v]) sum += smooth[n];
    const auto count = static_cast<float>(rings_[v].size());
    const float pull = static_cast<float>(options_.smoothness) / count;
    return (pull * sum + coupling * found) / (pull * count + coupling);
  }

  const TriangleMesh& mesh_;
  VertexRings rings_;
  std::span<const float> rim_distance_;
  std::span<const PhotoView> views_;
  PhotoFitOptions options_;
  std::size_t labels_;
  double step_;
  std::vector<char> is_matched_;
  std::vector<float> cost_;  // by vertex, then by offset
};

}  // namespace

std::vector<PhotoView> photo_views(const TriangleMesh& mesh, std::span<const capture::CameraModel> cameras,
                                   std::span<const cv::Mat> pictures) {
  std::vector<PhotoView> views(cameras.size());
  tbb::parallel_for(std::size_t{0}, cameras.size(), [&](std::size_t i) {
    cv::Mat grey;
    cv::cvtColor(pictures[i], grey, cv::COLOR_RGB2GRAY);
    grey.convertTo(views[i].grey, CV_32F);
    views[i].camera = cameras[i];
    views[i].surface = render_depth(mesh, cameras[i]);
  });
  return views;
}

std::vector<float> photo_offsets(const TriangleMesh& mesh, std::span<const float> rim_distance,
                                 std::span<const PhotoView> views, const PhotoFitOptions& options) {
  return PhotoFit(mesh, rim_distance, views, options).offsets();
}

}  // namespace rotunda::recon
