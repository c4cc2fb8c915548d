#include "tests/bench/key_study.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "capture/picture.h"
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

RenderedStudy render(const KeyStudy& study, const fs::path& keep) {
  const KeptPictures kept(keep, study);
  std::unique_ptr<simulator::Performance> performance;
  std::unique_ptr<simulator::SceneRenderer> studio;
  const auto renderer = [&]() -> simulator::SceneRenderer& {
    if (!studio) {
      performance = simulator::make_performance({.person = study.person, .act = study.act});
      studio = std::make_unique<simulator::SceneRenderer>(*performance, study.cameras, study.sensor, study.backdrop);
    }
    return *studio;
  };
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
