#include "simulator/gallery.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "playback/contact_sheet.h"
#include "simulator/people/performance.h"
#include "simulator/people/person.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {
namespace {

namespace fs = std::filesystem;
using playback::CaptionedPicture;
using Row = std::vector<CaptionedPicture>;

constexpr int kMoments = 4;
constexpr playback::ContactSheetOptions kSheet{.tile_width = 160, .tile_height = 200};
constexpr playback::ContactSheetOptions kLargeSheet{.tile_width = 400, .tile_height = 500};

// One from the ring, a little from the front, and one from above at the back, as in the rig of ten.
std::vector<capture::CameraModel> two_cameras(double scale) {
  const auto rig = camera_layout({.width = cvRound(720 * scale), .height = cvRound(576 * scale)});
  return {rig[1], rig.back()};
}

// The whole person, then head and hand from near.
std::vector<capture::CameraModel> portrait_cameras(const Performance& person, double scale) {
  const auto joints = person.joints_at(0.0);
  const auto centre_of = [&](std::string_view name) {
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (person.joints()[i].name == name) return joints[i].position;
    return joints.front().position;
  };
  const int width = cvRound(960 * scale), height = cvRound(1200 * scale);
  const auto near = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& target, double seen_height) {
    const double focal = height * (from - target).norm() / seen_height;
    return look_at(from, target, width, height, focal, focal);
  };
  const Eigen::Vector3d middle(0.0, 0.0, 0.92), head = centre_of("head") + Eigen::Vector3d(0.02, 0.0, 0.05);
  const Eigen::Vector3d hand = centre_of("hand_left") + Eigen::Vector3d(0.0, 0.0, -0.06);
  return {near({3.4, 0.9, 1.3}, middle, 2.1), near({-3.4, -1.2, 1.5}, middle, 2.1), near({2.6, 0.8, 1.7}, head, 0.42),
          near({2.2, 2.0, 1.3}, hand, 0.36)};
}

void write_jpeg(const fs::path& file, const cv::Mat& rgb) {
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  if (!cv::imwrite(file.string(), bgr, {cv::IMWRITE_JPEG_QUALITY, 82}))
    throw std::system_error(errno, std::generic_category(), "cannot write " + file.string());
}

Row portraits(const Person& person, const GalleryOptions& options) {
  const auto standing = make_performance(person, {.act = "idle"});
  SceneRenderer studio(*standing, portrait_cameras(*standing, options.scale));
  Row row;
  for (const auto& picture : studio.pictures(0.0, 0)) row.push_back({picture.rgb, row.empty() ? person.name : ""});
  return row;
}

// What of the pictures to show: about the person wherever they are in these moments.
cv::Rect cut_out(const std::vector<cv::Mat>& mattes) {
  cv::Rect box;
  for (const auto& matte : mattes) box |= cv::boundingRect(matte);
  const int height = std::max(cvRound(1.15 * std::max(box.height, cvRound(box.width * 1.25))), 64);
  const cv::Point middle(box.x + box.width / 2, box.y + box.height / 2);
  const cv::Rect wanted(middle.x - height * 2 / 5, middle.y - height / 2, height * 4 / 5, height);
  return wanted & cv::Rect({}, mattes.front().size());
}

// As large as it will be shown: all sheets are held at once.
cv::Mat fitted(const cv::Mat& picture) {
  const double scale = std::min(static_cast<double>(kSheet.tile_width) / picture.cols,
                                static_cast<double>(kSheet.tile_height) / picture.rows);
  cv::Mat small;
  cv::resize(picture, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

// Four moments of one person from one camera, each with its matte.
Row moments(const std::vector<ScenePicture>& pictures, const std::string& caption, const Performance& performance) {
  std::vector<cv::Mat> mattes;
  for (const auto& picture : pictures) mattes.push_back(picture.matte);
  const cv::Rect part = cut_out(mattes);
  Row row;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto frame = static_cast<int>(i) * performance.frames() / kMoments;
    row.push_back({fitted(pictures[i].rgb(part)), fmt::format("{} frame {}", caption, frame)});
    row.push_back({fitted(pictures[i].matte(part)), ""});
  }
  return row;
}

std::vector<Row> act_rows(const Person& person, const std::string& act, const GalleryOptions& options) {
  const auto performance = make_performance(person, {.act = act});
  SceneRenderer studio(*performance, two_cameras(options.scale));
  std::array<std::vector<ScenePicture>, 2> by_camera;
  for (int i = 0; i < kMoments; ++i) {
    const int frame = i * performance->frames() / kMoments;
    auto pictures = studio.pictures(act_seconds(frame), static_cast<std::uint64_t>(frame));
    for (std::size_t camera = 0; camera < by_camera.size(); ++camera)
      by_camera[camera].push_back(std::move(pictures[camera]));
  }
  return {moments(by_camera[0], person.name + ",", *performance), moments(by_camera[1], "from above,", *performance)};
}

Person person_of(const std::string& name, const GalleryOptions& options) {
  auto description = describe_person(name);
  description.coarseness = options.coarseness;
  return make_person(description);
}

// Before the first picture: they take a while.
void check_names(const GalleryOptions& options) {
  for (const auto& person : options.people) describe_person(person);
  for (const auto& act : options.acts) motion_of(act, make_skeleton(1.75));
}

void write_page(const fs::path& directory, const GalleryOptions& options) {
  std::ofstream page(directory / "gallery.md");
  fmt::print(page,
             "# Who and what the simulated studio shows\nMade by `scripts/gallery`. True mattes stand beside the "
             "pictures.\n\n## People\n![People](people.jpg)\n");
  for (const auto& act : options.acts) fmt::print(page, "\n## {}\n![{}]({}.jpg)\n", act, act, act);
  if (!page.flush()) throw std::system_error(errno, std::generic_category(), "cannot write " + directory.string());
}

}  // namespace

void write_gallery(const fs::path& directory, const GalleryOptions& options,
                   const std::function<void(const std::string&)>& progress) {
  check_names(options);
  fs::create_directories(directory);
  std::vector<Row> people;
  std::map<std::string, std::vector<Row>> sheets;
  for (const auto& name : options.people) {
    const Person person = person_of(name, options);
    people.push_back(portraits(person, options));
    for (const auto& act : options.acts)
      for (auto& row : act_rows(person, act, options)) sheets[act].push_back(std::move(row));
    if (progress) progress(name);
  }
  write_jpeg(directory / "people.jpg", playback::tile(people, kLargeSheet));
  for (const auto& act : options.acts) write_jpeg(directory / (act + ".jpg"), playback::tile(sheets[act], kSheet));
  write_page(directory, options);
}

}  // namespace rotunda::simulator
