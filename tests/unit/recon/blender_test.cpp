// What Blender itself finds in an exported .glb. Skipped where there is no blender.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "recon/export/clip_export.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

// Opens FILE.glb, goes through its frames and writes what is on stage at each: {"frames": [[[x, y, z], ...], ...]}.
constexpr const char* kScript = R"(
import json, sys
import bpy, numpy
numpy.bool = bool  # Debian's Blender asks for what its NumPy has no longer
glb, out, fps, frames = sys.argv[-4], sys.argv[-3], int(sys.argv[-2]), int(sys.argv[-1])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = fps
bpy.ops.import_scene.gltf(filepath=glb)
found = []
for frame in range(frames):
    bpy.context.scene.frame_set(frame)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    points = []
    for thing in bpy.context.scene.objects:
        if thing.type != 'MESH' or max(abs(s) for s in thing.matrix_world.to_scale()) < 0.5:
            continue
        posed = thing.evaluated_get(depsgraph)
        points += [list(thing.matrix_world @ vertex.co) for vertex in posed.to_mesh().vertices]
    found.append(points)
last = max(action.frame_range[1] for action in bpy.data.actions)
json.dump({'frames': found, 'last': last, 'pictures': len(bpy.data.images)}, open(out, 'w'))
)";

class Blender : public ::testing::Test {
 protected:
  Blender() { fs::create_directories(folder_); }
  ~Blender() override { fs::remove_all(folder_); }
  void SetUp() override {
    if (std::system("command -v blender >/dev/null 2>&1") != 0) GTEST_SKIP() << "no blender here";
  }

  nlohmann::json opened(const fs::path& glb, int fps, std::size_t frames) {
    const auto script = folder_ / "look.py", found = folder_ / "found.json", log = folder_ / "blender.log";
    std::ofstream(script) << kScript;
    const auto command = fmt::format(
        "env -u LD_PRELOAD blender -b --factory-startup --python-exit-code 7 --python '{}' -- '{}' '{}' {} {} >'{}' "
        "2>&1",
        script.string(), glb.string(), found.string(), fps, frames, log.string());
    if (std::system(command.c_str()) != 0) {
      std::ifstream said(log);
      throw std::runtime_error({std::istreambuf_iterator<char>(said), {}});
    }
    return nlohmann::json::parse(std::ifstream(found));
  }

  fs::path folder_ = fs::temp_directory_path() / ("rotunda_blender_" + std::to_string(::getpid()));
};

// Of every sample the nearest vertex Blender has; it may join or split them.
float farthest(const GeometryImage& image, const nlohmann::json& points) {
  float worst = 0.0F;
  for (const auto& position : image.positions) {
    float nearest = std::numeric_limits<float>::infinity();
    for (const auto& p : points) nearest = std::min(nearest, (Eigen::Vector3f(p[0], p[1], p[2]) - position).norm());
    worst = std::max(worst, nearest);
  }
  return worst;
}

TEST_F(Blender, SeesTheSameSurfaceAtEveryFrame) {
  constexpr int kFps = 25, kLevel = 4;
  std::vector<GeometryImage> images;
  for (int i = 0; i < 5; ++i)
    images.push_back(test::round_geometry_image({.level = kLevel,
                                                 .colour_level = kLevel,
                                                 .centre = {0.2F * static_cast<float>(i), 0.1F, 1.0F},
                                                 .radii = {0.5F, 0.4F, 0.6F + 0.05F * static_cast<float>(i)}}));
  write_geometry_video(folder_ / "clip.mkv", images, kFps);
  GeometryVideoReader video(folder_ / "clip.mkv");
  for (const bool morph : {false, true}) {
    export_clip(video, {.format = ClipFormat::glb, .output = folder_ / "clip.glb", .morph = morph});
    const auto found = opened(folder_ / "clip.glb", kFps, images.size());
    EXPECT_EQ(found.at("last").get<double>(), 4.0) << morph;  // as many frames, at the same rate
    EXPECT_GE(found.at("pictures").get<int>(), 1);
    for (std::size_t i = 0; i < images.size(); ++i)
      EXPECT_LT(farthest(images[i], found.at("frames").at(i)), 1e-4F) << "frame " << i << ", morph " << morph;
  }
}

}  // namespace
}  // namespace rotunda::recon
