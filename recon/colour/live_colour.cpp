#include "recon/colour/live_colour.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "capture/srgb.h"
#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr double kLeastCosine = 0.2;  // flatter views show little but gloss
constexpr int kFeather_px = 4;        // so far from the outline lens and demosaicing mix backdrop in
constexpr float kRimWeight = 1e-3F;   // thin parts are all rim

struct Sight {
  cv::Point2f place;    // pixels
  float depth = 0.0F;   // world units; 0: not in the picture, or turned away
  float cosine = 0.0F;  // between normal and viewing direction
};

// What one view says of every vertex.
struct Say {
  std::vector<float> weight;
  std::vector<cv::Vec3b> colour;
};

void check(const TriangleMesh& mesh, std::span<const ColourView> views) {
  if (mesh.normals.size() != mesh.positions.size()) throw InvalidInput("a mesh without normals cannot be coloured");
  for (const auto& view : views)
    if (const cv::Size size(view.camera.width, view.camera.height);
        view.rgb.size() != size || view.matte.alpha.size() != size)
      throw InvalidInput(fmt::format("{}: picture and matte must be of the calibration's size, {} x {}",
                                     view.camera.name, size.width, size.height));
}

double mean_edge(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) sum += (mesh.positions[t[0]] - mesh.positions[t[1]]).norm();
  return mesh.triangles.empty() ? 0.0 : sum / static_cast<double>(mesh.triangles.size());
}

std::vector<Sight> sights_of(const TriangleMesh& mesh, const capture::CameraModel& camera) {
  const Eigen::Vector3d centre = camera.centre();
  std::vector<Sight> sights(mesh.positions.size());
  for (std::size_t v = 0; v < sights.size(); ++v) {
    const Eigen::Vector3d point = mesh.positions[v].cast<double>();
    const double cosine = mesh.normals[v].cast<double>().dot((centre - point).normalized());
    if (!(cosine >= kLeastCosine)) continue;
    const auto place = capture::project(camera, point);
    if (!place ||
        !(place->x() >= 0.0 && place->y() >= 0.0 && place->x() <= camera.width - 1 && place->y() <= camera.height - 1))
      continue;
    sights[v] = {{static_cast<float>(place->x()), static_cast<float>(place->y())},
                 static_cast<float>(camera.R.row(2).dot(point) + camera.t.z()),
                 static_cast<float>(cosine)};
  }
  return sights;
}

// Pixels a grid cell: the vertices' spacing as the camera sees it.
int grid_step(const std::vector<Sight>& sights, const capture::CameraModel& camera, double edge) {
  double nearest = std::numeric_limits<double>::max();
  for (const auto& sight : sights)
    if (sight.depth > 0.0F) nearest = std::min<double>(nearest, sight.depth);
  const double step = std::ceil(edge * std::max(camera.K(0, 0), camera.K(1, 1)) / nearest);
  return static_cast<int>(std::clamp(step, 1.0, 64.0));
}

// The nearest depth about each grid cell: of its own vertices and its neighbours'.
cv::Mat nearest_depths(const std::vector<Sight>& sights, const cv::Size& picture, int step) {
  cv::Mat grid((picture.height + step - 1) / step + 2, (picture.width + step - 1) / step + 2, CV_32FC1,
               cv::Scalar(std::numeric_limits<float>::max()));
  for (const auto& sight : sights) {
    if (sight.depth <= 0.0F) continue;
    const int x = static_cast<int>(sight.place.x) / step, y = static_cast<int>(sight.place.y) / step;
    for (int j = y; j <= y + 2; ++j)
      for (int i = x; i <= x + 2; ++i) grid.at<float>(j, i) = std::min(grid.at<float>(j, i), sight.depth);
  }
  return grid;
}

bool well_inside(const cv::Mat& alpha, int x, int y) {
  const auto is_inside = [&](int i, int j) {
    return alpha.at<std::uint8_t>(std::clamp(j, 0, alpha.rows - 1), std::clamp(i, 0, alpha.cols - 1)) >= 250;
  };
  return is_inside(x - kFeather_px, y) && is_inside(x + kFeather_px, y) && is_inside(x, y - kFeather_px) &&
         is_inside(x, y + kFeather_px);
}

