#pragma once
// Anyone's glTF character in one of its clips. It stands on the floor, its clip centred on the stage, facing +x; a file
// in centimetres, inches or millimetres, or lying on its side, is told by the size and the names of its joints and set
// right. A clip whose end meets its beginning is stretched by less than half an act frame so that it closes exactly.
#include "recon/body/joint_names.h"
#include "recon/gltf/gltf_character.h"
#include "simulator/people/performance.h"

namespace rotunda::simulator {

class GltfPerformance : public Performance {
 public:
  // Throws as recon::read_gltf_character; InvalidInput for a clip that is not there, with those that are. A character
  // without clips gives one frame, whatever the act; so does an empty act.
  GltfPerformance(const std::filesystem::path& file, const std::string& act);

  const std::string& person() const override { return person_; }
  const std::string& act() const override { return act_; }
  int frames() const override { return frames_; }
  bool is_cyclic() const override { return is_cyclic_; }
  const std::vector<Figure>& figures() const override { return figures_; }
  std::vector<recon::TriangleMesh> surfaces_at(double seconds) const override;
  const std::vector<JointInfo>& joints() const override { return joints_; }
  std::vector<JointState> joints_at(double seconds) const override;
  std::vector<HeelStrike> heel_strikes() const override;  // footfall.h; none if names tell no feet
  std::string fingerprint() const override;

  const std::vector<std::string>& notes() const { return notes_; }  // what was changed or left out, for the user

 private:
  double clip_seconds(double seconds) const;
  recon::CharacterState state_at(double seconds) const;
  std::vector<Eigen::Vector3f> in_file(const recon::CharacterState& state) const;  // all vertices of all parts
  std::vector<std::optional<recon::NamedJoint>> named_joints() const;
  Eigen::Vector3d heel_in_foot(std::size_t joint) const;
  void time_clip();
  void collect_joints();
  void orient();
  void scale();
  void place();

  std::string person_, act_;
  recon::GltfCharacter character_;
  const recon::CharacterClip* clip_ = nullptr;  // of character_
  int frames_ = 1;
  bool is_cyclic_ = true;
  Eigen::Affine3d world_from_file_ = Eigen::Affine3d::Identity();
  std::vector<Figure> figures_;
  std::vector<std::uint32_t> source_;  // of each vertex of the figure among all vertices
  std::vector<std::size_t> joint_nodes_;
  std::vector<JointInfo> joints_;
  std::vector<std::string> notes_;
};

}  // namespace rotunda::simulator
