#include "recon/hull/rims.h"

#include <oneapi/tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace rotunda::recon {
namespace {

struct Stretch {
  double from, to;  // along the ray
};
using Stretches = std::vector<Stretch>;

// Where the outline crosses the lines between neighbouring pixel centres.
std::vector<Eigen::Vector2d> outline_points(const cv::Mat& distance) {
  std::vector<Eigen::Vector2d> points;
  const auto crossing = [](float a, float b) { return static_cast<double>(a) / static_cast<double>(a - b); };
  for (int y = 0; y + 1 < distance.rows; ++y) {
    const auto* row = distance.ptr<float>(y);
    const auto* below = distance.ptr<float>(y + 1);
    for (int x = 0; x + 1 < distance.cols; ++x) {
      if ((row[x] > 0.0F) != (row[x + 1] > 0.0F)) points.emplace_back(x + crossing(row[x], row[x + 1]), y);
      if ((row[x] > 0.0F) != (below[x] > 0.0F)) points.emplace_back(x, y + crossing(row[x], below[x]));
    }
  }
  return points;
}

float bilinear(const cv::Mat& image, double px, double py) {
  const double x = std::clamp(px, 0.0, image.cols - 1.001), y = std::clamp(py, 0.0, image.rows - 1.001);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const auto u = static_cast<float>(x - x0), v = static_cast<float>(y - y0);
  const auto* row = image.ptr<float>(y0) + x0;
  const auto* below = image.ptr<float>(y0 + 1) + x0;
  const float top = row[0] + u * (row[1] - row[0]), bottom = below[0] + u * (below[1] - below[0]);
  return top + v * (bottom - top);
}

// One view's silhouette along one ray o + t d: signed distance in pixels, and how far on it cannot change sign. In the
// ideal image plane the way from t to t + s has the length |c| s / (z(t) z(t + s)), c = b.xy a.z - a.xy b.z.
class RayInView {
 public:
  RayInView(const SilhouetteView& view, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)
      : view_(view),
        a_(view.camera().R * origin + view.camera().t),
        b_(view.camera().R * direction),
        sweep_((b_.head<2>() * a_.z() - a_.head<2>() * b_.z()).norm()) {}

  struct Sample {
    double distance_px;  // positive inside and where the view sees nothing
    double safe;         // so much of t farther on the sign is the same, nearly
  };
  Sample at(double t) const {
    const double z = a_.z() + t * b_.z();
    if (z <= 0.0) return {kUnseen, b_.z() > 0.0 ? (kNear - z) / b_.z() : kUnseen};
    const Eigen::Vector2d ideal = (a_.head<2>() + t * b_.head<2>()) / z;
    const double distance = distance_at(ideal);
    const double way = std::max(std::abs(distance), kLeastStep) / view_.most_px_per_ideal();
    const double rest = sweep_ - way * z * b_.z();
    return {distance, rest > 0.0 ? way * z * z / rest : kUnseen};
  }

 private:
  static constexpr double kUnseen = 1e9, kNear = 1e-3, kLeastStep = 0.5;  // pixels

  double distance_at(const Eigen::Vector2d& ideal) const {
    const auto& camera = view_.camera();
    if (!view_.may_see(ideal)) return kOutsideStep;
    const Eigen::Vector2d image = view_.is_distorted() ? capture::distort(camera, ideal) : ideal;
    const Eigen::Vector2d pixel = camera.K.topLeftCorner<2, 2>() * image + camera.K.topRightCorner<2, 1>();
    const double beyond =
        std::max({-0.5 - pixel.x(), -0.5 - pixel.y(), pixel.x() - camera.width + 0.5, pixel.y() - camera.height + 0.5});
    if (beyond > 0.0) return std::max(beyond, kLeastStep);
    return static_cast<double>(bilinear(view_.distance_px(), pixel.x(), pixel.y()));
  }
  static constexpr double kOutsideStep = 4.0;  // pixels

