#include "recon/hull/photo_hull.h"

#include <fmt/format.h>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr std::array<std::array<int, 3>, 6> kSteps{
    {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};

struct Seen {
  VoxelId cell = kNoVoxel;
  float depth = std::numeric_limits<float>::max();  // along the pixel's ray, to where it enters the cell
};

// Which cell each pixel of a view shows: the first that its ray enters.
class ItemBuffer {
 public:
  ItemBuffer(const SilhouetteView& view, const cv::Mat& picture, double rim_px)
      : view_(view), picture_(picture), rim_px_(rim_px), origin_(view.camera().centre()) {
    const auto& camera = view.camera();
    rays_.resize(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height),
                 Eigen::Vector3f::Zero());
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        if (tells(x, y))
          if (const auto ray = capture::ray_through(camera, {static_cast<double>(x), static_cast<double>(y)}))
            rays_[index(x, y)] = ray->cast<float>();
  }

  void render(const SignedGrid& grid, const std::vector<VoxelId>& surface) {
    seen_.assign(rays_.size(), {});
    for (const auto cell : surface) draw(grid, cell);
  }

  // Calls `visit(cell, colour)` for every pixel that shows one.
  template <class Visit>
  void for_each_pixel(Visit visit) const {
    for (int y = 0; y < picture_.rows; ++y)
      for (int x = 0; x < picture_.cols; ++x)
        if (const auto& seen = seen_[index(x, y)]; seen.cell != kNoVoxel)
          visit(seen.cell, picture_.at<cv::Vec3b>(y, x));
  }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.cols) + static_cast<std::size_t>(x);
  }
  bool tells(int x, int y) const { return static_cast<double>(view_.distance_px().at<float>(y, x)) > rim_px_; }

  // The part of the cell's bounding square whose rays enter it.
  void draw(const SignedGrid& grid, VoxelId cell) {
    const Eigen::Vector3d centre = grid.position(cell);
    const auto pixel = capture::project(view_.camera(), centre);
    if (!pixel) return;
    const double depth = view_.camera().axis().dot(centre - origin_);
    const double reach = 0.5 * std::sqrt(3.0) * grid.cell_size() * view_.most_px_per_ideal() / depth + 1.0;
    const int left = std::max(0, cvCeil(pixel->x() - reach)), top = std::max(0, cvCeil(pixel->y() - reach));
    const int right = std::min(picture_.cols - 1, cvFloor(pixel->x() + reach));
    const int bottom = std::min(picture_.rows - 1, cvFloor(pixel->y() + reach));
    const Eigen::Vector3f from = (centre - origin_).cast<float>();
    const auto half = static_cast<float>(0.5 * grid.cell_size());
    for (int y = top; y <= bottom; ++y)
      for (int x = left; x <= right; ++x) {
        auto& seen = seen_[index(x, y)];
        const float entry = entry_of(rays_[index(x, y)], from, half);
        if (entry < seen.depth || (entry == seen.depth && cell < seen.cell)) seen = {cell, entry};
      }
  }

  // How far along the ray from the origin it enters the cube about `centre`; the largest number if it misses it.
  static float entry_of(const Eigen::Vector3f& ray, const Eigen::Vector3f& centre, float half) {
    constexpr float kMiss = std::numeric_limits<float>::infinity();
    if (ray.isZero(0.0F)) return kMiss;
    const Eigen::Array3f a = (centre.array() - half) / ray.array(), b = (centre.array() + half) / ray.array();
    const float enter = a.min(b).maxCoeff(), leave = a.max(b).minCoeff();
    return enter <= leave && enter > 0.0F ? enter : kMiss;
  }

  const SilhouetteView& view_;
  const cv::Mat& picture_;
  double rim_px_;
  Eigen::Vector3d origin_;
  std::vector<Eigen::Vector3f> rays_;  // zero where the pixel says nothing
  std::vector<Seen> seen_;
};

// The colours of one cell over the views that see it.
struct CellColour {
  Eigen::Vector3d of_view = Eigen::Vector3d::Zero();  // pixels of the view at hand
  int pixels = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();  // of the views' means
  int views = 0;

