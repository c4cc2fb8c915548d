#pragma once
// The measures garments are cut to, in the reference frame of garment.h: a man of 1.75 m in the bind pose.
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>

#include "simulator/people/blend.h"
#include "simulator/people/garment.h"

namespace rotunda::simulator {

double ramp(double x, double from, double to);  // 0 up to `from`, 1 beyond `to`, smooth between

// A point against the arm of its side.
struct ArmPlace {
  double beyond;  // the plane that halves the armpit: positive on the arm
  double along;   // from the shoulder joint to the hand
};
ArmPlace arm_place(const Eigen::Vector3d& q);
// Metres along the cloth and across it, as it lies on a table: sleeves are rolled out, front and back are panels that
// meet at the side seam and run over the shoulders.
Eigen::Vector2d cloth_coordinates(const Eigen::Vector3d& q, const ArmPlace& arm);

inline constexpr double kThroat = 1.510;                  // height above which nothing is worn
inline constexpr double kElbow = 0.308, kWrist = 0.5635;  // `along`

// Hangs from the waist: an ellipse that widens from `top` to `hem`, with pleats, closed from below.
struct Bell {
  double top, hem;              // heights
  double depth_top, width_top;  // half axes there
  double depth_hem, width_hem;
  int pleats;
  double pleat_height;  // of a pleat at the hem, crest against middle
  double hollow;        // how far the middle of its underside lies above the hem
  double slit;          // half width of the opening in front at the hem; 0: closed
};
struct BellPlace {
  double down;                // 0 at the top, 1 at the hem
  double radius;              // against the bell's own at that angle and height: 1 on its outside
  double outside, underside;  // distances, to first order
};
BellPlace bell_place(const Bell& bell, double girth, std::uint32_t seed, const Eigen::Vector3d& q);

// What covers the trunk and arms: cut off at hem, cuff and collar.
struct Top {
  Garment garment;
  double hem;                      // height
  double hem_dip;                  // how much lower it is before and behind than at the sides
  double sleeve;                   // `along` of the cuff
  double neckline;                 // its radius about the neck
  double neckline_dip;             // lowest point of its V in front: a height
  double chest, waist, hip, cuff;  // how far it stands off the body there
  double opening;                  // half width of the open front at the hem; 0: closed
  double open_from;                // height above which the front is closed
};

double round_neck(const Top& top, const Eigen::Vector3d& q);  // positive within the neckline's circle
double neckline(const Top& top, const Eigen::Vector3d& q);    // and within the V in front

struct Cut {
  Top top;
  std::optional<Bell> bell;
  double trouser_leg;  // how far trousers stand off the leg at the ankle; 0: the legs are bare
  double instep;       // how far trousers reach before the ankle, over the shoe
};
const Cut& cut_of(Outfit outfit);

}  // namespace rotunda::simulator
