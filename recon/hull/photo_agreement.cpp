#include "recon/hull/photo_agreement.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace rotunda::recon {
namespace {

constexpr std::size_t kBestViews = 3;
constexpr double kDepthTolerance = 3.0;  // pixels at the vertex
constexpr double kAxisSamples = 3.0;     // over which a patch's axes are measured

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

// Where a square patch of the tangent plane lies in a view while it moves along its normal: its middle to second order
// in the offset, its axes as they are at the start (over the centimetres that offsets go they change by a hundredth).
struct PatchTrack {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero(), along = Eigen::Vector2d::Zero(), bend = Eigen::Vector2d::Zero();
  Eigen::Vector2f dx = Eigen::Vector2f::Zero(), dy = Eigen::Vector2f::Zero();  // one sample's step
  Eigen::Vector2f at(double offset) const { return (middle + offset * (along + offset * bend)).cast<float>(); }
};

// `pitch`: of the patch's samples; `reach`: of the offsets.
std::optional<PatchTrack> track_of(const PhotoView& view, const SurfacePlace& place, double pitch, double reach) {
  const Eigen::Vector3d up = std::abs(place.normal.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d right = up.cross(place.normal).normalized();
  const auto project = [&](const Eigen::Vector3d& step) { return capture::project(view.camera, place.point + step); };
  const auto middle = project(Eigen::Vector3d::Zero());
  const auto beside = project(kAxisSamples * pitch * right);
  const auto above = project(kAxisSamples * pitch * place.normal.cross(right));
  const auto outer = project(reach * place.normal), inner = project(-reach * place.normal);
  if (!middle || !beside || !above || !outer || !inner) return std::nullopt;
  PatchTrack track{.middle = *middle};
  track.dx = ((*beside - *middle) / kAxisSamples).cast<float>();
  track.dy = ((*above - *middle) / kAxisSamples).cast<float>();
  if (reach > 0.0) {
    track.along = (*outer - *inner) / (2.0 * reach);
    track.bend = (*outer + *inner - 2.0 * *middle) / (2.0 * reach * reach);
  }
  return track;
}

struct PatchPixels {
  std::vector<float> value;  // without their mean
  float norm = 0.0F;         // root of the sum of squares
  bool valid = false;
};

void read_patch(const cv::Mat& grey, const PatchTrack& track, double offset, int side, PatchPixels& pixels) {
  pixels.valid = false;
  const Eigen::Vector2f &dx = track.dx, &dy = track.dy, middle = track.at(offset);
  const float half = 0.5F * static_cast<float>(side - 1);
  const float reach = half * (std::abs(dx.x()) + std::abs(dy.x()) + std::abs(dx.y()) + std::abs(dy.y()));
  if (!(middle.x() >= reach && middle.y() >= reach && middle.x() <= static_cast<float>(grey.cols - 2) - reach &&
        middle.y() <= static_cast<float>(grey.rows - 2) - reach))
    return;
  const Eigen::Vector2f corner = middle - half * (dx + dy);
  pixels.value.resize(static_cast<std::size_t>(side * side));
  float sum = 0.0F;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const Eigen::Vector2f at = corner + static_cast<float>(i) * dx + static_cast<float>(j) * dy;
      const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
      const float u = at.x() - static_cast<float>(x), v = at.y() - static_cast<float>(y);
      const auto* row = grey.ptr<float>(y) + x;
      const auto* below = grey.ptr<float>(y + 1) + x;
      const float top = row[0] + u * (row[1] - row[0]), bottom = below[0] + u * (below[1] - below[0]);
      const float value = top + v * (bottom - top);
      pixels.value[static_cast<std::size_t>(j * side + i)] = value;
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

// Of two views that agree the third may be hidden.
float agreement_of(const std::array<PatchPixels, kBestViews>& pixels, std::size_t count, double noise) {
  float best = 0.0F;
  float sum = 0.0F;
  int pairs = 0;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 1; j < count; ++j) {
      if (!pixels[i].valid || !pixels[j].valid) continue;
      const float c = correlation(pixels[i], pixels[j], noise);
      if (i == 0 && j == 1) best = c;
      sum += c;
      ++pairs;
    }
  return pairs == 0 ? 0.0F : std::max(best, sum / static_cast<float>(pairs));
}

}  // namespace

bool photo_agreement(std::span<const PhotoView> views, const SurfacePlace& place, std::span<const double> offsets,
                     const PhotoAgreementOptions& options, std::span<float> agreement) {
  const auto best = best_views(views, place.point, place.normal, options.least_cosine);
  if (best.size() < 2) return false;
  const auto& front = *best.front().view;
  const double depth = front.camera.R.row(2).dot(place.point) + front.camera.t.z();
  const double pitch = depth / std::sqrt(std::abs(front.camera.K(0, 0) * front.camera.K(1, 1)));
  double reach = 0.0;
  for (const double offset : offsets) reach = std::max(reach, std::abs(offset));
  std::array<std::optional<PatchTrack>, kBestViews> tracks;
  for (std::size_t i = 0; i < best.size(); ++i) tracks[i] = track_of(*best[i].view, place, pitch, reach);
  std::array<PatchPixels, kBestViews> pixels;
  for (std::size_t l = 0; l < offsets.size(); ++l) {
    for (std::size_t i = 0; i < best.size(); ++i)
      if (tracks[i]) read_patch(best[i].view->grey, *tracks[i], offsets[l], options.patch, pixels[i]);
    agreement[l] = agreement_of(pixels, best.size(), options.noise);
  }
  return true;
}

void surface_agreement(const TriangleMesh& mesh, std::span<const PhotoView> views, const PhotoAgreementOptions& options,
                       std::span<float> agreement, std::span<float> seen) {
  constexpr std::array<double, 1> kHere{0.0};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.positions.size(), 256),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (auto v = range.begin(); v != range.end(); ++v) {
                        const SurfacePlace place{mesh.positions[v].cast<double>(), mesh.normals[v].cast<double>()};
                        seen[v] = photo_agreement(views, place, kHere, options, agreement.subspan(v, 1)) ? 1.0F : 0.0F;
                      }
                    });
}

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

}  // namespace rotunda::recon
