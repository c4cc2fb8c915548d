#include "recon/body/bvh.h"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <numbers>
#include <numeric>
#include <system_error>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

bool is_rotation(BvhChannel channel) {
  return channel >= BvhChannel::x_rotation;
}

int axis_of(BvhChannel channel) {
  return static_cast<int>(channel) % 3;
}

Isometry3d local_transform(const BvhJoint& joint, const double* values) {
  Isometry3d local = Isometry3d::Identity();
  local.translation() = joint.offset;
  for (std::size_t c = 0; values && c < joint.channels.size(); ++c) {
    const int axis = axis_of(joint.channels[c]);
    if (is_rotation(joint.channels[c]))
      local.rotate(Eigen::AngleAxisd(values[c] * std::numbers::pi / 180.0, Vector3d::Unit(axis)));
    else
      local.translation()[axis] = values[c];
  }
  return local;
}

std::vector<Isometry3d> transforms(const BvhMotion& motion, const double* values) {
  std::vector<Isometry3d> world_from_joint(motion.joints.size());
  for (std::size_t j = 0; j < motion.joints.size(); ++j) {
    const auto& joint = motion.joints[j];
    const auto local = local_transform(joint, values);
    world_from_joint[j] = joint.parent < 0 ? local : world_from_joint[static_cast<std::size_t>(joint.parent)] * local;
    if (values) values += joint.channels.size();
  }
  return world_from_joint;
}

// Depth first, as the file nests.
void put_joint(std::string& text, const BvhMotion& motion, std::size_t j, int depth) {
  const auto& joint = motion.joints[j];
  const std::string indent(2 * static_cast<std::size_t>(depth), ' ');
  if (joint.is_end_site)
    text += fmt::format("{0}End Site\n{0}{{\n", indent);
  else
    text += fmt::format("{0}{1} {2}\n{0}{{\n", indent, joint.parent < 0 ? "ROOT" : "JOINT", joint.name);
  text +=
      fmt::format("{}  OFFSET {:.6f} {:.6f} {:.6f}\n", indent, joint.offset.x(), joint.offset.y(), joint.offset.z());
  if (!joint.is_end_site) {
    text += fmt::format("{}  CHANNELS {}", indent, joint.channels.size());
    for (const auto channel : joint.channels)
      text += fmt::format(" {}", kBvhChannelNames[static_cast<std::size_t>(channel)]);
    text += '\n';
  }
  for (std::size_t child = j + 1; child < motion.joints.size(); ++child)
    if (motion.joints[child].parent == static_cast<int>(j)) put_joint(text, motion, child, depth + 1);
  text += indent + "}\n";
}

}  // namespace

std::size_t BvhMotion::channels() const {
  return std::accumulate(joints.begin(), joints.end(), std::size_t{0},
                         [](std::size_t sum, const BvhJoint& joint) { return sum + joint.channels.size(); });
}

BvhMotion read_bvh(const std::filesystem::path& file) {
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream || !std::filesystem::is_regular_file(file))
    throw std::system_error(errno != 0 ? errno : EINVAL, std::generic_category(), file.string() + ": cannot be opened");
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  return parse_bvh(text, file);
}

std::string bvh_text(const BvhMotion& motion) {
  const std::size_t width = motion.channels();
  if (motion.values.size() != motion.frames * width)
    throw InvalidInput(
        fmt::format("a motion of {} frames and {} channels has {} values", motion.frames, width, motion.values.size()));
  std::string text = "HIERARCHY\n";
  for (std::size_t j = 0; j < motion.joints.size(); ++j)
    if (motion.joints[j].parent < 0) put_joint(text, motion, j, 0);
  text += fmt::format("MOTION\nFrames: {}\nFrame Time: {:.9f}\n", motion.frames, motion.frame_time);
  for (std::size_t i = 0; i < motion.values.size(); ++i)
    text += fmt::format("{:.6f}{}", motion.values[i], (i + 1) % width == 0 ? '\n' : ' ');
  return text;
}

void write_bvh(const std::filesystem::path& file, const BvhMotion& motion) {
  const std::string text = bvh_text(motion);
  errno = 0;
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream.flush())
    throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), file.string() + ": cannot be written");
}

std::vector<Isometry3d> joint_transforms(const BvhMotion& motion, std::size_t frame) {
  return transforms(motion, motion.values.data() + frame * motion.channels());
}

std::vector<Isometry3d> zero_pose(const BvhMotion& motion) {
  return transforms(motion, nullptr);
}

}  // namespace rotunda::recon
