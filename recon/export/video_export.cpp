// A clip as a geometry video of another profile, level or range.
#include <algorithm>
#include <deque>
#include <functional>

#include "recon/export/clip_surface.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/video/paper_video.h"
#include "recon/video/temporal_filter.h"

namespace rotunda::recon {
namespace {

constexpr float kFilterLimit = 0.004F;  // metres; surfaces are noisy by 1 mm along each axis from frame to frame

using Visit = std::function<void(int index, const GeometryImage& image)>;

void for_each_frame(ClipExport& clip, const Visit& visit) {
  for (int i = 0; i < clip.count(); ++i) visit(i, clip.read(i));
}

// The same with every frame's positions filtered along time, each relative to its frame's root meanwhile.
void for_each_filtered_frame(ClipExport& clip, const Visit& visit) {
  if (clip.count() < kFilterFrames) return for_each_frame(clip, visit);
  std::deque<GeometryImage> images;                    // of the window
  std::deque<std::vector<Eigen::Vector3f>> positions;  // in place
  int read = 0;
  for (int i = 0; i < clip.count(); ++i) {
    const int first = std::clamp(i - kFilterFrames / 2, 0, clip.count() - kFilterFrames);  // of the window
    for (; read < first + kFilterFrames; ++read) {
      images.push_back(clip.read(read));
      auto in_place = images.back().positions;
      for (auto& position : in_place) position -= clip.root(read).cast<float>();
      positions.push_back(std::move(in_place));
      if (images.size() > kFilterFrames) {
        images.pop_front();
        positions.pop_front();
      }
    }
    const std::vector<std::vector<Eigen::Vector3f>> window(positions.begin(), positions.end());
    auto image = images[static_cast<std::size_t>(i - first)];
    image.positions =
        filtered(std::span<const std::vector<Eigen::Vector3f>, kFilterFrames>(window), i - first, kFilterLimit);
    for (auto& position : image.positions) position += clip.root(i).cast<float>();
    visit(i, image);
  }
}

GeometryVideoHeader header_of(const ClipExport& clip, VideoProfile profile) {
  GeometryVideoHeader header;
  header.profile = profile;
  header.fps = clip.fps();
  header.first_frame = clip.header().first_frame + clip.first_frame();
  return header;
}

void add_to_header(GeometryVideoHeader& header, const ClipExport& clip, int index, const GeometryImage& image) {
  add_frame(header, image, clip.header().statuses[static_cast<std::size_t>(clip.first_frame() + index)]);
}

// Positions relative to their frame's root in the new video.
Eigen::Vector3d in_place(const GeometryVideoHeader& header, int index, const Eigen::Vector3f& position) {
  return position.cast<double>() - header.root_path[static_cast<std::size_t>(index)];
}

void export_lossless(ClipExport& clip, VideoProfile profile) {
  clip.set_passes(2);
  auto header = header_of(clip, profile);
  for_each_frame(clip, [&](int i, const GeometryImage& image) { add_to_header(header, clip, i, image); });
  GeometryVideoWriter writer(clip.output(), header);
  for_each_frame(clip, [&](int, const GeometryImage& image) { writer.write(image); });
  writer.finish();
}

void export_stream(ClipExport& clip) {
  clip.set_passes(3);
  auto header = header_of(clip, VideoProfile::stream);
  std::vector<Eigen::Vector3d> sum(lattice_size(clip.level()), Eigen::Vector3d::Zero());
  for_each_filtered_frame(clip, [&](int i, const GeometryImage& image) {
    add_to_header(header, clip, i, image);
    for (std::size_t v = 0; v < sum.size(); ++v) sum[v] += in_place(header, i, image.positions[v]);
  });
  std::vector<Eigen::Vector3f> mean;
  for (const auto& s : sum) mean.push_back((s / clip.count()).cast<float>());
  for_each_filtered_frame(clip, [&](int i, const GeometryImage& image) {
    for (std::size_t v = 0; v < mean.size(); ++v)
      header.difference_box.extend(in_place(header, i, image.positions[v]) - mean[v].cast<double>());
  });
  // What 16 bits take from the mean, the differences must hold.
  const Eigen::Vector3d step = header.box.sizes() / 65535.0;
  header.difference_box.extend(Eigen::Vector3d(header.difference_box.min() - step));
  header.difference_box.extend(Eigen::Vector3d(header.difference_box.max() + step));
  GeometryVideoWriter writer(clip.output(), header, mean);
  for_each_filtered_frame(clip, [&](int, const GeometryImage& image) { writer.write(image); });
  writer.finish();
}

}  // namespace

void export_video(ClipExport& clip, VideoProfile profile) {
  clip.set_surface(lattice_size(clip.level()), lattice_triangles(clip.level()).size());
  if (profile == VideoProfile::stream)
    export_stream(clip);
  else
    export_lossless(clip, profile);
  clip.written(clip.output());
}

void export_paper(ClipExport& clip) {
  clip.set_passes(2);
  clip.set_surface(lattice_size(clip.level()), lattice_triangles(clip.level()).size());
  auto header = header_of(clip, VideoProfile::master);
  for_each_frame(clip, [&](int i, const GeometryImage& image) { add_to_header(header, clip, i, image); });
  auto json = clip.output();
  json.replace_extension("json");
  PaperVideoWriter writer(clip.output(), json, header);
  for_each_frame(clip, [&](int, const GeometryImage& image) { writer.write(image); });
  writer.finish();
  clip.written(clip.output());
  clip.written(json);
}

}  // namespace rotunda::recon
