#pragma once
// Draws a GeometryImage straight from its textures: the vertex shader fetches the positions (ALGORITHMS step 10), the
// fragment shader the colours, bilinearly, at their own finer level. World frame, metres. Each level of detail is every
// 2^k-th sample, a closed surface of its own. Needs a current GLES 3 context; throws DeviceError if the driver refuses
// the shaders or the size.
#include <array>
#include <optional>

#include "playback/render/gl_objects.h"
#include "playback/render/lattice_drawing.h"
#include "playback/render/view_program.h"
#include "playback/viewpoint.h"
#include "recon/sphere/geometry_image.h"

namespace rotunda::playback {

class GeometryImageRenderer {
 public:
  GeometryImageRenderer();
  // Takes the image's place among three sets of textures, so that a frame still being drawn is not waited for.
  // Throws InvalidInput if positions or colours are not of the image's levels.
  void upload(const recon::GeometryImage& image);
  // Two frames of an aligned sequence, by their numbers, to be drawn `share` (0 to 1) of the way from one to the other.
  // A frame that is still there is not uploaded again. Throws InvalidInput also where their levels differ.
  struct Numbered {
    const recon::GeometryImage& image;
    int frame;
  };
  void upload_between(const Numbered& from, const Numbered& to, double share);
  // What was last uploaded, into the bound framebuffer; `level` 0 is its own, else coarser.
  void draw(const Viewpoint& viewpoint, const DrawOptions& options = {}, int level = 0);

 private:
  struct Slot {
    GlTexture positions, colours;
    int level = 0, colour_level = 0;  // 0: no storage yet
    std::optional<int> frame;         // none: of no sequence
    bool inside_out = false;          // the lattice's rows and columns turn the other way
    Eigen::AlignedBox3d box;
  };

  static constexpr std::size_t kSlots = 3;
  void fill(Slot& slot, const recon::GeometryImage& image);
  std::size_t slot_of(const Numbered& numbered, std::size_t taken);
  std::size_t free_slot(std::size_t taken) const;
  void bind(const GlProgram& program, const Slot& slot, GLint unit, const char* positions, const char* colours);

  ViewProgram program_, between_;
  std::array<Slot, kSlots> slots_;
  std::size_t current_ = 0, next_ = 0;
  float share_ = 0.0F;  // of the next one
  LatticeStrips strips_;
};

// Whether the lattice's rows and columns turn the other way: its front faces are clockwise.
bool turns_inwards(const recon::GeometryImage& image);

// One picture in one call, as render_mesh.
cv::Mat render_geometry_image(const recon::GeometryImage& image, const Viewpoint& viewpoint,
                              const DrawOptions& options = {},
                              const std::optional<recon::Colour>& background = std::nullopt);

}  // namespace rotunda::playback
