#pragma once
// What a person wears, as solids laid over the body's: close cloth is the body's distance field less a thickness, cut
// at hem, cuff and collar; what hangs is a bell closed from below by a cone between the legs, so that body and clothes
// stay one closed surface without a handle. Folds are part of the solids where cloth gathers: elbow, waist, knee, hem.
// Reference frame: the person frame scaled to a height of 1.75 m. Metres, radians.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>

namespace rotunda::simulator {

// loose_shirt: open-cut over trousers; close_fit: T-shirt and jeans; dress: with a skirt that swings;
// coat: over trousers, to above the knee.
enum class Outfit : std::uint8_t { loose_shirt, close_fit, dress, coat };

// What covers a point of the surface; bare: nothing does, the body's own material shows.
enum class Garment : std::uint8_t { bare, shirt, tee, trousers, bodice, skirt, coat, undershirt, lining };

// Where a point of the cloth is, for its colour and its weights.
struct GarmentPlace {
  Garment garment = Garment::bare;
  double left_thigh = 0.0, right_thigh = 0.0;  // shares with which it hangs about the legs
};

class Garments {
 public:
  Garments(Outfit outfit, double girth, std::uint32_t seed);
  // The distance of the dressed body where the body's own is `body`.
  double distance(const Eigen::Vector3d& q, double body) const;
  // Of a point on the surface; constant time.
  GarmentPlace place_of(const Eigen::Vector3d& q) const;
  // How freely the cloth of a point on the surface moves: 0 close to the body, 1 hanging free.
  double looseness(const Eigen::Vector3d& q) const;
  double reach() const;  // half the extent across, metres
  Outfit outfit() const { return outfit_; }

 private:
  Outfit outfit_;
  double girth_;
  std::uint32_t seed_;
};

}  // namespace rotunda::simulator
