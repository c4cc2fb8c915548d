#pragma once
// What a camera remembers without power: its user sets (SFNC, "User Set Control"), which of them it starts with, and
// the name its owner gave it. Set 0 is the factory's and cannot be written.
#include <array>
#include <cstdint>
#include <optional>

#include "simulator/gige/device_registers.h"

namespace rotunda::simulator {

class UserSets {
 public:
  static constexpr std::uint32_t kSets = 3;  // Default, UserSet0, UserSet1

  explicit UserSets(DeviceRegisters::Settings factory) { sets_[0] = std::move(factory); }

  // False for a set that cannot be: the factory's, or none of these.
  bool save(std::uint32_t set, DeviceRegisters::Settings settings) {
    if (set == 0 || set >= kSets) return false;
    sets_[set] = std::move(settings);
    return true;
  }
  // Nothing for a set that was never saved.
  const std::optional<DeviceRegisters::Settings>& settings(std::uint32_t set) const {
    return sets_[set < kSets ? set : 0];
  }
  std::uint32_t at_power_up = 0;
  std::optional<std::array<std::uint32_t, 4>> user_name;  // words of the register, once somebody wrote it

 private:
  std::array<std::optional<DeviceRegisters::Settings>, kSets> sets_;
};

}  // namespace rotunda::simulator
