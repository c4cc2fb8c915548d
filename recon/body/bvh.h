#pragma once
// Motion capture as Biovision BVH files: a hierarchy of joints with offsets, and per frame the values of their
// channels. In the file's own unit and axes (mostly centimetres, y up): whoever uses a motion decides what they are.
// A joint's rotation is the product of its rotation channels in the order they are listed, R = R1 R2 R3 on column
// vectors. Position channels replace the joint's offset, on the root as on any other joint, as MotionBuilder, Blender
// and the LAFAN1 data set have it.
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace rotunda::recon {

enum class BvhChannel : std::uint8_t { x_position, y_position, z_position, x_rotation, y_rotation, z_rotation };
inline constexpr std::array<std::string_view, 6> kBvhChannelNames = {"Xposition", "Yposition", "Zposition",
                                                                     "Xrotation", "Yrotation", "Zrotation"};

struct BvhJoint {
  std::string name;  // as in the file; of an end site what the file calls it, mostly nothing
  int parent = -1;   // index, always before its children; -1: a root
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // from the parent's origin in the parent's frame, file's unit
  std::vector<BvhChannel> channels;
  bool is_end_site = false;
};

struct BvhMotion {
  std::vector<BvhJoint> joints;  // in the file's order, end sites too
  double frame_time = 0.0;       // seconds
  std::size_t frames = 0;
  std::vector<double> values;  // frames x channels, row by row; degrees and the file's unit

  std::size_t channels() const;
  double duration() const { return frames < 2 ? 0.0 : static_cast<double>(frames - 1) * frame_time; }
};

// Reads tabs, CRLF, exponents, any channel order, positions on any joint, several roots. What is cut, has too few or
// too many numbers, unknown channels, values that are not finite or absurd is refused: CorruptData with file and line.
// Throws std::system_error if the file cannot be read.
BvhMotion read_bvh(const std::filesystem::path& file);
BvhMotion parse_bvh(std::string_view text, const std::filesystem::path& file = "motion.bvh");  // `file` for messages

// Throws std::system_error; InvalidInput for a motion whose values do not fit its joints.
void write_bvh(const std::filesystem::path& file, const BvhMotion& motion);
std::string bvh_text(const BvhMotion& motion);

// Where every joint is in the file's world: at a frame, and with all rotations zero (position channels: the offset).
std::vector<Eigen::Isometry3d> joint_transforms(const BvhMotion& motion, std::size_t frame);
std::vector<Eigen::Isometry3d> zero_pose(const BvhMotion& motion);

}  // namespace rotunda::recon
