#include "simulator/people/act.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <string>

#include "config/errors.h"
#include "simulator/people/acts/acts.h"

namespace rotunda::simulator {
namespace {

// To add an act: a row here and the function that makes its motion, in acts/.
struct ActRow {
  std::string_view name;
  acts::MakeMotion* motion;
};
constexpr std::array<ActRow, 14> kActs = {{{"walk", acts::walk},
                                           {"jog", acts::jog},
                                           {"idle", acts::idle},
                                           {"a-pose", acts::a_pose},
                                           {"idle-walk", acts::idle_walk},
                                           {"walk-idle", acts::walk_idle},
                                           {"walk-jog", acts::walk_jog},
                                           {"jog-walk", acts::jog_walk},
                                           {"kick", acts::kick},
                                           {"turn", acts::turn},
                                           {"capoeira", acts::capoeira},
                                           {"dance", acts::dance},
                                           {"hands-on-hips", acts::hands_on_hips},
                                           {"board", acts::board}}};

}  // namespace

Motion motion_of(std::string_view act, const Skeleton& skeleton, const MotionOptions& options) {
  for (const auto& row : kActs)
    if (row.name == act) return row.motion(skeleton, options);
  throw InvalidInput(fmt::format("there is no act '{}'; the simulator knows: {}", act, fmt::join(act_names(), ", ")));
}

std::vector<std::string> act_names() {
  std::vector<std::string> names;
  for (const auto& row : kActs) names.emplace_back(row.name);
  return names;
}

}  // namespace rotunda::simulator
