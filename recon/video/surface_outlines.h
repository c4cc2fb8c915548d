#pragma once
// The silhouettes that a geometry video's surfaces cast on ten cameras around them, for motion capture: so a clip of a
// character, or a take without its pictures, tells how the person moved. World, metres.
#include <filesystem>
#include <mutex>

#include "recon/body/outline_source.h"
#include "recon/video/geometry_video.h"

namespace rotunda::recon {

class SurfaceOutlines final : public OutlineSource {
 public:
  // Throws as GeometryVideoReader does.
  explicit SurfaceOutlines(const std::filesystem::path& video);

  std::string name() const override { return "clip " + file_.string(); }
  std::string where_to_look() const override;
  std::size_t frame_count() const override { return static_cast<std::size_t>(video_.frame_count()); }
  double fps() const override { return video_.header().fps; }
  FrameOutlines outlines(std::size_t frame) override;

 private:
  TriangleMesh surface(std::size_t frame);

  std::filesystem::path file_;
  std::mutex reading_;
  GeometryVideoReader video_;
};

}  // namespace rotunda::recon
