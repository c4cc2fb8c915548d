#include "recon/motion/clip_shape.h"

#include <algorithm>

#include "recon/sphere/octahedral_lattice.h"

namespace rotunda::recon {
namespace {

// The samples of a coarser level: every 2^k-th.
template <class T>
std::vector<T> coarser(const std::vector<T>& fine, int level, int to) {
  const int side = lattice_side(level), stride = 1 << (level - to);
  std::vector<T> samples;
  samples.reserve(lattice_size(to));
  for (int y = 0; y < side; y += stride)
    for (int x = 0; x < side; x += stride) samples.push_back(fine[static_cast<std::size_t>(y * side + x)]);
  return samples;
}

void add(ClipShape& clip, const GeometryImage& image) {
  clip.frames.push_back(coarser(image.positions, image.level, clip.level));
  if (image.colour_level >= clip.level) clip.colours.push_back(coarser(image.colours, image.colour_level, clip.level));
}

void weigh(ClipShape& clip) {
  clip.areas.assign(lattice_size(clip.level), 0.0F);
  const auto welded = weld_lattice(clip.level);
  for (const auto& frame : clip.frames)
    for (const auto& triangle : welded.triangles) {
      const auto at = [&](std::size_t i) { return welded.sample_of_vertex[triangle[i]]; };
      const float area = (frame[at(1)] - frame[at(0)]).cross(frame[at(2)] - frame[at(0)]).norm() / 6.0F;
      for (std::size_t i = 0; i < 3; ++i) clip.areas[at(i)] += area;
    }
  for (float& area : clip.areas) area /= static_cast<float>(std::max<std::size_t>(1, clip.frames.size()));
}

}  // namespace

ClipShape clip_shape(GeometryVideoReader& video, const std::string& name, int level) {
  ClipShape clip{.name = name, .level = std::min(level, video.header().level), .fps = video.header().fps};
  for (int frame = 0; frame < video.frame_count(); ++frame) add(clip, video.read(frame));
  weigh(clip);
  return clip;
}

ClipShape clip_shape(const std::vector<GeometryImage>& images, const std::string& name, int level, double fps) {
  ClipShape clip{.name = name, .level = level, .fps = fps};
  for (const auto& image : images) add(clip, image);
  weigh(clip);
  return clip;
}

Eigen::Vector3d middle_of(const ClipShape& clip, int frame) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0.0;
  const auto& positions = clip.frames[static_cast<std::size_t>(frame)];
  for (std::size_t i = 0; i < positions.size(); ++i) {
    sum += static_cast<double>(clip.areas[i]) * positions[i].cast<double>();
    area += static_cast<double>(clip.areas[i]);
  }
  return sum / std::max(area, 1e-12);
}

std::vector<std::vector<std::uint32_t>> lattice_neighbours(int level) {
  const auto welded = weld_lattice(level);
  std::vector<std::vector<std::uint32_t>> neighbours(lattice_size(level));
  for (const auto& triangle : welded.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      neighbours[welded.sample_of_vertex[triangle[i]]].push_back(welded.sample_of_vertex[triangle[(i + 1) % 3]]);
  return neighbours;
}

}  // namespace rotunda::recon
