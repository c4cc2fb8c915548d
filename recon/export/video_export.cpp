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
  header.aligned = clip.header().aligned;
  header.first_frame = clip.header().first_frame + clip.first_frame();
  return header;
}

void add_to_header(GeometryVideoHeader& header, const ClipExport& clip, int index, const GeometryImage& image) {
  add_frame(header, image, clip.status(index));
}

// Twice through the frames: for the header and the mean, then into the file.
void export_frames(ClipExport& clip, VideoProfile profile, void (*for_each)(ClipExport&, const Visit&)) {
  clip.set_passes(2);
  auto header = header_of(clip, profile);
  MeanSurface mean;
  for_each(clip, [&](int i, const GeometryImage& image) {
    add_to_header(header, clip, i, image);
    if (profile != VideoProfile::float32) mean.add(image.positions, header.root_path.back());
  });
  GeometryVideoWriter writer(clip.output(), header, mean);
  for_each(clip, [&](int, const GeometryImage& image) { writer.write(image); });
  writer.finish();
}

}  // namespace

void export_video(ClipExport& clip, VideoProfile profile) {
  clip.set_surface(lattice_size(clip.level()), lattice_triangles(clip.level()).size());
  export_frames(clip, profile, profile == VideoProfile::stream ? for_each_filtered_frame : for_each_frame);
  clip.written(clip.output());
  if (clip.output().extension() != ".avi") return;
  for (const char* ending : {".json", ".mean.png"}) {
    const auto beside = clip.output().parent_path() / (clip.output().stem().string() + ending);
    if (std::filesystem::exists(beside)) clip.written(beside);
  }
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
