#include "recon/hull/camera_agreement.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "config/errors.h"
#include "config/median.h"
#include "recon/hull/epipolar_tangents.h"

namespace rotunda::recon {
namespace {

using capture::CameraModel;
using Parameters = Eigen::Vector4d;  // turn about x, y, z (radians), how far the outline lies outside (pixels)

constexpr std::size_t kFewestOthers = 3;  // with two a moved camera cannot be told from its partner
constexpr int kFewestTangents = 12;       // three unknowns, and some that are wrong
constexpr double kTold = 1.5;             // pixels: calibration leaves half of one, mattes as much
constexpr double kStill = 4.0;         // pixels: a performer whose outlines are touched at the same places all the time
constexpr double kToldStill = 10.0;    // pixels: what is wrong with a matte there is wrong in every frame
constexpr double kClearly = 4.0;       // standard deviations, of three unknowns together
constexpr double kCalibrated = 0.3;    // pixels that each camera of a good calibration is off by
constexpr double kLargestTurn = 0.05;  // radians sought, three degrees
constexpr double kLeastNoise = 0.15;   // pixels: what outlines are known to
constexpr double kOutlineError = 1.0;  // pixels that mattes may be too wide or too narrow
constexpr double kRejected = 3.0;      // of the noise's deviation
constexpr int kSteps = 3;              // of Gauss and Newton at each scale

Eigen::Matrix3d rotation(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
}

bool is_whole(const ConvexOutline& outline) {
  return !outline.is_cut && outline.corners.size() >= 3;
}

// What another camera says of where this one's outline must be touched.
struct Pair {
  std::size_t frame = 0, other = 0;
  Pencil pencil;
  Tangents theirs;
};

std::vector<Pair> pairs_of(std::size_t camera, std::span<const CameraModel> cameras,
                           std::span<const OutlinesOverTime> outlines) {
  std::vector<Pair> pairs;
  for (std::size_t frame = 0; frame < outlines[camera].size(); ++frame)
    for (std::size_t other = 0; other < cameras.size(); ++other) {
      if (other == camera || !is_whole(outlines[camera][frame]) || !is_whole(outlines[other][frame])) continue;
      if ((cameras[other].centre() - cameras[camera].centre()).norm() == 0.0) continue;
      Eigen::Vector2d middle = Eigen::Vector2d::Zero();
      for (const auto& corner : outlines[other][frame].corners)
        middle += corner / static_cast<double>(outlines[other][frame].corners.size());
      const auto pencil =
          pencil_of(cameras[camera], cameras[other], cameras[other].R.transpose() * middle.homogeneous());
      if (const auto theirs = tangents(cameras[other], outlines[other][frame], pencil))
        pairs.push_back({frame, other, pencil, *theirs});
    }
  return pairs;
}

// One tangent's disagreement, in pixels of either picture.
struct Row {
  double off = 0.0;
  Parameters slope = Parameters::Zero();
  std::size_t group = 0;         // the other camera, and which of the two tangents: they err alike
  double noise = kLeastNoise;    // of its group
  Eigen::Vector2d at{0.0, 0.0};  // where the outline is touched, ideal plane
};

void add_row(const Tangent& own, const Tangent& theirs, double side, double widened, std::size_t other,
             std::vector<Row>& rows) {
  const double noise = std::hypot(own.per_pixel, theirs.per_pixel);
  Row row{.off = (own.angle - side * own.per_pixel * widened - theirs.angle) / noise,
          .group = 2 * other + (side > 0.0 ? 1 : 0),
          .at = own.at};
  row.slope << own.per_turn / noise, -side * own.per_pixel / noise;
  rows.push_back(row);
}

std::vector<Row> rows_of(const CameraModel& camera, const OutlinesOverTime& outlines, std::span<const Pair> pairs,
                         double widened) {
  std::vector<Row> rows;
  for (const auto& pair : pairs) {
    const auto own = tangents(camera, outlines[pair.frame], pair.pencil);
    if (!own) continue;
    add_row(own->lowest, pair.theirs.lowest, -1.0, widened, pair.other, rows);
    add_row(own->highest, pair.theirs.highest, 1.0, widened, pair.other, rows);
  }
  return rows;
}

constexpr double kDeviationOfMedian = 1.4826;  // normal distribution's, from the median of sizes

// Robust standard deviation of what is off, in the rows' own noise.
double noise_of(const std::vector<Row>& rows) {
  std::vector<double> sizes;
  for (const auto& row : rows) sizes.push_back(std::abs(row.off) / row.noise);
  return kDeviationOfMedian * median(std::move(sizes));
}

// How far the performer's outline moves while it is looked at, pixels: of each group the places' deviation, their
// median.
double travel_of(const std::vector<Row>& rows, double focal) {
  std::map<std::size_t, std::vector<Eigen::Vector2d>> groups;
  for (const auto& row : rows) groups[row.group].push_back(row.at);
  std::vector<double> travels;
  for (const auto& [group, places] : groups) {
    const auto count = static_cast<double>(places.size());
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const auto& place : places) middle += place / count;
    double squares = 0.0;
    for (const auto& place : places) squares += (place - middle).squaredNorm();
    travels.push_back(focal * std::sqrt(squares / count));
  }
  return median(std::move(travels));
}

// Tangents at a head agree to hundredths of a pixel, those at feet with their shadows change from frame to frame.
void measure_groups(std::vector<Row>& rows) {
  std::map<std::size_t, std::vector<double>> groups;
  for (const auto& row : rows) groups[row.group].push_back(row.off);
  std::map<std::size_t, double> noise;
  for (auto& [group, offs] : groups) {
    const double middle = median(offs);
    for (auto& off : offs) off = std::abs(off - middle);
    noise[group] = std::hypot(kLeastNoise, kDeviationOfMedian * median(offs));
  }
  for (auto& row : rows) row.noise = noise[row.group];
}

double weight_of(const Row& row, double scale) {  // Geman, McClure 1985; `scale` in the row's noise
  const double ratio = row.off / (row.noise * scale), beside = 1.0 + ratio * ratio;
  return 1.0 / (beside * beside * row.noise * row.noise);
}

Eigen::DiagonalMatrix<double, 4> prior() {
  constexpr double kTurn = 1.0 / (kLargestTurn * kLargestTurn);
  return Eigen::DiagonalMatrix<double, 4>(kTurn, kTurn, kTurn, 1.0 / (kOutlineError * kOutlineError));
}

struct Fit {
  Parameters at = Parameters::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of the turn
  int tangents = 0;
  double travel_px = 0.0;
};

CameraModel turned_by(CameraModel camera, const Eigen::Vector3d& turn) {
  camera.R = Eigen::Matrix3d(rotation(turn) * camera.R);
  camera.t = Eigen::Vector3d(rotation(turn) * camera.t);
  return camera;
}

// Turns are small: they add up to first order, and every step starts from the camera turned exactly.
void step(const std::vector<Row>& rows, double scale, Parameters& at) {
  Eigen::Matrix4d information = prior();
  Parameters pull = prior() * at;
  for (const auto& row : rows) {
    const double weight = weight_of(row, scale);
    information += weight * row.slope * row.slope.transpose();
    pull += weight * row.off * row.slope;
  }
  at -= information.ldlt().solve(pull);
}

// Tangents of a group err alike, frame after frame: the covariance counts groups, not tangents ("sandwich" over
// clusters, with the usual correction for few of them). And the calibration was never exact.
Eigen::Matrix3d covariance_of(const std::vector<Row>& rows, double scale, double focal) {
  Eigen::Matrix4d information = prior();
  struct Group {
    Parameters pull = Parameters::Zero(), slope = Parameters::Zero();
  };
  std::map<std::size_t, Group> groups;
  for (const auto& row : rows) {
    const double weight = weight_of(row, scale);
    information += weight * row.slope * row.slope.transpose();
    auto& group = groups[row.group];
    group.pull += weight * row.off * row.slope;
    group.slope += weight * row.slope;
  }
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
  for (const auto& [number, group] : groups)
    scatter += group.pull * group.pull.transpose() + kCalibrated * kCalibrated * group.slope * group.slope.transpose();
  const auto clusters = static_cast<double>(groups.size());
  const Eigen::Matrix4d inverse = information.inverse();
  const Eigen::Matrix4d covariance = inverse * (scatter * clusters / std::max(1.0, clusters - 4.0)) * inverse;
  const double own = kCalibrated / focal;
  return covariance.topLeftCorner<3, 3>() + own * own * Eigen::Matrix3d::Identity();
}

// From a scale that takes all in down to the noise (graduated non-convexity): a turn of degrees is found too.
std::optional<Fit> fit_turn(const CameraModel& camera, const OutlinesOverTime& outlines, std::span<const Pair> pairs) {
  Fit fit;
  const auto rows_now = [&] { return rows_of(turned_by(camera, fit.at.head<3>()), outlines, pairs, fit.at[3]); };
  std::vector<std::size_t> others;
  for (const auto& pair : pairs) others.push_back(pair.other);
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  if (others.size() < kFewestOthers) return std::nullopt;
  auto rows = rows_now();
  if (rows.size() < kFewestTangents) return std::nullopt;
  double scale = kLargestTurn * focal_px(camera) / kLeastNoise;
  for (bool finest = false; !finest; scale *= 0.5) {
    const double least = kRejected * noise_of(rows);
    if (scale <= least) scale = least, finest = true;
    for (int i = 0; i < kSteps; ++i) {
      step(rows, scale, fit.at);
      rows = rows_now();
    }
  }
  for (int i = 0; i < 2 * kSteps; ++i) {
    measure_groups(rows);
    step(rows, kRejected * std::max(1.0, noise_of(rows)), fit.at);
    rows = rows_now();
  }
  measure_groups(rows);
  const double last = kRejected * std::max(1.0, noise_of(rows));
  fit.covariance = covariance_of(rows, last, focal_px(camera));
  fit.travel_px = travel_of(rows, focal_px(camera));
  fit.tangents = static_cast<int>(
      std::count_if(rows.begin(), rows.end(), [&](const auto& row) { return std::abs(row.off) < last * row.noise; }));
  return fit.tangents < kFewestTangents ? std::nullopt : std::optional(fit);
}

// Where a turned camera shows what the calibrated one shows at `pixel`.
std::optional<Eigen::Vector2d> moved_pixel(const CameraModel& camera, const Eigen::Vector2d& pixel,
                                           const Eigen::Vector3d& turn) {
  const auto ideal = capture::undistort(camera, (camera.K.inverse() * pixel.homogeneous()).head<2>());
  if (!ideal) return std::nullopt;
  CameraModel eye = camera;
  eye.R = rotation(turn);
  eye.t.setZero();
  return capture::project(eye, ideal->homogeneous());
}

// Of the outlines: where the performer was seen.
std::vector<Eigen::Vector2d> places_of_performer(const CameraModel& camera, const OutlinesOverTime& outlines) {
  constexpr std::size_t kEvery = 8;
  std::vector<Eigen::Vector2d> places;
  std::size_t count = 0;
  for (const auto& outline : outlines)
    for (const auto& corner : outline.corners)
      if (is_whole(outline) && count++ % kEvery == 0)
        places.emplace_back((camera.K * capture::distort(camera, corner).homogeneous()).head<2>());
  return places;
}

CameraShift shift_of(const CameraModel& camera, const OutlinesOverTime& outlines, const Fit& fit) {
  CameraShift shift{.turn = fit.at.head<3>(), .tangents = fit.tangents};
  const Eigen::Vector2d middle(0.5 * (camera.width - 1.0), 0.5 * (camera.height - 1.0));
  if (const auto now = moved_pixel(camera, middle, shift.turn)) shift.at_middle = *now - middle;
  shift.roll_deg = shift.turn.z() * 180.0 / std::numbers::pi;
  double lengths = 0.0, variances = 0.0;
  int count = 0;
  for (const auto& place : places_of_performer(camera, outlines)) {
    const auto now = moved_pixel(camera, place, shift.turn);
    if (!now) continue;
    constexpr double kLittle = 1e-4;  // radians
    Eigen::Matrix<double, 2, 3> slope = Eigen::Matrix<double, 2, 3>::Zero();
    for (int axis = 0; axis < 3; ++axis)
      if (const auto near = moved_pixel(camera, place, shift.turn + kLittle * Eigen::Vector3d::Unit(axis)))
        slope.col(axis) = (*near - *now) / kLittle;
    lengths += (*now - place).norm();
    variances += (slope * fit.covariance * slope.transpose()).trace();
    ++count;
  }
  shift.shift_px = lengths / std::max(1, count);
  shift.deviation_px = std::sqrt(variances / std::max(1, count));
  const double clearly = shift.turn.dot(fit.covariance.ldlt().solve(shift.turn));
  shift.clearness = std::sqrt(std::max(0.0, clearly));
  shift.still = fit.travel_px < kStill;
  shift.moved = shift.shift_px > (shift.still ? kToldStill : kTold) && shift.clearness > kClearly;
  return shift;
}

std::optional<CameraShift> shift_among(std::size_t camera, std::span<const CameraModel> calibrated,
                                       std::vector<CameraModel> now, std::span<const OutlinesOverTime> outlines) {
  now[camera] = calibrated[camera];
  const auto fit = fit_turn(now[camera], outlines[camera], pairs_of(camera, now, outlines));
  return fit ? std::optional(shift_of(calibrated[camera], outlines[camera], *fit)) : std::nullopt;
}

double clearness(const std::optional<CameraShift>& shift) {
  return shift && shift->moved ? shift->clearness : 0.0;
}

}  // namespace

