#include "capture/calibration/rig_drawing.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/calibration/html_page.h"

namespace rotunda::capture {
namespace {

const char* colour_of(Verdict verdict) {
  return verdict == Verdict::good ? "#2e8540" : verdict == Verdict::usable ? "#c77700" : "#c0392b";
}

// World to paper: right and up on the drawing, in metres.
Eigen::Matrix<double, 2, 3> axes_of(Side side) {
  Eigen::Matrix<double, 2, 3> axes;
  if (side == Side::above)
    axes << 1, 0, 0, 0, 1, 0;
  else if (side == Side::front)
    axes << 1, 0, 0, 0, 0, 1;
  else
    axes << 0, 1, 0, 0, 0, 1;
  return axes;
}

class RigDrawing {
 public:
  RigDrawing(const CalibrationResult& result, Side side, int width)
      : result_(result), axes_(axes_of(side)), side_(side), width_(width) {
    for (const auto& camera : result.cameras) box_.extend(axes_ * camera.centre());
    for (const auto& pose : result.poses) box_.extend(axes_ * pose.world_from_board.translation());
    box_.extend(Eigen::Vector2d::Zero());
    const double extent = std::max(box_.sizes().maxCoeff(), 0.1);
    pyramid_ = 0.07 * extent;
    box_.min().array() -= 0.12 * extent;
    box_.max().array() += 0.12 * extent;
    scale_ = width / box_.sizes().x();
    height_ = static_cast<int>(std::ceil(box_.sizes().y() * scale_));
  }

  std::string draw() {
    svg_ = fmt::format(
        "<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\">"
        "<rect width=\"{0}\" height=\"{1}\" fill=\"#fafbfc\"/>\n",
        width_, height_);
    grid();
    boards();
    ties();
    for (std::size_t i = 0; i < result_.cameras.size(); ++i) camera(i);
    names();
    return svg_ + "</svg>";
  }

 private:
  Eigen::Vector2d on_paper(const Eigen::Vector3d& world) const { return flat(axes_ * world); }
  Eigen::Vector2d flat(const Eigen::Vector2d& metres) const {
    return {(metres.x() - box_.min().x()) * scale_, (box_.max().y() - metres.y()) * scale_};
  }
  void line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const std::string& style) {
    svg_ += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>", a.x(), a.y(), b.x(),
                        b.y(), style);
  }

  // Lines a metre apart (or ten, or a tenth), the world's axes darker.
  void grid() {
    double step = 1.0;
    while (box_.sizes().x() / step > 20) step *= 10;
    while (box_.sizes().x() / step < 2) step /= 10;
    for (int axis = 0; axis < 2; ++axis)
      for (double at = std::ceil(box_.min()[axis] / step) * step; at <= box_.max()[axis]; at += step) {
        Eigen::Vector2d from = box_.min(), to = box_.max();
        from[axis] = to[axis] = at;
        line(flat(from), flat(to), std::abs(at) < step / 2 ? "stroke=\"#9aa4b0\"" : "stroke=\"#e3e6ea\"");
      }
    const char* right = side_ == Side::right ? "y" : "x";
    const char* up = side_ == Side::above ? "y" : "z";
    svg_ += fmt::format(
        "\n<text x=\"6\" y=\"{}\" font-size=\"11\" fill=\"#5a636e\">{} right, {} up; a square is {:g} m</text>\n",
        height_ - 6, right, up, step);
  }

  void boards() {
    for (const auto& pose : result_.poses) {
      const auto& board = result_.boards[pose.board];
      const double x = 0.5 * board.columns * board.square, y = 0.5 * board.rows * board.square;
      std::string points;
      for (const auto& corner : {Eigen::Vector3d(-x, y, 0), Eigen::Vector3d(x, y, 0), Eigen::Vector3d(x, -y, 0),
                                 Eigen::Vector3d(-x, -y, 0)}) {
        const Eigen::Vector2d at = on_paper(pose.world_from_board * corner);
        points += fmt::format("{:.1f},{:.1f} ", at.x(), at.y());
      }
      svg_ += fmt::format(
          "<polygon points=\"{}\" fill=\"#3b82c4\" fill-opacity=\".10\" stroke=\"#3b82c4\" "
          "stroke-opacity=\".45\" stroke-width=\".6\"/>",
          points);
    }
  }

  void ties() {
    int most = 1;
    for (const auto& tie : result_.ties) most = std::max(most, tie.moments);
    for (const auto& tie : result_.ties)
      line(on_paper(result_.cameras[tie.a].centre()), on_paper(result_.cameras[tie.b].centre()),
           fmt::format("stroke=\"#7a8694\" stroke-opacity=\".45\" stroke-width=\"{:.2f}\"",
                       0.3 + 2.2 * tie.moments / most));
  }

  // The pyramid over the picture's corners.
  void camera(std::size_t i) {
    const auto& camera = result_.cameras[i];
    const char* colour = i < result_.quality.size() ? colour_of(result_.quality[i].verdict) : "#1b1f24";
    const Eigen::Vector2d eye = on_paper(camera.centre());
    const Eigen::Matrix3d ray = camera.K.inverse();
    std::string points;
    for (const auto& pixel : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(camera.width, 0, 1),
                              Eigen::Vector3d(camera.width, camera.height, 1), Eigen::Vector3d(0, camera.height, 1)}) {
      const Eigen::Vector3d in_camera = pyramid_ * (ray * pixel);
      const Eigen::Vector2d at = on_paper(camera.centre() + camera.R.transpose() * in_camera);
      line(eye, at, fmt::format("stroke=\"{}\"", colour));
      points += fmt::format("{:.1f},{:.1f} ", at.x(), at.y());
    }
    svg_ += fmt::format("<polygon points=\"{}\" fill=\"{}\" fill-opacity=\".18\" stroke=\"{}\"/>\n", points, colour,
                        colour);
  }

  void names() {
    for (const auto& camera : result_.cameras) {
      const Eigen::Vector2d eye = on_paper(camera.centre());
      svg_ += fmt::format(
          "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"11\" fill=\"#1b1f24\" stroke=\"#fafbfc\" "
          "stroke-width=\"3\" paint-order=\"stroke\">{}</text>",
          eye.x() + 5, eye.y() - 6, html_escaped(camera.name));
    }
  }

  const CalibrationResult& result_;
  Eigen::Matrix<double, 2, 3> axes_;
  Side side_;
  int width_, height_ = 0;
  Eigen::AlignedBox2d box_;  // of the drawing, metres
  double scale_ = 1.0, pyramid_ = 0.1;
  std::string svg_;
};

}  // namespace

std::string draw_rig(const CalibrationResult& result, Side side, int width) {
  return RigDrawing(result, side, width).draw();
}

}  // namespace rotunda::capture
