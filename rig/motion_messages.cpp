#include <algorithm>

#include "config/errors.h"
#include "rig/messages.h"

namespace rotunda::rig {
namespace {

using recon::kBodyJoints;

recon::LiveMotionState state_of(const std::string& name) {
  using enum recon::LiveMotionState;
  for (const auto state : {searching, tracked, recovered, lost})
    if (recon::to_string(state) == name) return state;
  throw InvalidInput("a live motion's state is unknown: " + name);
}

void check_sizes(const v1::MotionFrame& m) {
  const auto joints = static_cast<int>(kBodyJoints);
  if (m.measures_size() != static_cast<int>(recon::kBodyMeasures) || m.root_size() != 3 ||
      m.rotations_size() != 4 * joints || m.confidence_size() != joints || m.sigma_size() != joints)
    throw InvalidInput("a frame of live motion is not whole; are daemon and client of one version?");
}

recon::PoseFit fit_of(const v1::MotionFrame& m) {
  recon::PoseFit fit;
  fit.pose.root = {m.root(0), m.root(1), m.root(2)};
  for (int j = 0; j < static_cast<int>(kBodyJoints); ++j) {
    const Eigen::Quaterniond turn(m.rotations(4 * j), m.rotations(4 * j + 1), m.rotations(4 * j + 2),
                                  m.rotations(4 * j + 3));
    const auto at = static_cast<std::size_t>(j);
    fit.pose.rotation[at] = turn.normalized();
    fit.confidence[at] = m.confidence(j);
    fit.sigma[at] = m.sigma(j);
  }
  return fit;
}

}  // namespace

MotionFrame from_message(const v1::MotionFrame& m) {
  MotionFrame frame;
  frame.trigger = m.trigger();
  frame.exposure = capture::Timestamp(std::chrono::nanoseconds(m.exposure_ns()));
  frame.made = capture::Timestamp(std::chrono::nanoseconds(m.made_ns()));
  frame.motion.state = state_of(m.state());
  frame.motion.why = m.why();
  if (m.measures_size() == 0) return frame;
  check_sizes(m);
  recon::BodyMeasures measures{};
  std::copy(m.measures().begin(), m.measures().end(), measures.begin());
  frame.motion.body = recon::make_template(measures);
  frame.motion.fit = fit_of(m);
  return frame;
}

v1::MotionFrame to_message(const MotionFrame& frame) {
  v1::MotionFrame m;
  m.set_trigger(frame.trigger);
  m.set_exposure_ns(frame.exposure.time_since_epoch().count());
  m.set_made_ns(frame.made.time_since_epoch().count());
  m.set_state(std::string(recon::to_string(frame.motion.state)));
  m.set_why(frame.motion.why);
  if (!frame.motion.body) return m;
  for (const double measure : frame.motion.body->measures) m.add_measures(measure);
  const auto& fit = frame.motion.fit;
  for (Eigen::Index i = 0; i < 3; ++i) m.add_root(fit.pose.root[i]);
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const auto& turn = fit.pose.rotation[j];
    for (const double part : {turn.w(), turn.x(), turn.y(), turn.z()}) m.add_rotations(part);
    m.add_confidence(fit.confidence[j]);
    m.add_sigma(fit.sigma[j]);
  }
  return m;
}

}  // namespace rotunda::rig
