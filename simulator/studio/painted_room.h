#pragma once
// The empty studio as a place: a floor and a round wall that run into each other in a cove, painted blue by hand and
// walked on, lit by the lamps of light.h and by a ring of floods for the wall; above the wall's edge and about the
// lamps the dark studio. World frame, metres; linear light.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace rotunda::simulator {

enum class ScreenPaint { blue, green };

struct BackdropOptions {
  ScreenPaint paint = ScreenPaint::blue;
  double unevenness = 2.0;   // light on floor and wall, brightest to darkest; 1: perfectly even
  double wear = 1.0;         // seams, roller marks, scuffs, tape: 1 a studio in use, 0 none of them, 2 a worn one
  double gloss = 0.5;        // of the paint, the share that is not dead matt: lamps' hot spots on the floor
  double wall_radius = 6.2;  // metres; the wall steps back behind cameras that stand farther out
  double wall_height = 4.2;  // metres: wide cameras look past its edge
  std::uint32_t seed = 77;   // of everything random
};

class PaintedRoom {
 public:
  explicit PaintedRoom(const BackdropOptions& options);

  struct Seen {
    Eigen::Vector3f linear;
    bool is_floor = false;
    Eigen::Vector3d point;  // where the ray ends; world
  };
  // `ray`: of length 1; `pixel_angle`: radians between rays of neighbouring pixels, so that what is finer is a mean.
  Seen seen_along(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray, double pixel_angle) const;

 private:
  struct Spot {  // a place on floor or wall
    Eigen::Vector3d point, normal;
    double footprint = 0.0;  // of a pixel there, metres
    bool is_floor = false;
  };
  struct Scuff {
    Eigen::Vector2d from, to;
    double width, strength;
  };
  double lamp_light(const Spot& spot) const;  // before it is trimmed
  void trim_lamps();
  void scuff_floor();
  // Linear reflectances.
  Eigen::Vector3d floor_paint(const Spot& spot) const;
  Eigen::Vector3d wall_paint(const Spot& spot) const;
  Eigen::Vector3f shine(const Spot& spot, const Eigen::Vector3d& to_eye) const;
  Eigen::Vector3f painted(const Spot& spot, const Eigen::Vector3d& to_eye) const;

  BackdropOptions options_;
  double mean_light_ = 1.0, trim_ = 1.0;  // light = (lamp_light / mean)^trim
  std::vector<Scuff> scuffs_;
  std::vector<std::vector<std::size_t>> scuffs_near_;  // by cell of the walked floor
};

}  // namespace rotunda::simulator