CameraModel turned(CameraModel camera, const CameraShift& shift) {
  return turned_by(std::move(camera), shift.turn);
}

// One after the other, the clearest first: a moved camera disturbs what its partners are told.
std::vector<std::optional<CameraShift>> camera_shifts(std::span<const CameraModel> cameras,
                                                      std::span<const OutlinesOverTime> outlines) {
  if (cameras.size() != outlines.size())
    throw InvalidInput(fmt::format("{} cameras, but outlines of {}", cameras.size(), outlines.size()));
  std::vector<std::optional<CameraShift>> shifts(cameras.size());
  std::vector<CameraModel> now(cameras.begin(), cameras.end());
  std::vector<bool> known(cameras.size(), false);
  for (std::size_t round = 0; round <= cameras.size(); ++round) {
    tbb::parallel_for(std::size_t{0}, cameras.size(),
                      [&](std::size_t i) { shifts[i] = shift_among(i, cameras, now, outlines); });
    for (std::size_t i = 0; i < cameras.size(); ++i)
      now[i] = known[i] && shifts[i] ? turned(cameras[i], *shifts[i]) : cameras[i];
    std::size_t clearest = cameras.size();
    for (std::size_t i = 0; i < cameras.size(); ++i)
      if (!known[i] && clearness(shifts[i]) > (clearest < cameras.size() ? clearness(shifts[clearest]) : 0.0))
        clearest = i;
    if (clearest == cameras.size()) break;
    known[clearest] = true;
    now[clearest] = turned(cameras[clearest], *shifts[clearest]);
  }
  return shifts;
}

}  // namespace rotunda::recon
