#include "recon/live/live_rims.h"

#include <tbb/parallel_for.h>

#include <array>
#include <limits>

namespace rotunda::recon {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

struct Stretch {
  float from, to;  // along the ray
};
// What is left of a ray; too many stretches tell nothing of where the body is.
struct Stretches {
  static constexpr std::size_t kMost = 8;
  std::array<Stretch, kMost> stretch;
  std::size_t count = 0;
  void add(const Stretch& s) {
    if (count < kMost) stretch[count] = s;
    ++count;
  }
};

std::vector<Vector2f> outline_points(const LiveSilhouette& view, int stride) {
  std::vector<Vector2f> points;
  const cv::Mat& distance = view.distance_px();
  const auto left = static_cast<float>(view.box().x), top = static_cast<float>(view.box().y);
  int count = 0;
  const auto add = [&](int x, int y, float along, float down) {
    if (count++ % stride == 0)
      points.emplace_back(left + static_cast<float>(x) + along, top + static_cast<float>(y) + down);
  };
  for (int y = 0; y + 1 < distance.rows; ++y) {
    const auto* row = distance.ptr<float>(y);
    const auto* below = distance.ptr<float>(y + 1);
    for (int x = 0; x + 1 < distance.cols; ++x) {
      if ((row[x] > 0.0F) != (row[x + 1] > 0.0F)) add(x, y, row[x] / (row[x] - row[x + 1]), 0.0F);
      if ((row[x] > 0.0F) != (below[x] > 0.0F)) add(x, y, 0.0F, row[x] / (row[x] - below[x]));
    }
  }
  return points;
}

// One view's silhouette along one ray, as rims.cpp has it: signed distance, and how far on it cannot change sign.
class RayInView {
 public:
  RayInView(const LiveSilhouette& view, const Vector3f& origin, const Vector3f& direction)
      : view_(view),
        a_(view.rotation() * origin + view.shift()),
        b_(view.rotation() * direction),
        sweep_((b_.head<2>() * a_.z() - a_.head<2>() * b_.z()).norm()),
        ideal_per_px_(1.0F / view.most_px_per_ideal()) {}

  struct Sample {
    float distance;  // pixels, positive inside and where the view sees nothing
    float safe;      // so much farther along the ray the sign is the same, nearly
  };
  Sample at(float t) const {
    const float z = a_.z() + t * b_.z();
    if (z <= 0.0F) return {kUnseen, b_.z() > 0.0F ? (kNear - z) / b_.z() : kUnseen};
    LivePixel pixel;
    const float distance = view_.see(a_ + t * b_, pixel) ? view_.distance_at(pixel) : kOutsideStep;
    const float way = std::max(std::abs(distance), kLeastStep) * ideal_per_px_;
    const float rest = sweep_ - way * z * b_.z();
    return {distance, rest > 0.0F ? way * z * z / rest : kUnseen};
  }

 private:
  static constexpr float kUnseen = 1e9F, kNear = 1e-3F;
  static constexpr float kLeastStep = 0.5F, kOutsideStep = 2.0F;  // pixels

