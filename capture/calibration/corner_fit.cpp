#include "capture/calibration/corner_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kSmallestRadius = 2.2;  // pixels from the corner to the window's nearest side: below, edges melt
constexpr double kLeastContrast = 0.02;  // linear light
constexpr int kIterations = 12;
constexpr double kConverged = 0.02;  // pixels: the next step is a tenth of the last, and noise does more than that

float to_linear(double s) {
  return static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

std::vector<float> linear_curve(std::size_t levels) {
  std::vector<float> curve(levels);
  for (std::size_t i = 0; i < levels; ++i)
    curve[i] = to_linear(static_cast<double>(i) / static_cast<double>(levels - 1));
  return curve;
}

// What is compared: pixels about the expected corner whose place on the board lies in the window.
struct Window {
  cv::Rect box;                   // in the picture
  std::vector<cv::Point> pixels;  // in the picture
  double half = 0.0;              // side of what is compared, metres on the board
};

Eigen::Vector2d through(const Eigen::Matrix3d& H, const Eigen::Vector2d& at) {
  return (H * at.homogeneous()).hnormalized();
}

// Pixels a metre along the board's x and y at the corner.
Eigen::Matrix2d jacobian_at(const Eigen::Matrix3d& H, const Eigen::Vector2d& at) {
  const Eigen::Vector3d p = H * at.homogeneous();
  Eigen::Matrix2d J;
  for (int c = 0; c < 2; ++c)
    for (int r = 0; r < 2; ++r) J(r, c) = (H(r, c) - p[r] / p.z() * H(2, c)) / p.z();
  return J;
}

// The distance from the middle of the parallelogram with these half sides to its nearer pair of sides.
double inner_radius(const Eigen::Matrix2d& half_sides) {
  return std::abs(half_sides.determinant()) / std::max(half_sides.col(0).norm(), half_sides.col(1).norm());
}

class CornerFitter {
 public:
  CornerFitter(const cv::Mat& linear, const BoardPrint& print, const Eigen::Vector2d& corner,
               const Eigen::Matrix3d& image_from_board, const CornerFitOptions& options)
      : linear_(linear), print_(print), corner_(corner), H_(image_from_board), options_(options) {}

  std::optional<CornerFit> fit();
  // After a fit: the correlation with another blur, the corner where it was found.
  double correlation_at(double blur_px);

 private:
  bool open_window();
  void render(const Eigen::Vector2d& shift, double blur_px);
  bool step(Eigen::Vector2d& shift, CornerFit& fit);

  const cv::Mat& linear_;
  const BoardPrint& print_;
  const Eigen::Vector2d corner_;
  const Eigen::Matrix3d H_;
  const CornerFitOptions& options_;
  Eigen::Vector2d expected_;
  Eigen::Vector2d shift_ = Eigen::Vector2d::Zero();
  Window window_;
  cv::Mat rendered_, dx_, dy_;  // CV_32FC1 over the window's box
};

bool CornerFitter::open_window() {
  expected_ = through(H_, corner_);
  const double square = print_.board().square;
  const Eigen::Matrix2d J = jacobian_at(H_, corner_);
  double half = options_.window * square;
  const double longest = std::max(J.col(0).norm(), J.col(1).norm()) * half;
  if (longest > options_.largest_radius) half *= options_.largest_radius / longest;
  if (!(inner_radius(J * half) >= kSmallestRadius) || !expected_.allFinite()) return false;
  const Eigen::Vector2d reach = J.cwiseAbs() * Eigen::Vector2d::Constant(half);
  const Eigen::Vector2i low = (expected_ - reach).array().floor().cast<int>() - 1,
                        high = (expected_ + reach).array().ceil().cast<int>() + 2;
  if (low.minCoeff() < 0 || high.x() > linear_.cols || high.y() > linear_.rows) return false;
  window_.box = {low.x(), low.y(), high.x() - low.x(), high.y() - low.y()};
  window_.half = half;
  const Eigen::Matrix2d board_from_pixels = J.inverse();
  for (int y = low.y() + 1; y < high.y() - 1; ++y)
    for (int x = low.x() + 1; x < high.x() - 1; ++x)
      if ((board_from_pixels * (Eigen::Vector2d(x, y) - expected_)).cwiseAbs().maxCoeff() <= half)
        window_.pixels.emplace_back(x, y);
  return window_.pixels.size() >= 16;
}

// The print as the camera would see it with the corner moved by `shift`: four boxes a pixel, each exact, then blurred.
// Only where the blur brings it into the window.
void CornerFitter::render(const Eigen::Vector2d& shift, double blur_px) {
  const int margin = static_cast<int>(std::ceil(3.0 * blur_px)) + 1;
  const cv::Rect box(window_.box.x - margin, window_.box.y - margin, window_.box.width + 2 * margin,
                     window_.box.height + 2 * margin);
  cv::Mat sharp = cv::Mat::zeros(box.size(), CV_32FC1);
  const Eigen::Matrix3d board_from_image = H_.inverse();
  const Eigen::Matrix2d J = jacobian_at(H_, corner_).inverse();
  const Eigen::Vector2d half = 0.25 * J.cwiseAbs().rowwise().sum();
  const Eigen::Array2d needed =
      window_.half + (margin + shift.norm() + 2.0) * J.rowwise().norm().array();  // from the corner, on the board
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const Eigen::Vector2d pixel = Eigen::Vector2d(box.x + x, box.y + y) - shift;
      const Eigen::Vector2d at = through(board_from_image, pixel);
      if (((at - corner_).array().abs() > needed).any()) continue;
      if (const auto colour = print_.plain(at.x(), at.y(), 2.0 * half.x(), 2.0 * half.y())) {
        sharp.at<float>(y, x) = static_cast<float>(*colour);
        continue;
      }
      double sum = 0.0;
      for (const double u : {-0.25, 0.25})
        for (const double v : {-0.25, 0.25}) {
          const Eigen::Vector2d sub = at + J * Eigen::Vector2d(u, v);
          sum += print_.mean(sub.x(), sub.y(), half.x(), half.y());
        }
      sharp.at<float>(y, x) = static_cast<float>(0.25 * sum);
    }
  cv::GaussianBlur(sharp, sharp, {2 * margin - 1, 2 * margin - 1}, blur_px);
  rendered_ = sharp(cv::Rect(margin, margin, window_.box.width, window_.box.height));
  cv::Sobel(rendered_, dx_, CV_32F, 1, 0, 1, 0.5);
  cv::Sobel(rendered_, dy_, CV_32F, 0, 1, 1, 0.5);
}

