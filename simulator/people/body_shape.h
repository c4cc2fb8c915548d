#pragma once
// The clothed body as one implicit solid in the bind pose: limbs are round cones along the bones, the trunk a stack of
// ellipses, all joined smoothly (Bloomenthal and Shoemake, "Convolution surfaces", 1991, with the polynomial blend of
// Quilez). Person frame, metres.
#include <Eigen/Core>
#include <span>
#include <vector>

#include "simulator/people/garment.h"
#include "simulator/people/part_grid.h"
#include "simulator/people/skeleton.h"

namespace rotunda::simulator {

enum class Material : std::uint8_t { skin, hair, shirt, trousers, shoe, sole };

enum class Sex : std::uint8_t { male, female };
enum class HairStyle : std::uint8_t { bald, short_cut, bob, ponytail, bun };

// Features against the median of the sex: 1.
struct FaceBuild {
  double nose_width = 1.0, nose_length = 1.0, lips = 1.0, jaw = 1.0, brow = 1.0, cheeks = 1.0, eyes = 1.0;
  double beard = 0.0;  // thickness, metres
};

struct BodyBuild {
  double height = 1.75;      // metres, in shoes
  double girth = 1.0;        // thickness of trunk and limbs against the height
  double hair_volume = 1.0;  // thickness of the hair against a short cut
  std::uint32_t seed = 1;    // of folds and of everything patterned
  Sex sex = Sex::male;
  Proportions proportions = {};
  double waist = 1.0, bust = 1.0, limbs = 1.0;  // girths against those of the sex
  double belly = 0.0;                           // how far it stands out, metres
  double ease = 1.0;                            // how loosely sleeves and trousers hang; 0: tight on the limbs
  HairStyle hair = HairStyle::short_cut;
  FaceBuild face = {};
  Outfit outfit = Outfit::loose_shirt;
};

// A round cone from a to b, or an ellipsoid about a.
struct BodyPart {
  enum class Kind { cone, ellipsoid, trunk, scalp } kind = Kind::cone;
  Joint joint = Joint::pelvis;
  Material material = Material::skin;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::Zero();
  double radius_a = 0.0, radius_b = 0.0;
  Eigen::Vector3d radii = Eigen::Vector3d::Ones();     // of the ellipsoid, along its axes
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // of the ellipsoid, as rows
  Eigen::Vector3d across = Eigen::Vector3d::UnitX();   // the cone is flattened along this
  double flatness = 1.0;                               // extent along `across` against the radius
  double blend = 0.02;                                 // of the joint with what came before, metres
  bool open_end = false;                               // cut flat at b: a hem
  bool carve = false;                                  // taken away instead of joined
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    // ball that holds the part
  double reach = 0.0;
};

// Heads vary less than bodies: all heads are built on the one of a body of 1.75 m (the reference head: person frame of
// that body) and scaled about the joint that carries them.
struct HeadFrame {
  HeadFrame(const Skeleton& skeleton, const BodyBuild& build);
  Eigen::Vector3d to_reference(const Eigen::Vector3d& p) const { return reference_joint + (p - joint) / scale; }
  Eigen::Vector3d from_reference(const Eigen::Vector3d& q) const { return joint + (q - reference_joint) * scale; }
  Eigen::Vector3d joint, reference_joint;
  double scale;
};

// What a point of the surface belongs to, and where on that part it is.
struct BodyPlace {
  Material material = Material::skin;
  Joint joint = Joint::pelvis;
  double along = 0.0;      // metres from the part's start
  double to_end = 0.0;     // metres left to the end of its axis
  double around = 0.0;     // radians about the part's axis
  GarmentPlace worn = {};  // what covers it there
};

class BodyShape {
 public:
  BodyShape(const Skeleton& skeleton, const BodyBuild& build);
  double distance(const Eigen::Vector3d& p) const;  // negative inside; true to first order near the surface
  Eigen::Vector3d gradient(const Eigen::Vector3d& p) const;
  std::size_t nearest_part(const Eigen::Vector3d& p) const;
  BodyPlace place_on(std::size_t part, const Eigen::Vector3d& p) const;
  BodyPlace place_of(const Eigen::Vector3d& p) const { return place_on(nearest_part(p), p); }
  // How closed in a point of the surface is by the body itself: 1 open, 0 buried (Evans 2006: distance field sampled
  // along the normal).
  double openness(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) const;
  double bare_distance(const Eigen::Vector3d& p) const;  // of the body without its clothes
  double looseness(const Eigen::Vector3d& p) const;      // of the cloth at a point of the surface, 0 to 1
  double reach() const;                                  // half the extent of what hangs, metres
  const BodyBuild& build() const { return build_; }
  const HeadFrame& head() const { return head_; }

 private:
  class Probe;  // a point of space, asked for its distance from several parts
  double part_distance(const BodyPart& part, Probe& probe) const;
  double trunk_distance(const Eigen::Vector3d& p) const;
  double fold(const Eigen::Vector3d& p) const;
  double joined_distance(std::span<const std::uint16_t> parts, const Eigen::Vector3d& p) const;
  std::size_t nearest_of(std::span<const std::uint16_t> parts, const Eigen::Vector3d& p) const;
  std::vector<std::uint16_t> parts_that_matter(const Eigen::Vector3d& middle, double half_diagonal) const;

  BodyBuild build_;
  HeadFrame head_;
  Garments garments_;
  std::vector<BodyPart> parts_;
  std::vector<std::uint16_t> all_parts_;
  PartGrid grid_;
};

// The parts of a body, in the order in which they are joined.
std::vector<BodyPart> body_parts(const Skeleton& skeleton, const BodyBuild& build);

}  // namespace rotunda::simulator
