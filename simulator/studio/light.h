#pragma once
// The light of the simulated studio: soft boxes round the stage, and the blue that walls and floor throw back.
// World frame, metres; linear light, in which white paper facing the lamps is about 0.9.
#include <Eigen/Core>
#include <array>
#include <optional>

#include "simulator/studio/material.h"
#include "simulator/studio/shadow.h"

namespace rotunda::simulator {

struct Lamp {
  Eigen::Vector3f place;   // metres, world
  Eigen::Vector3f colour;  // irradiance of a surface that faces it from the middle of the stage
  float size;              // edge of the soft box, metres
};
const std::array<Lamp, kLamps>& lamps();

// Where a ray (of length 1) meets a lamp's soft box, which faces the stage, and whether from its front.
struct LampHit {
  double distance;
  bool from_front;
};
std::optional<LampHit> hit_lamp(const Lamp& lamp, const Eigen::Vector3d& eye, const Eigen::Vector3d& ray);

struct LitPoint {
  Eigen::Vector3f position, normal;
  float openness = 1.0F;  // how much of its nearest surroundings (folds, creases) it sees, 0 to 1
};
// What walls and floor throw back: the screen's colour, and what a grey studio as bright as the blue one would.
inline const Eigen::Vector3f kWallGlow{0.03F, 0.09F, 0.42F};
inline const Eigen::Vector3f kGreenGlow{0.05F, 0.37F, 0.08F};
inline const Eigen::Vector3f kGreyGlow = Eigen::Vector3f::Constant(0.101F);

// Light that falls on a surface point; `visibility`: what the figures leave of lamps and walls.
ArrivingLight arriving_light(const LitPoint& point, SurfaceMaterial material, const Visibility& visibility,
                             const Eigen::Vector3f& glow = kWallGlow);

// What of the lamps' and the walls' light reaches the floor where figures stand in it, 0 to 1.
float floor_light(const Eigen::Vector3f& position, const Visibility& visibility);

}  // namespace rotunda::simulator
