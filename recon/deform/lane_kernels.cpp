#include "recon/deform/lane_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "recon/deform/lane_kernels.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once a target
#include <hwy/highway.h>

#include "recon/deform/lane_vector-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rotunda::recon::HWY_NAMESPACE {

std::size_t Lanes() {
  return hn::Lanes(D());
}

// L y = b, supernode after supernode.
void Forward(const SparseFactor& factor, float* rows, std::size_t stride) {
  for (const auto& node : factor.supernodes) {
    const float* value = factor.values.data() + node.value_start;
    float* own = rows + node.first * stride;
    for (std::size_t r = 0; r < node.columns; ++r) {
      V3 sum = load(own + r * stride);
      for (std::size_t c = 0; c < r; ++c) sum = minus_scaled(sum, *value++, load(own + c * stride));
      store(scaled(sum, *value++), own + r * stride);
    }
    const std::uint32_t* below = factor.rows.data() + node.row_start;
    for (std::size_t r = 0; r < node.rows_below; ++r) {
      float* row = rows + below[r] * stride;
      V3 sum = load(row);
      for (std::size_t c = 0; c < node.columns; ++c) sum = minus_scaled(sum, *value++, load(own + c * stride));
      store(sum, row);
    }
  }
}

// L^T x = y, from the last supernode to the first.
void Backward(const SparseFactor& factor, float* rows, std::size_t stride) {
  for (auto at = factor.supernodes.rbegin(); at != factor.supernodes.rend(); ++at) {
    const auto& node = *at;
    float* own = rows + node.first * stride;
    const float* triangle = factor.values.data() + node.value_start;
    const float* value = triangle + node.columns * (node.columns + 1) / 2;
    const std::uint32_t* below = factor.rows.data() + node.row_start;
    for (std::size_t r = 0; r < node.rows_below; ++r) {
      const V3 known = load(rows + below[r] * stride);
      for (std::size_t c = 0; c < node.columns; ++c)
        store(minus_scaled(load(own + c * stride), *value++, known), own + c * stride);
    }
    for (std::size_t r = node.columns; r-- > 0;) {
      const float* line = triangle + r * (r + 1) / 2;
      const V3 solved = scaled(load(own + r * stride), line[r]);
      store(solved, own + r * stride);
      for (std::size_t c = 0; c < r; ++c)
        store(minus_scaled(load(own + c * stride), line[c], solved), own + c * stride);
    }
  }
}

void SolveLanes(const SparseFactor& factor, float* rows) {
  const std::size_t stride = 3 * Lanes();
  Forward(factor, rows, stride);
  Backward(factor, rows, stride);
}

// The rotation of a quaternion of any length.
struct Rotation {
  V m[9];
  HWY_INLINE explicit Rotation(V w, V x, V y, V z) {
    const D d;
    const V one = hn::Set(d, 1.0F);
    const V square = hn::MulAdd(w, w, hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))));
    const V s = hn::Div(hn::Set(d, 2.0F), hn::Max(square, hn::Set(d, 1e-20F)));
    const V sx = hn::Mul(s, x), sy = hn::Mul(s, y), sz = hn::Mul(s, z);
    const V xx = hn::Mul(sx, x), yy = hn::Mul(sy, y), zz = hn::Mul(sz, z);
    const V xy = hn::Mul(sx, y), xz = hn::Mul(sx, z), yz = hn::Mul(sy, z);
    const V wx = hn::Mul(sx, w), wy = hn::Mul(sy, w), wz = hn::Mul(sz, w);
    m[0] = hn::Sub(one, hn::Add(yy, zz));
    m[1] = hn::Sub(xy, wz);
    m[2] = hn::Add(xz, wy);
    m[3] = hn::Add(xy, wz);
    m[4] = hn::Sub(one, hn::Add(xx, zz));
    m[5] = hn::Sub(yz, wx);
    m[6] = hn::Sub(xz, wy);
    m[7] = hn::Add(yz, wx);
    m[8] = hn::Sub(one, hn::Add(xx, yy));
  }
  HWY_INLINE V3 operator*(const float v[3]) const {
    const D d;
    const V a = hn::Set(d, v[0]), b = hn::Set(d, v[1]), c = hn::Set(d, v[2]);
    const auto line = [&](int i) { return hn::MulAdd(m[i], a, hn::MulAdd(m[i + 1], b, hn::Mul(m[i + 2], c))); };
    return {line(0), line(3), line(6)};
  }
};

