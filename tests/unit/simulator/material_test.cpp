#include "simulator/studio/material.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace rotunda::simulator {
namespace {

using Eigen::Vector3f;

constexpr std::array kAll{SurfaceMaterial::cloth, SurfaceMaterial::skin,   SurfaceMaterial::hair,
                          SurfaceMaterial::eye,   SurfaceMaterial::lip,    SurfaceMaterial::denim,
                          SurfaceMaterial::wool,  SurfaceMaterial::leather};

// Light spread past the terminator is taken from where it falls: the whole sphere gives pi, whatever the wrap.
TEST(Material, WrappedLightIsNoMoreThanFell) {
  for (const float wrap : {0.0F, 0.2F, 0.5F}) {
    double sum = 0.0;
    constexpr int kSteps = 4000;
    for (int i = 0; i < kSteps; ++i) {
      const double cosine = -1.0 + 2.0 * (i + 0.5) / kSteps;
      sum += 2.0 * std::numbers::pi * (2.0 / kSteps) *
             static_cast<double>(wrapped_cosine(static_cast<float>(cosine), Vector3f::Constant(wrap)).x());
    }
    EXPECT_NEAR(sum, std::numbers::pi, 0.01) << wrap;
  }
}

TEST(Material, SkinIsRedderPastTheTerminatorAndClothIsNot) {
  const auto behind = [](SurfaceMaterial material) { return wrapped_cosine(-0.05F, look_of(material).wrap); };
  const auto skin = behind(SurfaceMaterial::skin), cloth = behind(SurfaceMaterial::cloth);
  EXPECT_GT(skin.x(), 1.5F * skin.y());
  EXPECT_GT(skin.y(), skin.z());
  EXPECT_EQ(cloth.x(), cloth.z());
}

// The mirrored light of one lamp, over all directions it can leave in, in all.
TEST(Material, SurfacesMirrorLessThanFalls) {
  constexpr int kRings = 200, kSpokes = 200;
  for (const auto material : kAll)
    for (const double slant : {0.0, 0.7, 1.3}) {
      const Vector3f normal = Vector3f::UnitZ(),
                     to_lamp(static_cast<float>(std::sin(slant)), 0.0F, static_cast<float>(std::cos(slant)));
      double sum = 0.0;
      for (int ring = 0; ring < kRings; ++ring)
        for (int spoke = 0; spoke < kSpokes; ++spoke) {
          const double z = (ring + 0.5) / kRings, around = 2.0 * std::numbers::pi * spoke / kSpokes;
          const double across = std::sqrt(1.0 - z * z);
          const Vector3f to_eye =
              Eigen::Vector3d(across * std::cos(around), across * std::sin(around), z).cast<float>();
          const Vector3f half = (to_lamp + to_eye).normalized();
          const double seen =
              static_cast<double>(surface_reflection(look_of(material), normal.dot(half), to_lamp.dot(half)));
          sum += seen / std::numbers::pi * z * 2.0 * std::numbers::pi / (kRings * kSpokes);
        }
      EXPECT_LT(sum, 0.5) << static_cast<int>(material) << " at " << slant;
      if (slant == 0.0) {
        EXPECT_GT(sum, 0.004) << static_cast<int>(material);
      }
    }
}

// Kajiya and Kay: a highlight across the strands, narrow along them.
TEST(Material, HairShinesInABandAcrossTheStrands) {
  ArrivingLight light;
  light.lamps.fill(0.0F);
  light.lamps[0] = 1.0F;  // from the front, left and above
  const auto gloss_at = [&](float down) {
    const Vector3f normal = Vector3f(1.0F, 0.3F, -down).normalized();
    const Vector3f place = Vector3f(0.0F, 0.0F, 1.6F) + 0.1F * normal;
    return seen_light(SurfaceMaterial::hair, light, place, normal, Vector3f(1.0F, 0.2F, 0.1F).normalized()).gloss.x();
  };
  float brightest = 0.0F, dimmest = 1.0F;
  for (float down = -1.2F; down <= 1.2F; down += 0.05F) {
    brightest = std::max(brightest, gloss_at(down));
    dimmest = std::min(dimmest, gloss_at(down));
  }
  EXPECT_GT(brightest, 3.0F * dimmest);
}

}  // namespace
}  // namespace rotunda::simulator
