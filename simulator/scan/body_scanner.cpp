#include "simulator/scan/body_scanner.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "recon/colour/visibility.h"
#include "simulator/people/solid_noise.h"
#include "simulator/studio/camera_layout.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kViewpoints = 7;  // of a column
constexpr double kDistance = 1.3;       // of a column from the booth's middle, metres
constexpr double kLowest = 0.2, kSpacing = 0.3;
constexpr int kDepthPixels = 1024;        // across a viewpoint's picture: 1.8 mm each at the person
constexpr double kHalfField = 35.0;       // degrees
constexpr double kLeastCosine = 0.25;     // flatter than 14 degrees gives no measurement
constexpr double kWeakReturn = 0.006;     // of the light: what a dark or slanted surface must send back at least
constexpr double kReturnPatches = 0.012;  // metres, size of what gets lost together

struct Viewpoint {
  capture::CameraModel camera;
  recon::DepthMap seen;
};

Vector3d middle_of(const recon::TriangleMesh& surface) {
  Eigen::AlignedBox3d box;
  for (const auto& p : surface.positions) box.extend(p.cast<double>());
  return box.center();
}

using Column = std::array<Viewpoint, kViewpoints>;

Column make_column(const recon::TriangleMesh& surface, std::size_t number) {
  const double azimuth = (static_cast<double>(number) + 0.5) * 2.0 * std::numbers::pi / kScannerColumns;
  const double focal = 0.5 * kDepthPixels / std::tan(kHalfField * std::numbers::pi / 180.0);
  const Vector3d middle = middle_of(surface);
  Column column;
  tbb::parallel_for(std::size_t{0}, kViewpoints, [&](std::size_t i) {
    const Vector3d axis(middle.x(), middle.y(), kLowest + kSpacing * static_cast<double>(i));
    const Vector3d eye = axis + kDistance * Vector3d(std::cos(azimuth), std::sin(azimuth), 0.0);
    column[i].camera = look_at(eye, axis, kDepthPixels, kDepthPixels, focal, focal);
    column[i].seen = recon::render_depth(surface, column[i].camera);
  });
  return column;
}

// The cosine of a sight that nothing interrupts; 0 otherwise.
double clear_cosine(const Viewpoint& viewpoint, const Vector3d& p, const Vector3d& normal) {
  const double cosine = normal.dot((viewpoint.camera.centre() - p).normalized());
  if (cosine < kLeastCosine) return 0.0;
  const auto pixel = capture::project(viewpoint.camera, p);
  if (!pixel) return 0.0;
  const cv::Mat& depth = viewpoint.seen.depth;
  const int x = static_cast<int>(std::lround(pixel->x())), y = static_cast<int>(std::lround(pixel->y()));
  if (x < 0 || y < 0 || x >= depth.cols || y >= depth.rows) return 0.0;
  const double here = viewpoint.camera.R.row(2).dot(p) + viewpoint.camera.t.z();
  const double slope = std::sqrt(1.0 - cosine * cosine) / cosine;  // how fast depth changes across a pixel
  return here <= depth.at<float>(y, x) + 0.002 * (1.0 + slope) ? cosine : 0.0;
}

Sighting sight(const Column& column, const Vector3d& p, const Vector3d& normal) {
  Sighting best;
  double below = clear_cosine(column[0], p, normal);
  for (std::size_t i = 1; i < kViewpoints; ++i) {
    const double here = clear_cosine(column[i], p, normal);
    if (std::min(below, here) > static_cast<double>(best.cosine)) {
      const Vector3d between = 0.5 * (column[i - 1].camera.centre() + column[i].camera.centre());
      best = {static_cast<float>(std::min(below, here)), (between - p).normalized().cast<float>(), true};
    }
    below = here;
  }
  if (best.measured) return best;
  const Vector3d level(column[0].camera.centre().x(), column[0].camera.centre().y(), p.z());
  best.towards = (level - p).normalized().cast<float>();
  best.cosine = static_cast<float>(normal.dot(best.towards.cast<double>()));
  return best;
}

// The share of light that comes back off a colour: what laser and camera work with.
double reflectance(const recon::Colour& colour) {
  const auto linear = [](std::uint8_t value) { return std::pow(value / 255.0, 2.2); };
  return 0.2126 * linear(colour[0]) + 0.7152 * linear(colour[1]) + 0.0722 * linear(colour[2]);
}

bool is_too_dark(const recon::Colour& colour, double cosine, const Vector3d& p, std::uint32_t seed) {
  const double asked = kWeakReturn * (1.0 + solid_noise(p / kReturnPatches, seed));
  return reflectance(colour) * cosine < asked;
}

}  // namespace

Sightings scanner_sightings(const recon::TriangleMesh& surface, std::uint32_t seed) {
  Sightings sightings(surface.positions.size());
  for (std::size_t c = 0; c < kScannerColumns; ++c) {
    const Column column = make_column(surface, c);
    tbb::parallel_for(std::size_t{0}, sightings.size(), [&](std::size_t v) {
      const Vector3d p = surface.positions[v].cast<double>();
      Sighting& here = sightings[v][c];
      here = sight(column, p, surface.normals[v].cast<double>());
      if (here.measured && !surface.colours.empty() && is_too_dark(surface.colours[v], here.cosine, p, seed))
        here.measured = false;
    });
  }
  return sightings;
}

}  // namespace rotunda::simulator
