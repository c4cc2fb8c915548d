#include "recon/live/live_paint.h"

#include <tbb/parallel_for.h>

#include <limits>
#include <vector>

#include "capture/srgb.h"
#include "config/errors.h"
#include "recon/mesh/vertex_rings.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3f;

constexpr float kLeastCosine = 0.2F;  // flatter views show little but gloss
constexpr int kFeather = 2;           // half-size pixels: so far from the outline lens and mosaic mix backdrop in
constexpr float kRimWeight = 1e-3F;   // thin parts are all rim
constexpr std::uint8_t kClear = 250;  // alpha

struct Sight {
  LivePixel pixel;      // depth 0: not in the picture, or turned away
  float cosine = 0.0F;  // between normal and viewing direction
};

// What one view says of every vertex.
struct Say {
  std::vector<float> weight;
  std::vector<cv::Vec3b> colour;
};

float mean_edge(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) sum += static_cast<double>((mesh.positions[t[0]] - mesh.positions[t[1]]).norm());
  return mesh.triangles.empty() ? 0.0F : static_cast<float>(sum / static_cast<double>(mesh.triangles.size()));
}

std::vector<Sight> sights_of(const TriangleMesh& mesh, const LiveSilhouette& view) {
  const Vector3f centre = view.camera().centre().cast<float>();
  std::vector<Sight> sights(mesh.positions.size());
  for (std::size_t v = 0; v < sights.size(); ++v) {
    const Vector3f to = centre - mesh.positions[v];
    const float along = mesh.normals[v].dot(to);
    if (!(along > 0.0F)) continue;
    const float cosine = along / to.norm();
    LivePixel pixel;
    if (cosine >= kLeastCosine && view.project(mesh.positions[v], pixel)) sights[v] = {pixel, cosine};
  }
  return sights;
}

// The nearest depth about each cell of a grid over the picture.
class NearestDepths {
 public:
  // `edge`: the vertices' spacing, which the cells are of where the camera sees them largest.
  NearestDepths(const std::vector<Sight>& sights, const LiveSilhouette& view, float edge) {
    float nearest = std::numeric_limits<float>::max();
    for (const auto& sight : sights)
      if (sight.pixel.depth > 0.0F) nearest = std::min(nearest, sight.pixel.depth);
    step_ = std::clamp(std::ceil(edge * view.focal() / nearest), 1.0F, 64.0F);
    const auto cells = [this](int pixels) { return static_cast<int>((static_cast<float>(pixels) + 0.5F) / step_) + 3; };
    grid_ = cv::Mat(cells(view.camera().height), cells(view.camera().width), CV_32FC1,
                    cv::Scalar(std::numeric_limits<float>::max()));
    for (const auto& sight : sights) {
      if (sight.pixel.depth <= 0.0F) continue;
      const cv::Point cell = cell_of(sight.pixel);
      for (int j = cell.y - 1; j <= cell.y + 1; ++j)
        for (int i = cell.x - 1; i <= cell.x + 1; ++i)
          grid_.at<float>(j, i) = std::min(grid_.at<float>(j, i), sight.pixel.depth);
    }
  }
  float at(const LivePixel& pixel) const { return grid_.at<float>(cell_of(pixel)); }

 private:
  cv::Point cell_of(const LivePixel& pixel) const {
    return {static_cast<int>((pixel.x + 0.5F) / step_) + 1, static_cast<int>((pixel.y + 0.5F) / step_) + 1};
  }
  float step_ = 1.0F;
  cv::Mat grid_;
};

std::uint8_t alpha_at(const capture::HalfMatte& matte, int x, int y) {
  const cv::Point inside(x - matte.box.x, y - matte.box.y);
  if (!cv::Rect({}, matte.box.size()).contains(inside)) return 0;
  return matte.alpha.at<std::uint8_t>(inside);
}

bool well_inside(const capture::HalfMatte& matte, int x, int y) {
  return alpha_at(matte, x - kFeather, y) >= kClear && alpha_at(matte, x + kFeather, y) >= kClear &&
         alpha_at(matte, x, y - kFeather) >= kClear && alpha_at(matte, x, y + kFeather) >= kClear;
}

