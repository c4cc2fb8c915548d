#pragma once
// An animated scan for other programs. Metres, y up, as glTF has it.
//   skin   one .glb: the scan at rest, a joint a segment of the body with its weights (four a vertex), the motion as an
//          animation of the joints; small, and only nearly the surface: how nearly is reported
//   morph  one .glb: the scan, every frame a morph target; exact and large
//   pc2    OBJ.obj with the scan at rest (colours at the vertices, as Blender and MeshLab read them), and beside it
//          NAME.pc2: the positions of every frame (Blender's and 3ds Max's Mesh Cache)
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>

#include "recon/deform/scan_animation.h"

namespace rotunda::recon {

enum class AnimationFormat { skin, morph, pc2 };

struct AnimationExportOptions {
  AnimationFormat format = AnimationFormat::skin;
  std::filesystem::path output;  // .glb, .glb, .obj
  double frame_time = 0.04;      // seconds
  std::function<void(std::size_t done, std::size_t total)> progress;
  std::stop_token stop;
};

struct AnimationExportReport {
  std::size_t frames = 0, vertices = 0, triangles = 0;
  std::uintmax_t bytes = 0;
  double skin_rms = 0.0, skin_worst = 0.0;       // metres, of the skinned surface from the deformed one; skin only
  double drift = 0.0;                            // metres, the worst held vertex
  bool has_volume = false;                       // the scan is closed
  double least_volume = 1.0, most_volume = 1.0;  // then: of a frame's volume against the scan's
  double deform_s = 0.0;                         // wall, of all frames
};

// `poses`: animation.handle_poses(). Frames are deformed a batch at a time, so memory stays within that. Throws
// InvalidInput for more than the format can hold, std::system_error (also operation_canceled when stopped).
AnimationExportReport export_animation(ScanAnimation& animation, std::span<const HandlePose> poses,
                                       const AnimationExportOptions& options);

}  // namespace rotunda::recon