  const SilhouetteView& view_;
  Eigen::Vector3d a_, b_;
  double sweep_;
};

// What the view leaves of the stretches.
Stretches within(const RayInView& ray, const Stretches& stretches) {
  Stretches kept;
  for (const auto& stretch : stretches) {
    double t = stretch.from, begin = t;
    auto sample = ray.at(t);
    while (t < stretch.to) {
      const double next = std::min(t + sample.safe, stretch.to);
      const auto following = ray.at(next);
      const bool was_inside = sample.distance_px > 0.0, is_inside = following.distance_px > 0.0;
      if (was_inside != is_inside) {
        const double share = sample.distance_px / (sample.distance_px - following.distance_px);
        const double crossing = t + share * (next - t);
        if (was_inside) kept.push_back({begin, crossing});
        begin = crossing;
      }
      if (is_inside && next >= stretch.to) kept.push_back({begin, stretch.to});
      t = next;
      sample = following;
    }
  }
  return kept;
}

std::optional<Stretch> within(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& origin,
                              const Eigen::Vector3d& direction) {
  Stretch stretch{0.0, std::numeric_limits<double>::max()};
  for (int k = 0; k < 3; ++k) {
    const double a = (box.min()[k] - origin[k]) / direction[k], b = (box.max()[k] - origin[k]) / direction[k];
    if (direction[k] == 0.0) {
      if (origin[k] < box.min()[k] || origin[k] > box.max()[k]) return std::nullopt;
      continue;
    }
    stretch.from = std::max(stretch.from, std::min(a, b));
    stretch.to = std::min(stretch.to, std::max(a, b));
  }
  if (stretch.from >= stretch.to) return std::nullopt;
  return stretch;
}

// The others, those that look across the view's axis first: they leave least of its rays.
std::vector<std::size_t> crossing_order(std::span<const SilhouetteView> views, std::size_t own) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (i != own) order.push_back(i);
  const auto along = [&](std::size_t i) { return std::abs(views[i].camera().axis().dot(views[own].camera().axis())); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return along(a) < along(b); });
  return order;
}

// Outward normal of the silhouette's cone along the ray through an outline point.
Eigen::Vector3d cone_normal(const SilhouetteView& view, const Eigen::Vector2d& pixel,
                            const Eigen::Vector3d& direction) {
  const auto& camera = view.camera();
  const auto at = [&](double dx, double dy) {
    return static_cast<double>(bilinear(view.distance_px(), pixel.x() + dx, pixel.y() + dy));
  };
  const Eigen::Vector2d inward(at(1.0, 0.0) - at(-1.0, 0.0), at(0.0, 1.0) - at(0.0, -1.0));
  const Eigen::Vector2d g = camera.K.topLeftCorner<2, 2>().transpose() * inward;
  const Eigen::Vector3d ray = camera.R * direction;
  const Eigen::Vector3d normal(-g.x(), -g.y(), g.dot(ray.head<2>()) / ray.z());
  return (camera.R.transpose() * normal).normalized();
}

std::optional<Rim> rim_at(std::span<const SilhouetteView> views, std::size_t own,
                          const std::vector<std::size_t>& others, const Eigen::Vector2d& pixel,
                          const RimOptions& options) {
  const auto& camera = views[own].camera();
  const auto direction = capture::ray_through(camera, pixel);
  if (!direction) return std::nullopt;
  const Eigen::Vector3d origin = camera.centre();
  const auto whole = within(options.bounds, origin, *direction);
  if (!whole) return std::nullopt;
  Stretches stretches{*whole};
  for (const auto i : others) {
    stretches = within(RayInView(views[i], origin, *direction), stretches);
    if (stretches.empty()) return std::nullopt;
  }
  const double length = stretches.front().to - stretches.front().from;
  if (stretches.size() != 1 || length < options.shortest || length > options.longest) return std::nullopt;
  const double middle = 0.5 * (stretches.front().from + stretches.front().to);
  const double focal = std::sqrt(std::abs(camera.K.topLeftCorner<2, 2>().determinant()));
  Rim rim;
  rim.point = (origin + middle * *direction).cast<float>();
  rim.normal = cone_normal(views[own], pixel, *direction).cast<float>();
  rim.length = static_cast<float>(length);
  rim.pixel = static_cast<float>(middle * camera.axis().dot(*direction) / focal);
  if (!rim.normal.allFinite()) return std::nullopt;
  return rim;
}

}  // namespace

RimOptions rim_options(const Eigen::AlignedBox3d& bounds, double metre, int stride) {
  RimOptions options;
  options.bounds = bounds;
  options.shortest *= metre;
  options.longest *= metre;
  options.stride = stride;
  return options;
}

std::vector<Rim> find_rims(std::span<const SilhouetteView> views, const RimOptions& options) {
  std::vector<std::vector<Rim>> found(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t own) {
    const auto others = crossing_order(views, own);
    const auto points = outline_points(views[own].distance_px());
    for (std::size_t i = 0; i < points.size(); i += static_cast<std::size_t>(std::max(1, options.stride))) {
      if (views[own].is_guessed(points[i])) continue;
      if (const auto rim = rim_at(views, own, others, points[i], options)) found[own].push_back(*rim);
    }
  });
  std::vector<Rim> rims;
  for (const auto& some : found) rims.insert(rims.end(), some.begin(), some.end());
  return rims;
}

}  // namespace rotunda::recon