cv::Vec3b without_spill(cv::Vec3b rgb, capture::Backdrop backdrop) {
  const int own = backdrop == capture::Backdrop::blue ? 2 : 1;
  rgb[own] = std::min(rgb[own], std::max(rgb[0], rgb[3 - own]));
  return rgb;
}

cv::Vec3b colour_at(const capture::HalfPicture& half, int x, int y) {
  cv::Vec3b rgb;
  for (std::size_t c = 0; c < 3; ++c)
    rgb[static_cast<int>(c)] = static_cast<std::uint8_t>(half.planes[c].at<std::uint16_t>(y, x) / capture::kHalfScale);
  return rgb;
}

Say ask(const TriangleMesh& mesh, const PaintView& from, float edge, capture::Backdrop backdrop) {
  const auto& matte = *from.matte;
  const auto sights = sights_of(mesh, *from.view);
  const NearestDepths nearest(sights, *from.view, edge);
  Say say{std::vector<float>(sights.size(), 0.0F), std::vector<cv::Vec3b>(sights.size())};
  const cv::Size half = matte.picture.planes[0].size();
  const auto reduction = static_cast<float>(half.width / from.view->camera().width);
  for (std::size_t v = 0; v < sights.size(); ++v) {
    const auto& sight = sights[v];
    if (sight.pixel.depth <= 0.0F) continue;
    const float slope = std::sqrt(1.0F - std::min(1.0F, sight.cosine * sight.cosine)) / sight.cosine;
    if (sight.pixel.depth > nearest.at(sight.pixel) + 2.0F * edge * (1.0F + slope)) continue;
    const int x = std::clamp(static_cast<int>((sight.pixel.x + 0.5F) * reduction), 0, half.width - 1);
    const int y = std::clamp(static_cast<int>((sight.pixel.y + 0.5F) * reduction), 0, half.height - 1);
    if (alpha_at(matte, x, y) < 128) continue;
    const bool clear = well_inside(matte, x, y);
    const auto seen = colour_at(matte.picture, x, y);
    say.weight[v] = sight.cosine * sight.cosine * (clear ? 1.0F : kRimWeight);
    say.colour[v] = clear ? seen : without_spill(seen, backdrop);
  }
  if (from.colour != Eigen::Matrix3d::Identity()) {
    const cv::Mat column(static_cast<int>(say.colour.size()), 1, CV_8UC3, say.colour.data());
    capture::with_matrix(column, from.colour).copyTo(column);
  }
  return say;
}

// Breadth first over the mesh: each unseen vertex as the seen one that reaches it first.
void spread(TriangleMesh& mesh, std::vector<bool> known) {
  const VertexRings rings(mesh);
  std::vector<std::uint32_t> front;
  for (std::uint32_t v = 0; v < known.size(); ++v)
    if (known[v]) front.push_back(v);
  for (std::size_t i = 0; i < front.size(); ++i)
    for (const auto v : rings[front[i]]) {
      if (known[v]) continue;
      mesh.colours[v] = mesh.colours[front[i]];
      known[v] = true;
      front.push_back(v);
    }
}

}  // namespace

void paint_live(TriangleMesh& mesh, std::span<const PaintView> views, capture::Backdrop backdrop) {
  if (mesh.normals.size() != mesh.positions.size()) throw InvalidInput("a mesh without normals cannot be coloured");
  const float edge = mean_edge(mesh);
  std::vector<Say> says(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(),
                    [&](std::size_t i) { says[i] = ask(mesh, views[i], edge, backdrop); });
  mesh.colours.assign(mesh.positions.size(), Colour{128, 128, 128});
  std::vector<bool> known(mesh.positions.size(), false);
  bool all = true;
  for (std::size_t v = 0; v < known.size(); ++v) {
    float weight = 0.0F;
    cv::Vec3f sum;
    for (const auto& say : says) {
      weight += say.weight[v];
      sum += say.weight[v] * cv::Vec3f(say.colour[v]);
    }
    known[v] = weight > 0.0F;
    all = all && known[v];
    if (!known[v]) continue;
    for (int c = 0; c < 3; ++c)
      mesh.colours[v][static_cast<std::size_t>(c)] = cv::saturate_cast<std::uint8_t>(sum[c] / weight);
  }
  if (!all) spread(mesh, std::move(known));
}

}  // namespace rotunda::recon