  const LiveSilhouette& view_;
  Vector3f a_, b_;
  float sweep_, ideal_per_px_;
};

void keep_within(const RayInView& ray, const Stretch& stretch, Stretches& kept) {
  float t = stretch.from, begin = t;
  auto sample = ray.at(t);
  while (t < stretch.to) {
    const float next = std::min(t + sample.safe, stretch.to);
    const auto following = ray.at(next);
    const bool was_inside = sample.distance > 0.0F, is_inside = following.distance > 0.0F;
    if (was_inside != is_inside) {
      const float crossing = t + sample.distance / (sample.distance - following.distance) * (next - t);
      if (was_inside) kept.add({begin, crossing});
      begin = crossing;
    }
    if (is_inside && next >= stretch.to) kept.add({begin, stretch.to});
    t = next;
    sample = following;
  }
}

Stretches in_box(const Eigen::AlignedBox3f& box, const Vector3f& origin, const Vector3f& direction) {
  const Vector3f a = (box.min() - origin).cwiseQuotient(direction), b = (box.max() - origin).cwiseQuotient(direction);
  const float from = std::max(0.0F, a.cwiseMin(b).maxCoeff()), to = a.cwiseMax(b).minCoeff();
  Stretches all;
  if (from < to) all.add({from, to});
  return all;
}

// The others, those that look across the view's axis first: they leave least of its rays.
std::vector<const LiveSilhouette*> crossing_order(std::span<const LiveSilhouette> views, std::size_t own) {
  std::vector<const LiveSilhouette*> order;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (i != own) order.push_back(&views[i]);
  const auto along = [&](const LiveSilhouette* view) {
    return std::abs(view->camera().axis().dot(views[own].camera().axis()));
  };
  std::stable_sort(order.begin(), order.end(), [&](const auto* a, const auto* b) { return along(a) < along(b); });
  return order;
}

// The one stretch that all views leave of a ray, if it is one.
std::optional<Stretch> only_stretch(std::span<const LiveSilhouette* const> others, const Vector3f& origin,
                                    const Vector3f& direction, const RimOptions& options) {
  auto stretches = in_box(options.bounds.cast<float>(), origin, direction);
  for (const auto* view : others) {
    if (stretches.count == 0) return std::nullopt;
    const RayInView ray(*view, origin, direction);
    Stretches kept;
    for (std::size_t i = 0; i < stretches.count; ++i) keep_within(ray, stretches.stretch[i], kept);
    if (kept.count > Stretches::kMost) return std::nullopt;
    stretches = kept;
  }
  const auto length = stretches.stretch[0].to - stretches.stretch[0].from;
  if (stretches.count != 1 || length < static_cast<float>(options.shortest) ||
      length > static_cast<float>(options.longest))
    return std::nullopt;
  return stretches.stretch[0];
}

// Outward normal of the silhouette's cone along the ray through an outline point.
Vector3f cone_normal(const LiveSilhouette& view, const Vector2f& pixel, const Vector3f& direction) {
  const Vector2f inward(view.distance_at(pixel.x() + 1.0F, pixel.y()) - view.distance_at(pixel.x() - 1.0F, pixel.y()),
                        view.distance_at(pixel.x(), pixel.y() + 1.0F) - view.distance_at(pixel.x(), pixel.y() - 1.0F));
  const Vector2f g = view.camera().K.topLeftCorner<2, 2>().cast<float>().transpose() * inward;
  const Vector3f ray = view.rotation() * direction;
  const Vector3f normal(-g.x(), -g.y(), g.dot(ray.head<2>()) / ray.z());
  return (view.rotation().transpose() * normal).normalized();
}

std::optional<Rim> rim_at(const LiveSilhouette& own, std::span<const LiveSilhouette* const> others,
                          const Vector3f& origin, const Vector2f& pixel, const RimOptions& options) {
  const auto direction = capture::ray_through(own.camera(), pixel.cast<double>());
  if (!direction) return std::nullopt;
  const Vector3f along = direction->cast<float>();
  const auto stretch = only_stretch(others, origin, along, options);
  if (!stretch) return std::nullopt;
  const float middle = 0.5F * (stretch->from + stretch->to);
  Rim rim;
  rim.point = origin + middle * along;
  rim.normal = cone_normal(own, pixel, along);
  rim.length = stretch->to - stretch->from;
  rim.pixel = (own.rotation().row(2).dot(rim.point) + own.shift().z()) / own.focal();
  if (!rim.normal.allFinite()) return std::nullopt;
  return rim;
}

}  // namespace

std::vector<Rim> live_rims(std::span<const LiveSilhouette> views, const RimOptions& options) {
  std::vector<std::vector<Rim>> found(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t own) {
    const auto others = crossing_order(views, own);
    const Vector3f origin = views[own].camera().centre().cast<float>();
    for (const auto& pixel : outline_points(views[own], std::max(1, options.stride)))
      if (const auto rim = rim_at(views[own], others, origin, pixel, options)) found[own].push_back(*rim);
  });
  std::vector<Rim> rims;
  for (const auto& some : found) rims.insert(rims.end(), some.begin(), some.end());
  return rims;
}

}  // namespace rotunda::recon
