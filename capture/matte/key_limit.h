#pragma once
// Who is performer, by ratios to the plate: shadow on the backdrop's paint takes more of the other colours than of its
// own, never less, so a pixel is performer where another channel has gained on the backdrop's own. In the dark that
// limit falls, for the channel alone that the paint throws back least of: light that reaches a deep shadow has met
// paint several times, and each time that channel lost most.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace rotunda::capture {

struct KeyChannels {
  int own = 2;   // the backdrop's
  int far = 0;   // that the paint throws back least of
  int near = 1;  // the third
};

// By ln of the own channel against the plate's: what ln of the far channel against its plate must lead it by.
struct KeyKnot {
  float brightness, lead;
};
// In the light, cloth stands far above 0.2 and shadow below 0.03. In the dark, hair and cloth lose their hue and come
// down to 0, where shadow has gone far below: it is filled with light off the paint.
inline constexpr std::array<KeyKnot, 4> kKeyKnots{{{-3.0F, -0.4F}, {-1.5F, -0.4F}, {-0.9F, -0.15F}, {-0.5F, 0.25F}}};

// What the near channel must lead by, however dark it is.
inline constexpr float kNearLead = 0.25F;

// Grey levels of the far channel, 0.2 % of white in linear light: what shows less of it is a hole in the light. Black
// leather shows five times as much; velvet in a fold does not, but there the performer is all around.
inline constexpr float kDarkest = 6.0F;

inline float key_limit(float brightness) {
  if (brightness <= kKeyKnots.front().brightness) return kKeyKnots.front().lead;
  for (std::size_t i = 1; i < kKeyKnots.size(); ++i)
    if (brightness < kKeyKnots[i].brightness) {
      const auto &a = kKeyKnots[i - 1], &b = kKeyKnots[i];
      return a.lead + (brightness - a.brightness) / (b.brightness - a.brightness) * (b.lead - a.lead);
    }
  return kKeyKnots.back().lead;
}

// `gain`: ln of a pixel's channels against the plate's. How far it leads the limit: above 0 it is performer.
template <class Gain>
float key_lead(const Gain& gain, const KeyChannels& channels) {
  const float own = gain[channels.own];
  return std::max(gain[channels.far] - own - key_limit(own), gain[channels.near] - own - kNearLead);
}

}  // namespace rotunda::capture
