#pragma once
// Private to recon/export: a binary glTF 2.0 file as it grows: arrays go into one buffer, the JSON tells what they are.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

class GlbFile {
 public:
  GlbFile();

  // Each returns the new object's index.
  std::size_t add_positions(const std::vector<Eigen::Vector3f>& positions);  // with min and max
  std::size_t add_normals(const std::vector<Eigen::Vector3f>& normals);
  std::size_t add_values(const std::vector<Eigen::Vector3f>& values);        // of an animation
  std::size_t add_rotations(const std::vector<Eigen::Vector4f>& rotations);  // of an animation, x y z w
  std::size_t add_texture_coordinates(const std::vector<Eigen::Vector2f>& coordinates);
  std::size_t add_indices(const std::vector<std::uint32_t>& indices);
  std::size_t add_scalars(const std::vector<float>& scalars);   // with min and max
  std::size_t add_colours(const std::vector<Colour>& colours);  // of vertices; made linear light, as glTF has them
  std::size_t add_joints(const std::vector<std::array<std::uint8_t, 4>>& joints);
  std::size_t add_weights(const std::vector<Eigen::Vector4f>& weights);
  std::size_t add_matrices(const std::vector<Eigen::Matrix4f>& matrices);  // bind matrices of a skin
  std::size_t add_png(const std::vector<std::uint8_t>& png);               // an image

  // A material that shows an image as it is, the light being in it already.
  std::size_t add_unlit_material(std::size_t image);

  // One that is as bright as its vertices' colours say, without a light.
  std::size_t add_plain_material();

  nlohmann::json json;

  // Throws InvalidInput beyond 4 GB, which is all the format can hold, and std::system_error.
  void write(const std::filesystem::path& file) const;

 private:
  enum Target : int { kNone = 0, kVertices = 34962, kIndices = 34963 };
  std::size_t add_view(const void* bytes, std::size_t size, Target target);
  std::size_t add_accessor(std::size_t view, int component_type, const char* type, std::size_t count);

  std::string binary_;
};

}  // namespace rotunda::recon
