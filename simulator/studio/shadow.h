#pragma once
// Who stands in whose light. Lamps are soft boxes of some size and the studio's walls and ceiling glow: all are taken
// as a set of directions, and each direction has a map of what it meets first (Williams 1978), so that many small hard
// shadows make one soft one and a pose shades itself. World frame, metres.
// Pure; the same result on any number of threads.
#include <Eigen/Core>
#include <array>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::simulator {

inline constexpr std::size_t kLamps = 5;

// How much of each lamp and of the surrounding glow reaches a point: 1 all, 0 none.
struct Visibility {
  std::array<float, kLamps> lamps{1.0F, 1.0F, 1.0F, 1.0F, 1.0F};
  float surroundings = 1.0F;
};

class ShadowMaps {
 public:
  explicit ShadowMaps(const std::vector<recon::TriangleMesh>& surfaces);
  // Of a point of a surface with this normal. The surface's own unevenness below two centimetres casts none.
  Visibility at(const Eigen::Vector3f& position, const Eigen::Vector3f& normal) const;

 private:
  struct Map {  // of one direction: per cell, how far towards the light the foremost surface lies
    Eigen::Vector3f right, up, towards;
    float from_right = 0.0F, from_up = 0.0F;
    int columns = 0, rows = 0;
    std::vector<float> foremost;
    float open(const Eigen::Vector3f& point) const;  // 0 to 1
  };
  static Map map_along(const Eigen::Vector3f& direction, const std::vector<recon::TriangleMesh>& surfaces);

  std::array<std::vector<Map>, kLamps> lamps_;
  std::vector<Map> surroundings_;
};

}  // namespace rotunda::simulator
