#include "playback/render/frame_painter.h"

#include "playback/render/geometry_image_renderer.h"
#include "playback/render/mesh_renderer.h"
#include "playback/render/view_dependent_renderer.h"
#include "recon/sphere/resample.h"

namespace rotunda::playback {
namespace {

constexpr recon::Colour kNoColour{128, 128, 128};

class StoredPainter : public FramePainter {
 public:
  StoredPainter(recon::GeometryVideoReader& video, const DrawOptions& options) : video_(video), options_(options) {}
  void show(int frame) override { renderer_.upload(video_.read(frame, {.drawn = true})); }
  void draw(const Viewpoint& viewpoint) override { renderer_.draw(viewpoint, options_); }

 private:
  recon::GeometryVideoReader& video_;
  DrawOptions options_;
  GeometryImageRenderer renderer_;
};

class ViewDependentPainter : public FramePainter {
 public:
  ViewDependentPainter(SurfaceOf surface_of, std::shared_ptr<TakePictures> pictures, std::size_t first_frame)
      : surface_of_(std::move(surface_of)), pictures_(std::move(pictures)), first_frame_(first_frame) {}

  void show(int frame) override {
    auto surface = surface_of_(frame);
    if (surface.colours.empty()) surface.colours.assign(surface.positions.size(), kNoColour);
    const auto views = pictures_->of(first_frame_ + static_cast<std::size_t>(frame));
    has_pictures_ = !views.empty();
    if (has_pictures_)
      renderer_.upload(surface, views);
    else
      own_.upload(surface);
  }

  void draw(const Viewpoint& viewpoint) override {
    if (has_pictures_)
      renderer_.draw(viewpoint);
    else
      own_.draw(viewpoint);
  }

 private:
  SurfaceOf surface_of_;
  std::shared_ptr<TakePictures> pictures_;
  std::size_t first_frame_;
  ViewDependentRenderer renderer_;
  MeshRenderer own_;
  bool has_pictures_ = false;
};

}  // namespace

std::unique_ptr<FramePainter> stored_painter(recon::GeometryVideoReader& video, const DrawOptions& options) {
  return std::make_unique<StoredPainter>(video, options);
}

std::unique_ptr<FramePainter> view_dependent_painter(SurfaceOf surface_of, std::shared_ptr<TakePictures> pictures,
                                                     std::size_t first_frame) {
  return std::make_unique<ViewDependentPainter>(std::move(surface_of), std::move(pictures), first_frame);
}

std::unique_ptr<FramePainter> view_dependent_painter(recon::GeometryVideoReader& video,
                                                     std::shared_ptr<TakePictures> pictures) {
  return view_dependent_painter([&video](int frame) { return recon::remesh(video.read(frame)); }, std::move(pictures),
                                static_cast<std::size_t>(video.header().first_frame));
}

}  // namespace rotunda::playback
