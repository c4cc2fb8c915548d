#pragma once
// The parts of a body while they are put together: measures are of a man of 1.75 m in shoes and scale with the height.
// Private to body_parts.cpp and the files it calls.
#include <Eigen/Geometry>
#include <vector>

#include "simulator/people/body_shape.h"

namespace rotunda::simulator {

class PartList {
 public:
  PartList(const Skeleton& skeleton, const BodyBuild& build)
      : skeleton_(skeleton), build_(build), scale_(build.height / 1.75) {}

  // Ends in metres of this body, radii at 1.75 m.
  BodyPart& cone(Joint joint, Material material, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double ra,
                 double rb, double blend);
  // All at 1.75 m.
  BodyPart& ellipsoid(Joint joint, Material material, const Eigen::Vector3d& centre, const Eigen::Vector3d& radii,
                      double blend);
  BodyPart& add(const BodyPart& part) { return parts.emplace_back(part); }

  Eigen::Vector3d joint(Joint left, Side side) const { return skeleton_.joint[index(on_side(left, side))]; }
  double scale() const { return scale_; }
  const BodyBuild& build() const { return build_; }

  std::vector<BodyPart> parts;

 private:
  const Skeleton& skeleton_;
  const BodyBuild& build_;
  double scale_;
};

void add_head(PartList& body, const HeadFrame& frame);
void add_leg(PartList& body, Side side);
void add_shoe(PartList& body, Side side);
void add_arm(PartList& body, Side side);
void add_hand(PartList& body, Side side);

}  // namespace rotunda::simulator
