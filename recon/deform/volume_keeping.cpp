#include "recon/deform/volume_keeping.h"

#include <algorithm>

#include "recon/deform/lane_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "recon/deform/volume_keeping.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once a target
#include <hwy/highway.h>

#include "recon/deform/lane_vector-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rotunda::recon::HWY_NAMESPACE {

void AddCones(std::span<const ConeTriangle> triangles, const float* centres, const float* rows, float* volumes,
              float* gradients) {
  const D d;
  const std::size_t n = hn::Lanes(d), stride = 3 * n;
  const V sixth = hn::Set(d, 1.0F / 6.0F);
  for (const auto& t : triangles) {
    const V3 a = load(rows + t.row[0] * stride);
    const V3 area = cross(minus(load(rows + t.row[1] * stride), a), minus(load(rows + t.row[2] * stride), a));
    const V3 gradient{hn::Mul(area.x, sixth), hn::Mul(area.y, sixth), hn::Mul(area.z, sixth)};
    float* volume = volumes + t.joint * n;
    hn::Store(hn::Add(hn::Load(d, volume), dot(gradient, minus(a, load(centres + t.joint * stride)))), d, volume);
    for (const auto g : t.gradient) store(plus(load(gradients + g * stride), gradient), gradients + g * stride);
  }
}

void Bulge(std::span<const BulgeVertex> vertices, std::size_t joints, const float* missing, const float* gradients,
           float* slopes, float* rows) {
  const D d;
  const std::size_t n = hn::Lanes(d), stride = 3 * n;
  std::fill_n(slopes, joints * n, 0.0F);
  for (const auto& v : vertices) {
    const V3 g = load(gradients + v.gradient * stride);
    float* slope = slopes + v.joint * n;
    hn::Store(hn::MulAdd(hn::Set(d, v.scale), dot(g, g), hn::Load(d, slope)), d, slope);
  }
  for (std::size_t i = 0; i < joints * n; i += n)
    hn::Store(hn::Div(hn::Load(d, missing + i), hn::Max(hn::Load(d, slopes + i), hn::Set(d, 1e-12F))), d, slopes + i);
  for (const auto& v : vertices) {
    const V3 g = load(gradients + v.gradient * stride);
    const V s = hn::Mul(hn::Set(d, v.scale), hn::Load(d, slopes + v.joint * n));
    const V3 x = load(rows + v.row * stride);
    store({hn::MulAdd(s, g.x, x.x), hn::MulAdd(s, g.y, x.y), hn::MulAdd(s, g.z, x.z)}, rows + v.row * stride);
  }
}

}  // namespace rotunda::recon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace rotunda::recon {

HWY_EXPORT(AddCones);
HWY_EXPORT(Bulge);

void add_cones(std::span<const ConeTriangle> triangles, const float* centres, const float* rows, float* volumes,
               float* gradients) {
  HWY_DYNAMIC_DISPATCH(AddCones)(triangles, centres, rows, volumes, gradients);
}

void bulge(std::span<const BulgeVertex> vertices, std::size_t joints, const float* missing, const float* gradients,
           float* slopes, float* rows) {
  HWY_DYNAMIC_DISPATCH(Bulge)(vertices, joints, missing, gradients, slopes, rows);
}

}  // namespace rotunda::recon
#endif
