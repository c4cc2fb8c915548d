#include "tests/bench/key_study.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "capture/picture.h"
#include "capture/srgb.h"
#include "simulator/people/person.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/light.h"
#include "simulator/studio/pixel_encoding.h"

namespace rotunda::bench {
namespace {

namespace fs = std::filesystem;
using capture::PixelFormat;

constexpr std::size_t kSpillViews = 2;  // of each moment, whose own colours are rendered too

capture::Image as_sent(const cv::Mat& picture) {
  return capture::make_image(picture.cols, picture.rows, PixelFormat::bayer_rg8,
                             simulator::encode_pixels(picture, PixelFormat::bayer_rg8));
}

// Reads the pictures if all are there, else has them made and written.
class KeptPictures {
 public:
  KeptPictures(const fs::path& folder, const KeyStudy& study)
      : folder_(folder.empty() ? fs::path() : folder / study.name()) {
    if (!folder_.empty()) fs::create_directories(folder_);
  }
  template <class Make>
  cv::Mat get(const std::string& name, int channels, Make&& make) const {
    const auto file = folder_ / (name + ".png");
    if (!folder_.empty() && fs::exists(file)) return channels == 1 ? capture::read_grey(file) : capture::read_rgb(file);
    const cv::Mat picture = make();
    if (!folder_.empty()) capture::write_png(file, picture);
    return picture;
  }

 private:
  fs::path folder_;
};

}  // namespace

std::string KeyStudy::name() const {
  return fmt::format("{}-{}-{}-{}", person, act, backdrop.seed, sensor.seed);
}

std::vector<KeyStudy> development_studies() {
  std::vector<KeyStudy> studies;
  const auto cameras = simulator::camera_layout();
  for (const char* person : {"alex", "carla", "dan"})
    for (const char* act : {"walk", "dance"}) studies.push_back({person, act, {5}, {}, {}, cameras});
  return studies;
}

std::vector<KeyStudy> held_out_studies() {
  std::vector<KeyStudy> studies;
  simulator::SensorOptions sensor{.vignetting = 0.18, .seed = 11};
  const auto ring = simulator::camera_layout({.radius = 3.9, .ring_height = 1.55, .k1 = -0.12, .k2 = 0.03});
  const auto low = simulator::camera_layout({.radius = 3.4, .ring_height = 1.0, .aspect = 16.0 / 15.0});
  // A worn room with a wall that cameras look past the edge of, and a glossy one.
  const simulator::BackdropOptions worn{.wear = 1.5, .wall_height = 2.9, .seed = 123};
  const simulator::BackdropOptions glossy{.unevenness = 2.4, .gloss = 0.8, .seed = 9};
  for (const auto& person : simulator::person_names())
    for (const char* act : {"jog", "kick", "capoeira"}) {
      const bool odd = studies.size() % 2 != 0;
      studies.push_back({person, act, {31}, sensor, odd ? worn : glossy, odd ? ring : low});
    }
  return studies;
}

namespace {

// The study's people and room, made when something is asked of them that is not kept.
class StudyRenderer {
 public:
  explicit StudyRenderer(const KeyStudy& study) : study_(study) {}
  const simulator::Performance& performance() {
    if (!performance_) performance_ = simulator::make_performance({.person = study_.person, .act = study_.act});
    return *performance_;
  }
  simulator::SceneRenderer& studio() {
    if (!studio_)
      studio_ =
          std::make_unique<simulator::SceneRenderer>(performance(), study_.cameras, study_.sensor, study_.backdrop);
    return *studio_;
  }

