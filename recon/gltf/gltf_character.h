#pragma once
// Anyone's character as glTF 2.0 has it: nodes, skinned and rigid parts, pictures, clips. In the file's frame and
// unit: y up, metres and facing +z if the file keeps to the standard; gltf_performance.h sets it onto the stage.
#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recon/mesh/textured_mesh.h"

namespace rotunda::recon {

struct CharacterNode {
  std::string name;
  int parent = -1;  // an earlier node; -1: a root
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  std::optional<Eigen::Matrix4d> matrix;  // instead of the three above
  std::vector<float> morph_weights;       // at rest
};

struct CharacterSkin {
  std::vector<std::size_t> joints;            // nodes
  std::vector<Eigen::Matrix4d> inverse_bind;  // joint_from_part at rest, one a joint
};

struct JointInfluence {
  std::uint32_t joint = 0;  // of the skin
  float weight = 0.0F;
};
using Influences = std::array<JointInfluence, 8>;  // weights sum to 1

// A piece of surface of one material.
struct CharacterPart {
  std::size_t node = 0;
  int skin = -1;  // -1: moves with its node
  int material = -1;
  std::vector<Eigen::Vector3f> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::vector<Eigen::Vector3f>> morphs;  // displacements, one a target and vertex
  std::vector<Influences> influences;                // one a vertex, empty if rigid
  std::vector<Eigen::Vector2f> uv;                   // one a vertex or empty; (0, 0) is the picture's top left corner
  std::vector<Eigen::Vector4f> colours;              // one a vertex or empty; linear
};

enum class TrackPath : std::uint8_t { translation, rotation, scale, morph_weights };
enum class TrackInterpolation : std::uint8_t { linear, step, cubic_spline };
struct CharacterTrack {
  std::size_t node = 0;
  TrackPath path = TrackPath::translation;
  TrackInterpolation interpolation = TrackInterpolation::linear;
  std::size_t width = 3;      // numbers a key: quaternions x, y, z, w
  std::vector<float> times;   // seconds, rising
  std::vector<float> values;  // width a key; of a cubic spline in-tangent, value, out-tangent
};
struct CharacterClip {
  std::string name;
  double begin = 0.0, end = 0.0;  // seconds, of its keys
  std::vector<CharacterTrack> tracks;
};

struct GltfCharacter {
  std::filesystem::path file;
  std::vector<CharacterNode> nodes;  // parents first
  std::vector<CharacterSkin> skins;
  std::vector<CharacterPart> parts;
  std::vector<SurfaceMaterial> materials;
  std::vector<cv::Mat> pictures;  // CV_8UC3, sRGB, red first; empty ones no material names
  std::vector<CharacterClip> clips;
  std::vector<std::string> notes;  // what was left out, for the user

  // The clip of that name (any case if only one fits then). Throws InvalidInput with the names there are.
  const CharacterClip& clip(std::string_view name) const;
};

// The default scene of a .glb or .gltf with the files beside it. Throws std::system_error if it cannot be read,
// CorruptData naming the broken element (indices out of range, cyclic nodes, missing or cut buffers, NaN), InvalidInput
// for what is not supported (needed extensions, formats of pictures) or absurd in size, or has no surface.
GltfCharacter read_gltf_character(const std::filesystem::path& file);

// Where nodes are at a moment of a clip (nullptr: at rest), file_from_node; and their morph weights.
struct CharacterState {
  std::vector<Eigen::Matrix4d> file_from_node;
  std::vector<std::vector<float>> morph_weights;
};
CharacterState state_at(const GltfCharacter& character, const CharacterClip* clip, double seconds);

// The vertices of a part in the file's frame: morphed, then skinned (linear blend).
std::vector<Eigen::Vector3f> posed_positions(const GltfCharacter& character, const CharacterPart& part,
                                             const CharacterState& state);

}  // namespace rotunda::recon
