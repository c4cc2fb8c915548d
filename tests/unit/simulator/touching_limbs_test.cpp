// The surface of a person is a closed sphere in every pose, but the solid it encloses has handles where limbs touch:
// what a visual hull of the same moment must have too.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "simulator/people/act.h"
#include "simulator/people/person.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 0.010;  // between vertical lines through the body
constexpr int kStepsACell = 2;   // a cell of 20 mm is solid where any line in it is: closed fingers have no gaps

// Solid cells of the union of everything the surface encloses.
class SolidCells {
 public:
  explicit SolidCells(const recon::TriangleMesh& surface) {
    for (const auto& t : surface.triangles) cross(surface, t);
    for (auto& [line, crossings] : crossings_) fill(line, crossings);
  }

  // Handles of a connected solid without cavities: 1 - V + E - F + C of its closed cubes.
  int handles() const {
    std::set<std::array<int, 3>> parts;  // doubled coordinates: even a vertex's, odd a cell's middle
    for (const auto& cell : cells_)
      for (int i = 0; i < 27; ++i) parts.insert({2 * cell[0] + i % 3, 2 * cell[1] + i / 3 % 3, 2 * cell[2] + i / 9});
    int euler = 0;
    for (const auto& at : parts) {
      const int dimension = (at[0] & 1) + (at[1] & 1) + (at[2] & 1);
      euler += dimension % 2 == 0 ? 1 : -1;
    }
    return 1 - euler;
  }

 private:
  struct Crossing {
    double z;
    int sign;  // 1: into the solid, upwards
  };

  void cross(const recon::TriangleMesh& surface, const std::array<std::uint32_t, 3>& t) {
    // Lines lie beside round numbers: none meets an edge.
    const Vector3d off(0.3717 * kStep, 0.4243 * kStep, 0.0);
    std::array<Vector3d, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = surface.positions[t[i]].cast<double>() - off;
    const Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
    if (normal.z() == 0.0) return;
    const auto [low_x, high_x] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
    const auto [low_y, high_y] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
    for (int x = static_cast<int>(std::ceil(low_x / kStep)); x * kStep <= high_x; ++x)
      for (int y = static_cast<int>(std::ceil(low_y / kStep)); y * kStep <= high_y; ++y) {
        const Vector3d q(x * kStep, y * kStep, 0.0);
        bool within = true;
        for (std::size_t i = 0; i < 3 && within; ++i) {
          const Vector3d edge = p.at((i + 1) % 3) - p[i], to = q - p[i];
          within = (edge.x() * to.y() - edge.y() * to.x()) * normal.z() > 0.0;
        }
        if (!within) continue;
        const double z = p[0].z() - (normal.x() * (q.x() - p[0].x()) + normal.y() * (q.y() - p[0].y())) / normal.z();
        crossings_[{x, y}].push_back({z, normal.z() < 0.0 ? 1 : -1});
      }
  }

  void fill(const std::array<int, 2>& line, std::vector<Crossing>& crossings) {
    std::sort(crossings.begin(), crossings.end(), [](const auto& a, const auto& b) { return a.z < b.z; });
    const auto cell = [](int step) { return (step - (step < 0 ? kStepsACell - 1 : 0)) / kStepsACell; };
    int inside = 0;
    for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
      inside += crossings[i].sign;
      if (inside <= 0) continue;
      const double size = kStep * kStepsACell;
      for (int z = static_cast<int>(std::floor(crossings[i].z / size)); z * size < crossings[i + 1].z; ++z)
        cells_.push_back({cell(line[0]), cell(line[1]), z});
    }
  }

  std::map<std::array<int, 2>, std::vector<Crossing>> crossings_;
  std::vector<std::array<int, 3>> cells_;
};

TEST(TouchingLimbs, HandsOnHipsMakeTwoHandlesOfTheSolidAndNoneOfTheSurface) {
  PersonDescription description{"somebody", BodyBuild{}, Clothing{}};
  description.texels_per_edge = 2;
  description.coarseness = 1.4;
  const Person person = make_person(description);
  const auto surface_in = [&](const char* act, double share) {
    const Motion motion = motion_of(act, person.skeleton);
    return posed_mesh(person, motion.pose_at(share * motion.frames * kActStep));
  };
  for (const double moment : {0.0, 0.5}) {
    const auto surface = surface_in("hands-on-hips", moment);
    EXPECT_TRUE(recon::topology_of(surface).is_sphere());
    EXPECT_GE(SolidCells(surface).handles(), 2) << moment;
  }
  EXPECT_EQ(SolidCells(surface_in("a-pose", 0.0)).handles(), 0);
}

}  // namespace
}  // namespace rotunda::simulator
