#pragma once
// A geometry video's frames for other programs: Blender, Unreal, Unity, browsers. Metres.
//   glb  one file: a mesh a frame, each with its colours, and an animation that shows one after the other (STEP, one
//   key
//        a frame); or, with `morph`, the first frame's mesh, every later frame a morph target. y up, as glTF has it.
//   obj  a folder: frame000012.obj, closed, with normals and texture, .mtl and .png beside it. World frame, z up.
//   ply  a folder: frame000012.ply, closed, with normals and colours at the vertices. World frame, z up.
//   vat  a folder: a vertex animation texture laid out as OpenVAT does: NAME.glb, NAME_vat.png, NAME_vnrm.png (16
//   bits),
//        NAME-remap_info.json, NAME_colour/frame000012.png; NAME is the folder's. y up.
// and geometry videos of other profiles, one file each:
//   master, float, stream  (geometry_video.h; *.avi: an AVI, with JSON and mean beside it); what is streamed is
//   filtered along time first (temporal_filter.h) paper                  the paper's AVI and, beside it, its JSON
//   (paper_video.h)
// Numbers in file names are the take's. Surfaces that were interpolated are written like the others and counted.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>

#include "recon/video/geometry_video.h"

namespace rotunda::recon {

enum class ClipFormat { glb, obj, ply, vat, master, float32, stream, paper };

struct ClipExportOptions {
  ClipFormat format = ClipFormat::glb;
  std::filesystem::path output;  // obj, ply, vat: the folder, made if it is not there; else the file
  int first_frame = 0;           // of the video, counted from 0 ...
  int end_frame = 0;             // ... half-open; 0: all
  int level = 0;                 // (2^level + 1)^2 samples; 0: the video's own
  double fps = 0.0;              // frames a second; 0: the video's own; else frames are made between its own
  bool morph = false;            // glb
  std::function<void(std::size_t done, std::size_t total)> progress;
  std::stop_token stop;
};

struct ClipExportReport {
  std::size_t frames = 0, interpolated = 0;
  std::size_t vertices = 0, triangles = 0;  // of one frame
  std::size_t files = 0;
  std::uintmax_t bytes = 0;
};

// Files take their names when they are whole. Throws InvalidInput (no such frames or level, more than the format can
// hold), what the reader throws, and std::system_error: a file cannot be written, or operation_canceled when stopped
// (whole files of a sequence stay).
ClipExportReport export_clip(GeometryVideoReader& video, const ClipExportOptions& options);

}  // namespace rotunda::recon
