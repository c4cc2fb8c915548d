#include "playback/contact_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "capture/take/take_reader.h"
#include "playback/display/headless.h"
#include "playback/render/geometry_image_renderer.h"
#include "playback/render/mesh_renderer.h"
#include "playback/viewpoint.h"
#include "recon/take_studio.h"
#include "recon/video/geometry_picture.h"
#include "recon/video/geometry_video.h"

namespace rotunda::playback {
namespace {

namespace fs = std::filesystem;
using Row = std::vector<CaptionedPicture>;

const cv::Scalar kPaper(32, 32, 36);
const cv::Scalar kInk(220, 220, 220);
constexpr int kCaptionHeight = 18;
constexpr double kDegree = std::numbers::pi / 180.0;

cv::Mat on_paper(const cv::Mat& picture) {
  cv::Mat rgb;
  if (picture.channels() == 1) cv::cvtColor(picture, rgb, cv::COLOR_GRAY2RGB);
  if (picture.channels() == 3) rgb = picture;
  if (picture.channels() != 4) return rgb;
  rgb.create(picture.size(), CV_8UC3);
  for (int i = 0; i < static_cast<int>(picture.total()); ++i) {
    const auto& pixel = picture.ptr<cv::Vec4b>()[i];
    for (int c = 0; c < 3; ++c)
      rgb.ptr<cv::Vec3b>()[i][c] =
          cv::saturate_cast<std::uint8_t>((pixel[c] * pixel[3] + kPaper[c] * (255 - pixel[3])) / 255.0);
  }
  return rgb;
}

void place(const CaptionedPicture& tile, cv::Mat sheet, const ContactSheetOptions& options) {
  cv::putText(sheet, tile.caption, {4, kCaptionHeight - 5}, cv::FONT_HERSHEY_SIMPLEX, 0.4, kInk, 1, cv::LINE_AA);
  if (tile.picture.empty()) return;
  const double scale = std::min(static_cast<double>(options.tile_width) / tile.picture.cols,
                                static_cast<double>(options.tile_height) / tile.picture.rows);
  cv::Mat scaled;
  cv::resize(on_paper(tile.picture), scaled, {}, scale, scale, scale < 1.0 ? cv::INTER_AREA : cv::INTER_NEAREST);
  const int width = std::min(scaled.cols, options.tile_width), height = std::min(scaled.rows, options.tile_height);
  const cv::Rect at((options.tile_width - width) / 2, kCaptionHeight, width, height);
  scaled(cv::Rect(0, 0, width, height)).copyTo(sheet(at));
}

// Cameras spread over the whole rig rather than its first few.
std::vector<std::size_t> spread(std::size_t count, int wanted) {
  std::vector<std::size_t> chosen;
  const auto n = std::min<std::size_t>(count, static_cast<std::size_t>(std::max(1, wanted)));
  for (std::size_t i = 0; i < n; ++i) chosen.push_back(i * count / n);
  return chosen;
}

Eigen::AlignedBox3d box_of(const recon::GeometryImage& image) {
  Eigen::AlignedBox3d box;
  for (const auto& position : image.positions) box.extend(position.cast<double>());
  return box;
}

Viewpoint between_cameras(const recon::GeometryImage& image, double azimuth_deg, double elevation_deg,
                          const ContactSheetOptions& options) {
  const double aspect = static_cast<double>(options.tile_width) / options.tile_height;
  auto orbit = orbit_around(box_of(image), 0.5, aspect);
  orbit.azimuth = azimuth_deg * kDegree;
  orbit.elevation = elevation_deg * kDegree;
  return orbit.viewpoint(2 * options.tile_width, 2 * options.tile_height);
}

Row surface_row(const fs::path& take, const recon::GeometryImage& image, const ContactSheetOptions& options) {
  Row row;
  const auto mesh = recon::frame_surface(take, options.frame);
  if (mesh)
    row.push_back({render_mesh(*mesh, between_cameras(image, 30.0, 10.0, options), {.shading = Shading::grey}),
                   fmt::format("surface, {} triangles", mesh->triangles.size())});
  row.push_back({render_geometry_image(image, between_cameras(image, 30.0, 10.0, options), {.shading = Shading::grey}),
                 "geometry image, drawn"});
  row.push_back({recon::position_picture(image), "positions as red, green, blue"});
  row.push_back({recon::colour_picture(image), "colours"});
  row.push_back(
      {cv::Mat(image.colour_side(), image.colour_side(), CV_8UC1, const_cast<std::uint8_t*>(image.coverage.data()))
           .clone(),
       "seen by a camera"});
  return row;
}

Row view_row(const recon::GeometryImage& image, const ContactSheetOptions& options) {
  Row row;
  constexpr double kViews[][2] = {{22.0, 5.0}, {67.0, 25.0}, {157.0, 10.0}, {247.0, -10.0}, {315.0, 40.0}};
  for (const auto& [azimuth, elevation] : kViews)
    row.push_back({render_geometry_image(image, between_cameras(image, azimuth, elevation, options)),
                   fmt::format("from {:.0f} deg, {:.0f} up: no camera there", azimuth, elevation)});
  return row;
}

}  // namespace

Row camera_row(const capture::TakeReader& take, const ContactSheetOptions& options) {
  Row row;
  for (const auto camera : spread(take.info().cameras.size(), options.cameras)) {
    auto picture = capture::picture_of(take.read(options.frame, camera));
    const auto& name = take.info().cameras[camera].name;
    auto caption = picture.rgb.empty() ? fmt::format("{}: {}", name, picture.missing_because)
                                       : fmt::format("{}, frame {}", name, options.frame);
    row.push_back({std::move(picture.rgb), std::move(caption)});
  }
  return row;
}

Row matte_row(const capture::TakeReader& take, const ContactSheetOptions& options) {
  const auto studio = recon::read_take_studio(take, std::nullopt);
  auto set = take.read(options.frame);
  const auto chosen = spread(set.slots.size(), options.cameras);
  for (std::size_t i = 0; i < set.slots.size(); ++i)
    if (!std::binary_search(chosen.begin(), chosen.end(), i)) set.slots[i].frame.reset();
  recon::StageClock clock;
  const auto views = recon::key_frame(set, studio.views, recon::given_mattes(take, options.frame), clock);
  Row row;
  for (std::size_t i = 0; i < views.cameras.size(); ++i)
    row.push_back({views.mattes[i].alpha, views.cameras[i].name + ", matte"});
  return row;
}

cv::Mat tile(const std::vector<Row>& rows, const ContactSheetOptions& options) {
  std::size_t columns = 1;
  for (const auto& row : rows) columns = std::max(columns, row.size());
  const int height = options.tile_height + kCaptionHeight;
  cv::Mat sheet(static_cast<int>(rows.size()) * height, static_cast<int>(columns) * options.tile_width, CV_8UC3,
                kPaper);
  for (std::size_t y = 0; y < rows.size(); ++y)
    for (std::size_t x = 0; x < rows[y].size(); ++x)
      place(rows[y][x],
            sheet(cv::Rect(static_cast<int>(x) * options.tile_width, static_cast<int>(y) * height, options.tile_width,
                           height)),
            options);
  return sheet;
}

cv::Mat clip_sheet(recon::GeometryVideoReader& video, int frames, const ContactSheetOptions& options) {
  const HeadlessDisplay display;
  const auto& header = video.header();
  std::vector<Row> rows(3);
  const int count = std::clamp(frames, 1, header.frame_count());
  for (int i = 0; i < count; ++i) {
    const int index = count > 1 ? i * (header.frame_count() - 1) / (count - 1) : 0;
    const auto image = video.read(index);
    const bool interpolated = header.statuses[static_cast<std::size_t>(index)].interpolated;
    rows[0].push_back({recon::position_picture(image),
                       fmt::format("frame {}{}", header.first_frame + index, interpolated ? ", interpolated" : "")});
    rows[1].push_back({recon::colour_picture(image), "colours"});
    rows[2].push_back({render_geometry_image(image, between_cameras(image, 30.0, 10.0, options)), "drawn"});
  }
  return tile(rows, options);
}

cv::Mat contact_sheet(const fs::path& folder, const ContactSheetOptions& options) {
  const capture::TakeReader take(folder);
  std::vector<Row> rows{camera_row(take, options)};
  const auto video_file = recon::geometry_video_of(folder);
  if (!fs::exists(video_file)) return tile(rows, options);
  recon::GeometryVideoReader video(video_file);
  const auto index = static_cast<std::int64_t>(options.frame) - video.header().first_frame;
  if (index < 0 || index >= video.frame_count()) return tile(rows, options);
  const HeadlessDisplay display;
  const auto image = video.read(static_cast<int>(index));
  rows.push_back(matte_row(take, options));
  rows.push_back(surface_row(folder, image, options));
  rows.push_back(view_row(image, options));
  return tile(rows, options);
}

}  // namespace rotunda::playback
