#pragma once
// The light of the simulated studio: soft boxes round the stage, and the blue that walls and floor throw back.
// World frame, metres; linear light, in which white paper facing the lamps is about 0.9.
#include <Eigen/Core>

namespace rotunda::simulator {

// Light that falls on a surface point, red, green, blue. `openness`: how much of its surroundings it sees, 0 to 1.
Eigen::Vector3f irradiance(const Eigen::Vector3f& position, const Eigen::Vector3f& normal, float openness);

// Blue reflected towards the eye at grazing angles (Schlick 1994, dielectric): the factor of kWallGlow.
float grazing_reflection(const Eigen::Vector3f& normal, const Eigen::Vector3f& to_eye);
inline const Eigen::Vector3f kWallGlow{0.03F, 0.09F, 0.42F};

}  // namespace rotunda::simulator
