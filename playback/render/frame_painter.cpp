#include "playback/render/frame_painter.h"

#include "capture/take/take_reader.h"
#include "playback/render/geometry_image_renderer.h"
#include "playback/render/view_dependent_renderer.h"
#include "recon/sphere/resample.h"
#include "recon/take_plates.h"
#include "recon/take_studio.h"

namespace rotunda::playback {
namespace {

class StoredPainter : public FramePainter {
 public:
  StoredPainter(recon::GeometryVideoReader& video, const DrawOptions& options) : video_(video), options_(options) {}
  void show(int frame) override { renderer_.upload(video_.read(frame)); }
  void draw(const Viewpoint& viewpoint) override { renderer_.draw(viewpoint, options_); }

 private:
  recon::GeometryVideoReader& video_;
  DrawOptions options_;
  GeometryImageRenderer renderer_;
};

class ViewDependentPainter : public FramePainter {
 public:
  ViewDependentPainter(recon::GeometryVideoReader& video, const std::filesystem::path& take,
                       const std::optional<std::filesystem::path>& calibration)
      : video_(video), stored_(video, {}), take_(take), studio_(recon::read_take_studio(take_, calibration)) {
    recon::learn_missing_plates(take_, studio_.views);
  }

  void show(int frame) override {
    const auto sources = sources_of(frame);
    has_pictures_ = !sources.empty();
    if (has_pictures_)
      renderer_.upload(recon::remesh(video_.read(frame)), sources);
    else
      stored_.show(frame);
  }

  void draw(const Viewpoint& viewpoint) override {
    if (has_pictures_)
      renderer_.draw(viewpoint);
    else
      stored_.draw(viewpoint);
  }

 private:
  std::vector<SourceView> sources_of(int frame) {
    const auto number = static_cast<std::size_t>(video_.header().first_frame + frame);
    recon::StageClock clock;
    return source_views(recon::key_frame(take_.read(number), studio_.views, recon::given_mattes(take_, number), clock));
  }

  recon::GeometryVideoReader& video_;
  StoredPainter stored_;
  capture::TakeReader take_;
  recon::TakeStudio studio_;
  ViewDependentRenderer renderer_;
  bool has_pictures_ = false;
};

}  // namespace

std::unique_ptr<FramePainter> stored_painter(recon::GeometryVideoReader& video, const DrawOptions& options) {
  return std::make_unique<StoredPainter>(video, options);
}

std::unique_ptr<FramePainter> view_dependent_painter(recon::GeometryVideoReader& video,
                                                     const std::filesystem::path& take,
                                                     const std::optional<std::filesystem::path>& calibration) {
  return std::make_unique<ViewDependentPainter>(video, take, calibration);
}

}  // namespace rotunda::playback