  void end_view() {
    if (pixels == 0) return;
    const Eigen::Vector3d mean = of_view / pixels;
    sum += mean;
    squares += mean.cwiseProduct(mean);
    ++views;
    of_view.setZero();
    pixels = 0;
  }
  double spread() const {
    const Eigen::Vector3d mean = sum / views;
    return std::sqrt(std::max(0.0, (squares / views - mean.cwiseProduct(mean)).mean()));
  }
};

class Carving {
 public:
  Carving(SignedGrid& grid, std::span<const SilhouetteView> views, std::span<const cv::Mat> pictures,
          const PhotoHullOptions& options)
      : grid_(grid), options_(options), place_(grid.voxel_count(), kNotSurface) {
    for (std::size_t i = 0; i < views.size(); ++i) buffers_.emplace_back(views[i], pictures[i], options.rim_px);
    for (VoxelId id = 0; id < grid.voxel_count(); ++id)
      if (grid.value(id) > 0.0F && is_open(id)) add(id);
  }

  PhotoHullReport run() {
    PhotoHullReport report;
    for (; report.rounds < options_.most_rounds; ++report.rounds) {
      const auto carved = carve_inconsistent();
      if (carved == 0) break;
      report.carved += carved;
    }
    return report;
  }

 private:
  static constexpr std::uint32_t kNotSurface = 0xFFFFFFFFU;

  bool is_inside(VoxelId id) const { return id != kNoVoxel && grid_.value(id) > 0.0F; }
  bool is_open(VoxelId id) const {
    return std::any_of(kSteps.begin(), kSteps.end(),
                       [&](const auto& s) { return !is_inside(grid_.neighbour(id, s[0], s[1], s[2])); });
  }
  void add(VoxelId id) {
    place_[id] = static_cast<std::uint32_t>(surface_.size());
    surface_.push_back(id);
  }

  std::vector<CellColour> colours() {
    tbb::parallel_for(std::size_t{0}, buffers_.size(), [&](std::size_t i) { buffers_[i].render(grid_, surface_); });
    std::vector<CellColour> colours(surface_.size());
    for (const auto& buffer : buffers_) {
      buffer.for_each_pixel([&](VoxelId cell, const cv::Vec3b& rgb) {
        auto& colour = colours[place_[cell]];
        colour.of_view += Eigen::Vector3d(rgb[0], rgb[1], rgb[2]);
        ++colour.pixels;
      });
      for (auto& colour : colours) colour.end_view();
    }
    return colours;
  }

  std::size_t carve_inconsistent() {
    const auto of_cells = colours();
    std::vector<VoxelId> kept, carved;
    for (std::size_t i = 0; i < surface_.size(); ++i) {
      const bool differs = of_cells[i].views >= options_.least_views && of_cells[i].spread() > options_.most_spread &&
                           static_cast<double>(grid_.value(surface_[i])) < options_.deepest;
      (differs ? carved : kept).push_back(surface_[i]);
    }
    for (const auto id : carved) {
      grid_.set_value(id, static_cast<float>(-0.5 * grid_.cell_size()));
      place_[id] = kNotSurface;
    }
    surface_.clear();
    for (const auto id : kept) add(id);
    for (const auto id : carved)
      for (const auto& s : kSteps)
        if (const auto n = grid_.neighbour(id, s[0], s[1], s[2]); is_inside(n) && place_[n] == kNotSurface) add(n);
    return carved.size();
  }

  SignedGrid& grid_;
  PhotoHullOptions options_;
  std::vector<ItemBuffer> buffers_;
  std::vector<VoxelId> surface_;
  std::vector<std::uint32_t> place_;  // of each sample in `surface_`
};

}  // namespace

PhotoHullReport carve_photo_hull(SignedGrid& grid, std::span<const SilhouetteView> views,
                                 std::span<const cv::Mat> pictures, const PhotoHullOptions& options) {
  if (views.size() != pictures.size())
    throw InvalidInput(fmt::format("{} views but {} pictures: one a view is needed", views.size(), pictures.size()));
  for (std::size_t i = 0; i < views.size(); ++i)
    if (pictures[i].size() != views[i].distance_px().size() || pictures[i].type() != CV_8UC3)
      throw InvalidInput(fmt::format("{}: the picture does not have the calibration's size", views[i].camera().name));
  return Carving(grid, views, pictures, options).run();
}

}  // namespace rotunda::recon