// One Gauss-Newton step of gain, offset, slope and shift; false where the window does not hold the print.
bool CornerFitter::step(Eigen::Vector2d& shift, CornerFit& fit) {
  render(shift, options_.blur_px);
  // Light first: picture = gain * print + offset + slope . (pixel - corner); then the shift beside it.
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6 right = Vector6::Zero();
  double sum = 0.0, squares = 0.0;
  for (const auto& pixel : window_.pixels) {
    const cv::Point in = pixel - window_.box.tl();
    Vector6 row;
    row << rendered_.at<float>(in), 1.0, pixel.x - expected_.x(), pixel.y - expected_.y(), -dx_.at<float>(in),
        -dy_.at<float>(in);
    const double value = linear_.at<float>(pixel);
    normal += row * row.transpose();
    right += value * row;
    sum += value;
    squares += value * value;
  }
  const Vector6 solved = normal.ldlt().solve(right);
  const double n = static_cast<double>(window_.pixels.size());
  const double residual = std::max(0.0, squares - solved.dot(right)), total = squares - sum * sum / n;
  fit.contrast = solved[0];
  if (!(fit.contrast >= kLeastContrast) || !(total > 0.0)) return false;
  fit.correlation = std::sqrt(std::max(0.0, 1.0 - residual / total));
  const Eigen::Matrix<double, 6, 6> inverse = normal.inverse();
  fit.deviation = std::sqrt(residual / (n - 6.0) * 0.5 * (inverse(4, 4) + inverse(5, 5))) / fit.contrast;
  const Eigen::Vector2d move = solved.tail<2>() / solved[0];
  shift += move.norm() > 1.0 ? Eigen::Vector2d(move.normalized()) : move;
  fit.pixel = expected_ + shift;
  return true;
}

std::optional<CornerFit> CornerFitter::fit() {
  if (!open_window()) return std::nullopt;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  CornerFit fit;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector2d before = shift;
    if (!step(shift, fit) || !shift.allFinite() || shift.norm() > options_.reach_px) return std::nullopt;
    if ((shift - before).norm() < kConverged) break;
  }
  if (fit.correlation < options_.least_correlation) return std::nullopt;
  shift_ = shift;
  return fit;
}

double CornerFitter::correlation_at(double blur_px) {
  render(shift_, blur_px);
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();  // of gain, offset and slope
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double sum = 0.0, squares = 0.0;
  for (const auto& pixel : window_.pixels) {
    const Eigen::Vector4d row(rendered_.at<float>(pixel - window_.box.tl()), 1.0, pixel.x - expected_.x(),
                              pixel.y - expected_.y());
    const double value = linear_.at<float>(pixel);
    normal += row * row.transpose();
    right += value * row;
    sum += value;
    squares += value * value;
  }
  const double residual = squares - normal.ldlt().solve(right).dot(right),
               total = squares - sum * sum / static_cast<double>(window_.pixels.size());
  return total > 0.0 ? std::sqrt(std::max(0.0, 1.0 - std::max(0.0, residual) / total)) : 0.0;
}

}  // namespace

cv::Mat linear_light(const cv::Mat& grey) {
  if (grey.type() != CV_8UC1 && grey.type() != CV_16UC1)
    throw InvalidInput("corners are found in grey pictures of 8 or 16 bits");
  static const std::vector<float> kEight = linear_curve(256), kSixteen = linear_curve(65536);
  const auto& curve = grey.type() == CV_8UC1 ? kEight : kSixteen;
  cv::Mat linear(grey.size(), CV_32FC1);
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x)
      linear.at<float>(y, x) =
          curve[grey.type() == CV_8UC1 ? grey.at<std::uint8_t>(y, x) : grey.at<std::uint16_t>(y, x)];
  return linear;
}

std::optional<CornerFit> fit_corner(const cv::Mat& linear, const BoardPrint& print, const Eigen::Vector2d& corner,
                                    const Eigen::Matrix3d& image_from_board, const CornerFitOptions& options) {
  return CornerFitter(linear, print, corner, image_from_board, options).fit();
}

std::vector<double> correlation_at_blurs(const cv::Mat& linear, const BoardPrint& print, const Eigen::Vector2d& corner,
                                         const Eigen::Matrix3d& image_from_board, const CornerFitOptions& options,
                                         std::span<const double> blurs_px) {
  std::vector<double> correlations;
  CornerFitter fitter(linear, print, corner, image_from_board, options);
  if (!fitter.fit()) return correlations;
  for (const double blur : blurs_px) correlations.push_back(fitter.correlation_at(blur));
  return correlations;
}

}  // namespace rotunda::capture
