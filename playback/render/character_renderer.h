#pragma once
// Draws a character straight from the textures of its clips: the vertex shader fetches the positions of up to six
// layers, lays each over the floor and blends them; the fragment shader blends their colours (ALGORITHMS step 10).
// Positions are 16 bits over their clip's box, as stored. Needs a current GLES 3 context.
#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "playback/character_player.h"
#include "playback/render/lattice_drawing.h"
#include "playback/render/view_program.h"
#include "playback/viewpoint.h"
#include "recon/motion/motion_graph.h"
#include "recon/video/geometry_video.h"

namespace rotunda::playback {

inline constexpr std::size_t kMostLayers = 6;

class CharacterRenderer {
 public:
  // Opens the character's clips; frames are decoded when they are first drawn, or by load_all.
  // Throws what open_character throws, and DeviceError.
  CharacterRenderer(const std::filesystem::path& character, const recon::MotionGraph& graph);
  ~CharacterRenderer();

  int level() const;  // of detail, of all clips
  RootPaths roots() const;
  Eigen::AlignedBox3d box() const;  // of all clips about their roots: z is the height over the floor
  void load(std::size_t clip, int frame);
  // A frame that somebody else has read, in place and at the clips' own level.
  void adopt(std::size_t clip, int frame, const recon::GeometryImage& image);
  void load_all(const std::function<void(std::size_t done, std::size_t total)>& progress = {});
  std::size_t texture_bytes() const { return texture_bytes_; }  // resident, as asked of the driver

  // Into the bound framebuffer; `level` 0 is the clips' own, else coarser.
  void draw(const Appearance& appearance, const Viewpoint& viewpoint, const DrawOptions& options = {}, int level = 0);

 private:
  struct Clip;
  struct FrameTextures;
  struct DrawnLayer;
  std::vector<DrawnLayer> drawn_layers(const Appearance& appearance);
  void bind(const GlProgram& program, const std::vector<DrawnLayer>& layers, int drawn_level);

  std::vector<std::unique_ptr<Clip>> clips_;
  std::array<std::optional<ViewProgram>, kMostLayers> programs_;  // by how many layers they blend
  LatticeStrips strips_;
  std::size_t texture_bytes_ = 0;
  bool inside_out_ = false;
};

}  // namespace rotunda::playback
