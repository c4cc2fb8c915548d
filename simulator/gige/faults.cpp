#include "simulator/gige/faults.h"

namespace rotunda::simulator {
namespace {

// SplitMix64 (Steele, Lea, Flood 2014).
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
  return x ^ (x >> 31);
}

}  // namespace

bool is_lost(const GigeFaults& faults, std::size_t camera, std::uint16_t block, std::uint32_t packet,
             std::uint64_t attempt) {
  if (faults.packet_loss <= 0.0) return false;
  const std::uint64_t where = static_cast<std::uint64_t>(block) << 32 | packet;
  const std::uint64_t drawn = mixed(mixed(mixed(mixed(faults.seed) ^ camera) ^ where) ^ attempt);
  return static_cast<double>(drawn >> 11) * 0x1.0p-53 < faults.packet_loss;
}

}  // namespace rotunda::simulator