cv::Vec3b without_spill(cv::Vec3b rgb, capture::Backdrop backdrop) {
  const int own = backdrop == capture::Backdrop::blue ? 2 : 1;
  rgb[own] = std::min(rgb[own], std::max(rgb[0], rgb[3 - own]));
  return rgb;
}

Say ask(const TriangleMesh& mesh, const ColourView& view, double edge, capture::Backdrop backdrop) {
  const auto sights = sights_of(mesh, view.camera);
  const int step = grid_step(sights, view.camera, edge);
  const cv::Mat nearest = nearest_depths(sights, view.rgb.size(), step);
  Say say{std::vector<float>(sights.size(), 0.0F), std::vector<cv::Vec3b>(sights.size())};
  for (std::size_t v = 0; v < sights.size(); ++v) {
    const auto& sight = sights[v];
    if (sight.depth <= 0.0F) continue;
    const float slope = std::sqrt(1.0F - sight.cosine * sight.cosine) / sight.cosine;
    const float hidden_by =
        nearest.at<float>(static_cast<int>(sight.place.y) / step + 1, static_cast<int>(sight.place.x) / step + 1);
    if (sight.depth > hidden_by + 2.0F * static_cast<float>(edge) * (1.0F + slope)) continue;
    const int x = cvRound(sight.place.x), y = cvRound(sight.place.y);
    if (view.matte.alpha.at<std::uint8_t>(y, x) < 128) continue;
    const bool clear = well_inside(view.matte.alpha, x, y);
    say.weight[v] = sight.cosine * sight.cosine * (clear ? 1.0F : kRimWeight);
    say.colour[v] = clear ? view.rgb.at<cv::Vec3b>(y, x) : without_spill(view.rgb.at<cv::Vec3b>(y, x), backdrop);
  }
  if (view.colour != Eigen::Matrix3d::Identity()) {
    const cv::Mat column(static_cast<int>(say.colour.size()), 1, CV_8UC3, say.colour.data());
    capture::with_matrix(column, view.colour).copyTo(column);
  }
  return say;
}

// Breadth first over the mesh: each unseen vertex as the seen one that reaches it first.
void spread(TriangleMesh& mesh, std::vector<bool> known) {
  std::vector<std::vector<std::uint32_t>> beside(mesh.positions.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      if (!known[t[i]] || !known[t[(i + 1) % 3]]) {
        beside[t[i]].push_back(t[(i + 1) % 3]);
        beside[t[(i + 1) % 3]].push_back(t[i]);
      }
  std::deque<std::uint32_t> front;
  for (std::uint32_t v = 0; v < beside.size(); ++v)
    if (known[v] && !beside[v].empty()) front.push_back(v);
  for (; !front.empty(); front.pop_front())
    for (const auto v : beside[front.front()]) {
      if (known[v]) continue;
      mesh.colours[v] = mesh.colours[front.front()];
      known[v] = true;
      front.push_back(v);
    }
}

}  // namespace

void colour_live(TriangleMesh& mesh, std::span<const ColourView> views, capture::Backdrop backdrop) {
  check(mesh, views);
  const double edge = mean_edge(mesh);
  std::vector<Say> says(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(),
                    [&](std::size_t i) { says[i] = ask(mesh, views[i], edge, backdrop); });
  mesh.colours.assign(mesh.positions.size(), Colour{128, 128, 128});
  std::vector<bool> known(mesh.positions.size(), false);
  for (std::size_t v = 0; v < known.size(); ++v) {
    float weight = 0.0F;
    cv::Vec3f sum;
    for (const auto& say : says) {
      weight += say.weight[v];
      sum += say.weight[v] * cv::Vec3f(say.colour[v]);
    }
    if (weight <= 0.0F) continue;
    known[v] = true;
    for (int c = 0; c < 3; ++c)
      mesh.colours[v][static_cast<std::size_t>(c)] = cv::saturate_cast<std::uint8_t>(sum[c] / weight);
  }
  spread(mesh, std::move(known));
}

}  // namespace rotunda::recon
