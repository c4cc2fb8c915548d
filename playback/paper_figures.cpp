#include "playback/paper_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "playback/display/headless.h"
#include "playback/render/frame_painter.h"
#include "playback/render/geometry_image_renderer.h"
#include "playback/render/mesh_renderer.h"
#include "playback/viewpoint.h"
#include "recon/sphere/sphere_map.h"
#include "recon/take_studio.h"
#include "recon/video/geometry_picture.h"
#include "recon/video/paper_video.h"

namespace rotunda::playback {
namespace {

namespace fs = std::filesystem;

constexpr double kAzimuth = 0.5, kElevation = 0.15;  // radians: half from the side, so that depth shows
constexpr int kSupersampling = 2;

struct ReconstructedFrame {
  recon::GeometryVideoReader video;
  int index;  // in the video
};

ReconstructedFrame open_frame(const fs::path& take, std::size_t frame) {
  const auto file = recon::geometry_video_of(take);
  if (!fs::exists(file)) throw InvalidInput(take.string() + " is not reconstructed yet; first: rotunda recon");
  recon::GeometryVideoReader video(file);
  const auto index = static_cast<std::int64_t>(frame) - video.header().first_frame;
  if (index < 0 || index >= video.frame_count())
    throw InvalidInput(fmt::format("{} holds the frames {} to {}, not {}", file.string(), video.header().first_frame,
                                   video.header().first_frame + video.frame_count() - 1, frame));
  return {std::move(video), static_cast<int>(index)};
}

Viewpoint view_of(const std::vector<Eigen::Vector3f>& points, const ContactSheetOptions& options) {
  Eigen::AlignedBox3d box;
  for (const auto& point : points) box.extend(point.cast<double>());
  auto orbit = orbit_around(box, 0.5, static_cast<double>(options.tile_width) / options.tile_height);
  orbit.azimuth = kAzimuth;
  orbit.elevation = kElevation;
  return orbit.viewpoint(kSupersampling * options.tile_width, kSupersampling * options.tile_height);
}

void colour_by_normals(recon::TriangleMesh& mesh) {
  recon::compute_normals(mesh);
  mesh.colours.clear();
  for (const auto& normal : mesh.normals) {
    const Eigen::Vector3f colour = 127.5F * (normal + Eigen::Vector3f::Ones());
    mesh.colours.push_back({static_cast<std::uint8_t>(colour.x()), static_cast<std::uint8_t>(colour.y()),
                            static_cast<std::uint8_t>(colour.z())});
  }
}

std::vector<CaptionedPicture> mapped_surface(recon::TriangleMesh mesh, const ContactSheetOptions& options) {
  const auto mapped = recon::map_to_sphere(mesh);
  colour_by_normals(mesh);
  std::vector<CaptionedPicture> pictures{{render_mesh(mesh, view_of(mesh.positions, options)),
                                          fmt::format("surface, {} triangles", mesh.triangles.size())}};
  if (!mapped.map) return pictures;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) mesh.positions[v] = mapped.map->points[v].cast<float>();
  pictures.push_back({render_mesh(mesh, view_of(mesh.positions, options)), "on the sphere"});
  return pictures;
}

cv::Mat painted(FramePainter& painter, int frame, const Viewpoint& viewpoint) {
  const RenderTarget target(viewpoint.width, viewpoint.height);
  painter.show(frame);
  target.bind();
  clear(std::nullopt);
  painter.draw(viewpoint);
  return target.read_rgba();
}

struct NumberedImage {
  std::size_t frame;
  recon::GeometryImage image;
};

// Positions of all, then colours of all.
std::vector<CaptionedPicture> image_row(const std::vector<NumberedImage>& images, const std::string& how) {
  std::vector<CaptionedPicture> row;
  for (const auto& [frame, image] : images)
    row.push_back({recon::position_picture(image), fmt::format("frame {}, {}", frame, how)});
  for (const auto& [frame, image] : images) row.push_back({recon::colour_picture(image), "its colours"});
  return row;
}

recon::GeometryImage own_image(const fs::path& take, std::size_t frame) {
  if (auto image = recon::frame_image(take, frame)) return *std::move(image);
  throw InvalidInput(
      fmt::format("frame {} of {} could not be mapped by itself; choose another --frame", frame, take.string()));
}

}  // namespace

cv::Mat figure_of_alignment(const fs::path& folder, const ContactSheetOptions& options) {
  constexpr int kStep = 5;  // frames
  auto first = open_frame(folder, options.frame);
  if (!first.video.header().aligned)
    throw InvalidInput(folder.string() + ": its frames are not aligned; `rotunda recon` tells why");
  const int left = first.video.frame_count() - 1 - first.index;
  const int step = std::min(kStep, left / 2);
  if (step < 1)
    throw InvalidInput(fmt::format("{} has {} frames after frame {}; figure 2 shows three: choose an earlier --frame",
                                   folder.string(), left, options.frame));
  std::vector<NumberedImage> own, aligned;
  for (int i = 0; i < 3; ++i) {
    const auto frame = options.frame + static_cast<std::size_t>(i * step);
    own.push_back({frame, own_image(folder, frame)});
    aligned.push_back({frame, first.video.read(first.index + i * step)});
  }
  auto square = options;
  square.tile_height = options.tile_width;
  return tile({image_row(own, "mapped by itself"), image_row(aligned, "aligned")}, square);
}

cv::Mat figure_of_stages(const fs::path& folder, const ContactSheetOptions& options) {
  auto frame = open_frame(folder, options.frame);
  const auto image = frame.video.read(frame.index);
  auto one_camera = options;
  one_camera.cameras = 1;
  const capture::TakeReader take(folder);
  auto row = camera_row(take, one_camera);
  const auto mattes = matte_row(take, one_camera);
  row.insert(row.end(), mattes.begin(), mattes.end());
  const HeadlessDisplay display;
  if (const auto mesh = recon::frame_surface(folder, options.frame))
    for (auto& picture : mapped_surface(*mesh, options)) row.push_back(std::move(picture));
  row.push_back({recon::position_picture(image), "geometry image: x, y, z"});
  row.push_back({recon::colour_picture(image), "its colours"});
  row.push_back({render_geometry_image(image, view_of(image.positions, options)), "drawn from it"});
  return tile({row}, options);
}

cv::Mat figure_of_quantisation(const fs::path& folder, const ContactSheetOptions& options) {
  auto frame = open_frame(folder, options.frame);
  const auto image = frame.video.read(frame.index);
  const auto& root = frame.video.header().root_path[static_cast<std::size_t>(frame.index)];
  const HeadlessDisplay display;
  const auto viewpoint = view_of(image.positions, options);
  const auto quantised = recon::as_paper_stores(image, root);
  std::vector<CaptionedPicture> shapes{
      {render_geometry_image(quantised, viewpoint, {.shading = Shading::grey}), "1 cm, 24 bits: shape"},
      {render_geometry_image(image, viewpoint, {.shading = Shading::grey}), "not quantised: shape"}};
  const auto painter = view_dependent_painter(frame.video, std::make_shared<TakePictures>(folder, std::nullopt));
  const std::vector<CaptionedPicture> row{{render_geometry_image(quantised, viewpoint), "quantised at 1 cm"},
                                          {render_geometry_image(image, viewpoint), "not quantised"},
                                          {painted(*painter, frame.index, viewpoint), "view-dependent colours"}};
  return tile({row, shapes}, options);
}

}  // namespace rotunda::playback