 private:
  const KeyStudy& study_;
  std::unique_ptr<simulator::Performance> performance_;
  std::unique_ptr<simulator::SceneRenderer> studio_;
};

// `share` of the take gone by, 0 to 1.
cv::Mat in_drifted_light(const cv::Mat& rgb, double share) {
  const double light = 0.92 + 0.12 * share, red = 0.03 * (share - 0.67);
  cv::Mat table(1, 256, CV_8UC3), result;
  for (int i = 0; i < 256; ++i)
    for (int c = 0; c < 3; ++c)
      table.at<cv::Vec3b>(i)[c] = capture::srgb8_of(std::min(1.0, light *
                                                                      (c == 0   ? 1.0 + red
                                                                       : c == 2 ? 1.0 - red
                                                                                : 1.0) *
                                                                      capture::linear_of_srgb(i / 255.0)));
  cv::LUT(rgb, table, result);
  return result;
}

}  // namespace

std::vector<std::vector<cv::Mat>> render_drifting_take(const KeyStudy& study, int count, const fs::path& keep) {
  const KeptPictures kept(keep, study);
  StudyRenderer renderer(study);
  std::vector<std::vector<cv::Mat>> by_camera(study.cameras.size());
  for (int k = 0; k < count; ++k) {
    const int frame = (2 * k + 1) * renderer.performance().frames() / (2 * count);
    std::vector<simulator::ScenePicture> pictures;
    for (std::size_t i = 0; i < by_camera.size(); ++i) {
      const cv::Mat rgb = kept.get(fmt::format("take{:04}-{:02}", frame, i), 3, [&] {
        if (pictures.empty())
          pictures = renderer.studio().pictures(simulator::act_seconds(frame), static_cast<std::uint64_t>(frame));
        return to_rgb(as_sent(pictures[i].deep));
      });
      by_camera[i].push_back(in_drifted_light(rgb, (k + 0.5) / count));
    }
  }
  return by_camera;
}

RenderedStudy render(const KeyStudy& study, const fs::path& keep) {
  const KeptPictures kept(keep, study);
  StudyRenderer study_renderer(study);
  const auto renderer = [&]() -> simulator::SceneRenderer& { return study_renderer.studio(); };
  RenderedStudy rendered{study.person, {}, {}};
  for (std::size_t i = 0; i < study.cameras.size(); ++i)
    rendered.plates.push_back(
        kept.get(fmt::format("plate{:02}", i), 3, [&] { return to_rgb(as_sent(renderer().clean_plate(i))); }));
  for (const int frame : study.frames) {
    const double seconds = simulator::act_seconds(frame);
    std::vector<simulator::ScenePicture> pictures;
    const auto picture = [&](std::size_t i) -> const simulator::ScenePicture& {
      if (pictures.empty()) pictures = renderer().pictures(seconds, static_cast<std::uint64_t>(frame));
      return pictures[i];
    };
    KeyMoment moment;
    for (std::size_t i = 0; i < study.cameras.size(); ++i) {
      const auto& camera = study.cameras[i];
      const auto name = [&](const char* what) { return fmt::format("{}{:04}-{:02}", what, frame, i); };
      const cv::Mat mosaic = kept.get(name("mosaic"), 1, [&] {
        const auto bytes = simulator::encode_pixels(picture(i).deep, PixelFormat::bayer_rg8);
        return cv::Mat(camera.height, camera.width, CV_8UC1, const_cast<std::uint8_t*>(bytes.data())).clone();
      });
      KeyView view{
          camera,
          capture::make_image(camera.width, camera.height, PixelFormat::bayer_rg8, {mosaic.datastart, mosaic.dataend}),
          kept.get(name("truth"), 1, [&] { return picture(i).matte; }),
          {},
          {}};
      if (i < kSpillViews) {
        view.own = kept.get(name("own"), 3, [&] { return renderer().figures_alone(i, seconds, simulator::kWallGlow); });
        view.unspilt =
            kept.get(name("unspilt"), 3, [&] { return renderer().figures_alone(i, seconds, simulator::kGreyGlow); });
      }
      moment.views.push_back(std::move(view));
    }
    rendered.moments.push_back(std::move(moment));
  }
  return rendered;
}

}  // namespace rotunda::bench
