// Private to the lane kernels, compiled for each kind of vector unit: three coordinates, a vector register each.
#if defined(ROTUNDA_LANE_VECTOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ROTUNDA_LANE_VECTOR_INL_H_
#undef ROTUNDA_LANE_VECTOR_INL_H_
#else
#define ROTUNDA_LANE_VECTOR_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace rotunda::recon::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

// Three coordinates of a vertex.
struct V3 {
  V x, y, z;
};
HWY_INLINE V3 load(const float* row) {
  const D d;
  const std::size_t n = hn::Lanes(d);
  return {hn::Load(d, row), hn::Load(d, row + n), hn::Load(d, row + 2 * n)};
}
HWY_INLINE void store(const V3& v, float* row) {
  const D d;
  const std::size_t n = hn::Lanes(d);
  hn::Store(v.x, d, row);
  hn::Store(v.y, d, row + n);
  hn::Store(v.z, d, row + 2 * n);
}
HWY_INLINE V3 minus_scaled(const V3& a, float scale, const V3& b) {
  const V s = hn::Set(D(), scale);
  return {hn::NegMulAdd(s, b.x, a.x), hn::NegMulAdd(s, b.y, a.y), hn::NegMulAdd(s, b.z, a.z)};
}
HWY_INLINE V3 scaled(const V3& a, float scale) {
  const V s = hn::Set(D(), scale);
  return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}
HWY_INLINE V3 plus(const V3& a, const V3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE V3 minus(const V3& a, const V3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE V3 cross(const V3& a, const V3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
HWY_INLINE V dot(const V3& a, const V3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

}  // namespace rotunda::recon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