HWY_INLINE Rotation blended(std::span<const HandleShare> shares, const float* quaternions) {
  const D d;
  const std::size_t n = hn::Lanes(d);
  V w = hn::Zero(d), x = hn::Zero(d), y = hn::Zero(d), z = hn::Zero(d);
  for (const auto& share : shares) {
    const V weight = hn::Set(d, share.weight);
    const float* q = quaternions + share.handle * 4 * n;
    w = hn::MulAdd(weight, hn::Load(d, q), w);
    x = hn::MulAdd(weight, hn::Load(d, q + n), x);
    y = hn::MulAdd(weight, hn::Load(d, q + 2 * n), y);
    z = hn::MulAdd(weight, hn::Load(d, q + 3 * n), z);
  }
  return Rotation(w, x, y, z);
}

void AddFragments(std::span<const FragmentTriangle> triangles, std::span<const HandleShare> shares,
                  const float* quaternions, float* rows) {
  const std::size_t stride = 3 * Lanes();
  for (const auto& t : triangles) {
    const auto rotation = blended(shares.subspan(t.shares_begin, t.shares_end - t.shares_begin), quaternions);
    const V3 first = rotation * t.first, second = rotation * t.second;
    float* const at[3] = {rows + t.row[0] * stride, rows + t.row[1] * stride, rows + t.row[2] * stride};
    store(plus(load(at[0]), first), at[0]);
    store(plus(load(at[1]), second), at[1]);
    store(minus_scaled(load(at[2]), 1.0F, plus(first, second)), at[2]);
  }
}

void PlaceHeld(std::span<const HeldPlace> held, const float* transforms, float* rows) {
  const D d;
  const std::size_t n = hn::Lanes(d), stride = 3 * n;
  for (const auto& one : held) {
    const float* m = transforms + one.handle * 12 * n;
    const V x = hn::Set(d, one.rest[0]), y = hn::Set(d, one.rest[1]), z = hn::Set(d, one.rest[2]);
    const auto line = [&](std::size_t i) {
      const V head = hn::MulAdd(hn::Load(d, m + 4 * i * n), x, hn::Load(d, m + (4 * i + 3) * n));
      return hn::MulAdd(hn::Load(d, m + (4 * i + 1) * n), y, hn::MulAdd(hn::Load(d, m + (4 * i + 2) * n), z, head));
    };
    store({line(0), line(1), line(2)}, rows + one.row * stride);
  }
}

void AddLinks(std::span<const RowLink> links, float* rows) {
  const std::size_t stride = 3 * Lanes();
  for (const auto& link : links) {
    float* to = rows + link.to * stride;
    store(minus_scaled(load(to), -link.weight, load(rows + link.from * stride)), to);
  }
}

}  // namespace rotunda::recon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace rotunda::recon {

HWY_EXPORT(Lanes);
HWY_EXPORT(SolveLanes);
HWY_EXPORT(AddFragments);
HWY_EXPORT(PlaceHeld);
HWY_EXPORT(AddLinks);

std::size_t lane_count() {
  return HWY_DYNAMIC_DISPATCH(Lanes)();
}

void solve_lanes(const SparseFactor& factor, float* rows) {
  HWY_DYNAMIC_DISPATCH(SolveLanes)(factor, rows);
}

void add_fragments(std::span<const FragmentTriangle> triangles, std::span<const HandleShare> shares,
                   const float* quaternions, float* rows) {
  HWY_DYNAMIC_DISPATCH(AddFragments)(triangles, shares, quaternions, rows);
}

void place_held(std::span<const HeldPlace> held, const float* transforms, float* rows) {
  HWY_DYNAMIC_DISPATCH(PlaceHeld)(held, transforms, rows);
}

void add_links(std::span<const RowLink> links, float* rows) {
  HWY_DYNAMIC_DISPATCH(AddLinks)(links, rows);
}

}  // namespace rotunda::recon
#endif
