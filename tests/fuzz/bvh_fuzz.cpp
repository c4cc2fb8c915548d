// Any text as a BVH file: read or refused; what is read has values for all its channels, is read the same again from
// its own text, and moves one of our people without leaving the numbers, or is refused as nobody's motion.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "config/errors.h"
#include "recon/body/bvh.h"
#include "simulator/people/bvh_motion.h"

namespace rotunda::simulator {
namespace {

void require(bool claim) {
  if (!claim) std::abort();
}

void put_on_a_person(const recon::BvhMotion& bvh) {
  static const Skeleton skeleton = make_skeleton(1.75);
  const auto imported = import_motion(bvh, "motion", skeleton);
  require(imported.motion.frames > 0);
  for (const double seconds : {0.0, 0.5 * bvh.duration(), bvh.duration()}) {
    const auto pose = imported.motion.pose_at(seconds);
    require(pose.pelvis.allFinite());
    for (const auto& rotation : pose.rotation) require(rotation.coeffs().allFinite());
  }
}

void run(std::string_view text) {
  try {
    const auto bvh = recon::parse_bvh(text);
    require(bvh.frames > 0 && bvh.values.size() == bvh.frames * bvh.channels());
    require(recon::parse_bvh(recon::bvh_text(bvh)).values.size() == bvh.values.size());
    if (bvh.frames <= 1000 && bvh.joints.size() <= 200) put_on_a_person(bvh);
  } catch (const CorruptData&) {
  } catch (const InvalidInput&) {
  }
}

}  // namespace
}  // namespace rotunda::simulator

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  rotunda::simulator::run({reinterpret_cast<const char*>(data), size});
  return 0;
}
