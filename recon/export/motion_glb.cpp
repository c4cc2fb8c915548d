#include "recon/export/motion_glb.h"

#include <cmath>

#include "config/errors.h"
#include "recon/export/glb_file.h"

namespace rotunda::recon {
namespace {

using nlohmann::json;

// Node 0 turns z up to y up; joint j is node j + 1.
constexpr std::size_t node_of(std::size_t joint) {
  return joint + 1;
}

void add_nodes(GlbFile& glb, const Skeleton& skeleton) {
  const double half = std::sqrt(0.5);
  glb.json["nodes"].push_back({{"name", "motion"}, {"rotation", {-half, 0.0, 0.0, half}}, {"children", {1}}});
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const auto& offset = skeleton.offset[j];
    glb.json["nodes"].push_back(
        {{"name", to_string(body_joint(j))}, {"translation", {offset.x(), offset.y(), offset.z()}}});
    if (const auto parent = parent_of(body_joint(j)))
      glb.json["nodes"][node_of(index(*parent))]["children"].push_back(node_of(j));
  }
  glb.json["scenes"][0]["nodes"] = {0};
  glb.json["scene"] = 0;
}

void add_segments(GlbFile& glb, const BodyTemplate& body) {
  std::vector<std::uint32_t> indices;
  for (const auto& t : segment_triangles()) indices.insert(indices.end(), t.begin(), t.end());
  const auto triangles = glb.add_indices(indices);
  for (std::size_t s = 0; s < kBodySegments; ++s) {
    TriangleMesh mesh;
    for (const auto& vertex : body.segments[s].vertices) mesh.positions.push_back(vertex.cast<float>());
    mesh.triangles = segment_triangles();
    compute_normals(mesh);
    const json attributes{{"POSITION", glb.add_positions(mesh.positions)}, {"NORMAL", glb.add_normals(mesh.normals)}};
    const auto joint = joint_of_segment(s);
    glb.json["meshes"].push_back(
        {{"name", to_string(joint)}, {"primitives", {{{"attributes", attributes}, {"indices", triangles}}}}});
    glb.json["nodes"][node_of(index(joint))]["mesh"] = s;
  }
}

void add_channel(json& animation, std::size_t times, std::size_t values, std::size_t node, const char* path) {
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
  animation["samplers"].push_back({{"input", times}, {"output", values}, {"interpolation", "LINEAR"}});
}

// Of one joint over all frames; neighbours on the same side of the quaternions' sphere, so that players take the short
// way.
std::vector<Eigen::Vector4f> rotations_of(const CapturedMotion& motion, std::size_t joint) {
  std::vector<Eigen::Vector4f> rotations;
  for (const auto& frame : motion.frames) {
    Eigen::Vector4f next = frame.fit.pose.rotation[joint].coeffs().cast<float>();
    if (!rotations.empty() && next.dot(rotations.back()) < 0.0F) next = -next;
    rotations.push_back(next);
  }
  return rotations;
}

void add_animation(GlbFile& glb, const CapturedMotion& motion) {
  std::vector<float> times;
  std::vector<Eigen::Vector3f> root;
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    times.push_back(static_cast<float>(static_cast<double>(i) / motion.fps));
    root.push_back(motion.frames[i].fit.pose.root.cast<float>());
  }
  json animation{{"name", "motion"}, {"samplers", json::array()}, {"channels", json::array()}};
  const auto input = glb.add_scalars(times);
  add_channel(animation, input, glb.add_values(root), node_of(0), "translation");
  for (std::size_t j = 0; j < kBodyJoints; ++j)
    add_channel(animation, input, glb.add_rotations(rotations_of(motion, j)), node_of(j), "rotation");
  glb.json["animations"].push_back(std::move(animation));
}

}  // namespace

void write_motion_glb(const std::filesystem::path& file, const CapturedMotion& motion) {
  if (motion.frames.empty()) throw InvalidInput("a motion without frames cannot be written");
  GlbFile glb;
  add_nodes(glb, motion.body.skeleton);
  add_segments(glb, motion.body);
  add_animation(glb, motion);
  glb.write(file);
}

}  // namespace rotunda::recon
