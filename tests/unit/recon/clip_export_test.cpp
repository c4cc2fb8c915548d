#include "recon/export/clip_export.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <assimp/Importer.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "config/errors.h"
#include "recon/mesh/mesh_file.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/video/paper_video.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kFrames = 4, kLevel = 4, kFirst = 10;
constexpr double kFps = 12.5;
constexpr float kSame = 1e-4F;  // metres: what other programs must find again

// A ball that travels, its colours finer than its positions, one frame interpolated.
GeometryImage ball(int frame) {
  auto image = test::round_geometry_image({.level = kLevel,
                                           .colour_level = kLevel + 1,
                                           .centre = {0.3F * static_cast<float>(frame) - 0.5F, 0.2F, 1.0F},
                                           .radii = {0.5F, 0.4F, 0.6F + 0.05F * static_cast<float>(frame)}});
  image.colours[7] = {static_cast<std::uint8_t>(frame), 1, 2};
  return image;
}

class ClipExportTest : public ::testing::Test {
 protected:
  ClipExportTest() {
    fs::create_directories(folder_);
    GeometryVideoHeader header;
    header.fps = kFps;
    header.first_frame = kFirst;
    for (int i = 0; i < kFrames; ++i) add_frame(header, ball(i), {.interpolated = i == 2, .reason = ""});
    GeometryVideoWriter writer(folder_ / "geometry.mkv", header);
    for (int i = 0; i < kFrames; ++i) writer.write(ball(i));
    writer.finish();
    video_.emplace(folder_ / "geometry.mkv");
  }
  ~ClipExportTest() override { fs::remove_all(folder_); }

  ClipExportReport run(ClipFormat format, const std::string& output, int level = 0) {
    return export_clip(*video_, {.format = format, .output = folder_ / output, .level = level});
  }
  const aiScene& open(const fs::path& file, unsigned steps = 0) {
    const auto* scene = importer_.ReadFile((folder_ / file).string(), steps);
    if (!scene) throw std::runtime_error(importer_.GetErrorString());
    return *scene;
  }

  fs::path folder_ = fs::temp_directory_path() / ("rotunda_clip_export_" + std::to_string(::getpid()));
  std::optional<GeometryVideoReader> video_;
  Assimp::Importer importer_;
};

cv::Vec3b first_texel_after_six(const aiTexture& texture) {  // where ball() puts the frame's number
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(texture.pcData);
  const std::vector<std::uint8_t> png(bytes, bytes + texture.mWidth);
  return cv::imdecode(png, cv::IMREAD_COLOR).at<cv::Vec3b>(0, 7);  // blue first
}

const aiNodeAnim& channel_of(const aiAnimation& animation, const std::string& node) {  // assimp's order is its own
  for (unsigned i = 0; i < animation.mNumChannels; ++i)
    if (animation.mChannels[i]->mNodeName.C_Str() == node) return *animation.mChannels[i];
  throw std::runtime_error("no channel for " + node);
}

Eigen::Vector3f vector_of(const aiVector3D& v) {
  return {v.x, v.y, v.z};
}
// glTF's y up back to the world.
Eigen::Vector3f z_up(const Eigen::Vector3f& v) {
  return {v.x(), -v.z(), v.y()};
}

TEST_F(ClipExportTest, GlbShowsEveryFrameAloneAtItsTimeInItsColours) {
  const auto report = run(ClipFormat::glb, "ball.glb");
  EXPECT_EQ(report.frames, 4U);
  const auto& scene = open("ball.glb");
  ASSERT_EQ(scene.mNumMeshes, 4U);
  ASSERT_EQ(scene.mNumTextures, 4U);
  ASSERT_EQ(scene.mNumAnimations, 1U);
  const auto& animation = *scene.mAnimations[0];
  ASSERT_EQ(animation.mNumChannels, 4U);
  for (unsigned frame = 0; frame < 4; ++frame) {
    const auto expected = ball(static_cast<int>(frame));
    const auto& mesh = *scene.mMeshes[frame];
    ASSERT_EQ(mesh.mNumVertices, lattice_size(kLevel));
    for (unsigned v = 0; v < mesh.mNumVertices; ++v)
      ASSERT_LT((z_up(vector_of(mesh.mVertices[v])) - expected.positions[v]).norm(), kSame) << frame;
    EXPECT_EQ(first_texel_after_six(*scene.mTextures[frame])[2], frame);
    const auto& node = channel_of(animation, "frame0000" + std::to_string(kFirst + static_cast<int>(frame)));
    ASSERT_EQ(node.mNumScalingKeys, 4U);
    for (unsigned key = 0; key < 4; ++key) {
      EXPECT_NEAR(node.mScalingKeys[key].mTime / 1000.0, key / kFps, 1e-6);  // assimp counts it in milliseconds
      EXPECT_EQ(node.mScalingKeys[key].mValue.y, key == frame ? 1.0F : 0.0F);
    }
  }
}

TEST_F(ClipExportTest, GlbWithMorphTargetsHasEveryFrameAtItsTime) {
  const auto report = export_clip(*video_, {.output = folder_ / "ball.glb", .morph = true});
  EXPECT_EQ(report.frames, 4U);
  EXPECT_EQ(report.interpolated, 1U);
  EXPECT_EQ(report.vertices, lattice_size(kLevel));
  EXPECT_EQ(report.bytes, fs::file_size(folder_ / "ball.glb"));
  const auto& scene = open("ball.glb");
  ASSERT_EQ(scene.mNumMeshes, 1U);
  const auto& mesh = *scene.mMeshes[0];
  ASSERT_EQ(mesh.mNumVertices, lattice_size(kLevel));
  ASSERT_EQ(mesh.mNumAnimMeshes, 3U);
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto* vertices = frame == 0 ? mesh.mVertices : mesh.mAnimMeshes[frame - 1]->mVertices;
    const auto expected = ball(frame);
    for (unsigned v = 0; v < mesh.mNumVertices; ++v)
      ASSERT_LT((z_up(vector_of(vertices[v])) - expected.positions[v]).norm(), kSame) << frame;
  }
  ASSERT_EQ(scene.mNumAnimations, 1U);
  const auto& animation = *scene.mAnimations[0];
  ASSERT_EQ(animation.mNumMorphMeshChannels, 1U);
  const auto& channel = *animation.mMorphMeshChannels[0];
  ASSERT_EQ(channel.mNumKeys, 4U);
  for (unsigned key = 0; key < 4; ++key) {
    EXPECT_NEAR(channel.mKeys[key].mTime / 1000.0, key / kFps, 1e-6);  // assimp counts glTF's time in milliseconds
    for (unsigned target = 0; target < 3; ++target)
      EXPECT_EQ(channel.mKeys[key].mWeights[target], target + 1 == key ? 1.0 : 0.0);
  }
}

TEST_F(ClipExportTest, GlbLooksOutwardsWithColoursWhereTheyBelong) {
  export_clip(*video_, {.output = folder_ / "ball.glb", .morph = true});
  const auto& scene = open("ball.glb");
  const auto& mesh = *scene.mMeshes[0];
  double volume = 0.0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const auto* corners = mesh.mFaces[f].mIndices;
    const auto a = vector_of(mesh.mVertices[corners[0]]), b = vector_of(mesh.mVertices[corners[1]]),
               c = vector_of(mesh.mVertices[corners[2]]);
    volume += static_cast<double>(a.dot(b.cross(c))) / 6.0;
  }
  EXPECT_NEAR(volume, 4.0 / 3.0 * 3.14159 * 0.5 * 0.4 * 0.6, 0.02);  // a lattice of 17 x 17 lies a little inside
  ASSERT_EQ(scene.mNumTextures, 1U);
  const auto& texture = *scene.mTextures[0];
  const std::vector<std::uint8_t> png(reinterpret_cast<const std::uint8_t*>(texture.pcData),
                                      reinterpret_cast<const std::uint8_t*>(texture.pcData) + texture.mWidth);
  const cv::Mat colours = cv::imdecode(png, cv::IMREAD_COLOR);  // blue first
  ASSERT_EQ(colours.size(), cv::Size(33, 33));
  const auto expected = ball(0);
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const auto& uv = mesh.mTextureCoords[0][v];  // assimp turns v upwards
    const int x = static_cast<int>(uv.x * 33.0F), y = static_cast<int>((1.0F - uv.y) * 33.0F);
    const auto side = static_cast<unsigned>(lattice_side(kLevel));
    ASSERT_EQ(x, 2 * static_cast<int>(v % side));
    ASSERT_EQ(y, 2 * static_cast<int>(v / side));
    const auto& pixel = colours.at<cv::Vec3b>(y, x);
    ASSERT_EQ((Colour{pixel[2], pixel[1], pixel[0]}), expected.colours[static_cast<std::size_t>(33 * y + x)]);
  }
}

TEST_F(ClipExportTest, ObjFilesAreClosedAndNumberedAsTheTake) {
  const auto report = run(ClipFormat::obj, "sequence");
  EXPECT_EQ(report.files, 12U);
  const auto lattice = weld_lattice(kLevel);
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto name = "sequence/frame0000" + std::to_string(kFirst + frame);
    const auto expected = ball(frame);
    const auto mesh = read_mesh(folder_ / (name + ".obj"));
    EXPECT_TRUE(topology_of(mesh).is_sphere());
    EXPECT_GT(signed_volume(mesh), 0.0);
    const auto& scene = open(name + ".obj", aiProcess_JoinIdenticalVertices);
    const auto& read = *scene.mMeshes[0];
    EXPECT_EQ(read.mNumFaces, lattice.triangles.size());
    for (unsigned v = 0; v < read.mNumVertices; ++v) {
      const auto& uv = read.mTextureCoords[0][v];
      const int x = static_cast<int>(uv.x * 33.0F), y = static_cast<int>((1.0F - uv.y) * 33.0F);
      const auto sample = static_cast<std::size_t>(y / 2 * 17 + x / 2);
      ASSERT_LT((vector_of(read.mVertices[v]) - expected.positions[sample]).norm(), kSame);
      ASSERT_GT(vector_of(read.mNormals[v]).dot(expected.normals[sample]), 0.999F);
    }
    aiString picture;
    ASSERT_EQ(scene.mMaterials[read.mMaterialIndex]->GetTexture(aiTextureType_DIFFUSE, 0, &picture), aiReturn_SUCCESS);
    const cv::Mat colours = cv::imread((folder_ / "sequence" / picture.C_Str()).string());
    ASSERT_EQ(colours.size(), cv::Size(33, 33));
    EXPECT_EQ(colours.at<cv::Vec3b>(0, 7)[2], frame);
  }
}

TEST_F(ClipExportTest, PlyFilesAreClosedWithColours) {
  run(ClipFormat::ply, "sequence", 3);
  for (int frame = 0; frame < kFrames; ++frame) {
    const fs::path name = "sequence/frame0000" + std::to_string(kFirst + frame) + ".ply";
    const auto mesh = read_ply(folder_ / name);
    EXPECT_TRUE(topology_of(mesh).is_sphere());
    const auto lattice = weld_lattice(3);
    const auto expected = ball(frame);
    const auto& read = *open(name).mMeshes[0];
    ASSERT_EQ(read.mNumVertices, lattice.sample_of_vertex.size());
    for (unsigned v = 0; v < read.mNumVertices; ++v) {
      const auto x = lattice.sample_of_vertex[v] % 9, y = lattice.sample_of_vertex[v] / 9;
      ASSERT_LT((vector_of(read.mVertices[v]) - expected.positions[2 * y * 17 + 2 * x]).norm(), kSame);
      ASSERT_NEAR(read.mColors[0][v].r * 255.0F, expected.colours[4 * y * 33 + 4 * x][0], 0.6F);
    }
  }
}

TEST_F(ClipExportTest, VertexAnimationTexturePlaysAsItsJsonSays) {
  run(ClipFormat::vat, "ball_vat");
  const auto json = nlohmann::json::parse(std::ifstream(folder_ / "ball_vat" / "ball_vat-remap_info.json"));
  ASSERT_EQ(json["os-remap"]["Frames"], kFrames);
  EXPECT_EQ(json["animations"]["ball_vat"]["framerate"], kFps);
  EXPECT_EQ(json["animations"]["ball_vat"]["endFrame"], kFrames - 1);
  const auto& scene = open("ball_vat/ball_vat.glb");
  const auto& mesh = *scene.mMeshes[0];
  ASSERT_EQ(mesh.mNumVertices, lattice_size(kLevel));
  const cv::Mat offsets = cv::imread((folder_ / "ball_vat" / "ball_vat_vat.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat normals = cv::imread((folder_ / "ball_vat" / "ball_vat_vnrm.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(offsets.type(), CV_16UC3);
  ASSERT_EQ(normals.size(), offsets.size());
  const int rows = json["layout"]["rows_per_frame"];
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto expected = ball(frame);
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const auto& uv = mesh.mTextureCoords[1][v];
      const int x = static_cast<int>(uv.x * static_cast<float>(offsets.cols));
      const int y = static_cast<int>((1.0F - uv.y) * static_cast<float>(offsets.rows)) + frame * rows;
      const auto &pixel = offsets.at<cv::Vec3w>(y, x), &bent = normals.at<cv::Vec3w>(y, x);  // blue first
      Eigen::Vector3f place = vector_of(mesh.mVertices[v]), normal;
      for (int axis = 0; axis < 3; ++axis) {
        const float low = json["os-remap"]["Min"][static_cast<std::size_t>(axis)],
                    high = json["os-remap"]["Max"][static_cast<std::size_t>(axis)];
        place[axis] += low + (high - low) * static_cast<float>(pixel[2 - axis]) / 65535.0F;
        normal[axis] = 2.0F * static_cast<float>(bent[2 - axis]) / 65535.0F - 1.0F;
      }
      ASSERT_LT((z_up(place) - expected.positions[v]).norm(), kSame) << frame;
      ASSERT_GT(z_up(normal).dot(expected.normals[v]), 0.999F);
    }
    EXPECT_EQ(
        cv::imread(
            (folder_ / "ball_vat/ball_vat_colour" / ("frame0000" + std::to_string(kFirst + frame) + ".png")).string())
            .at<cv::Vec3b>(0, 7)[2],
        frame);
  }
}

TEST_F(ClipExportTest, OtherProfilesKeepFramesRatesAndStatuses) {
  const std::vector<std::pair<ClipFormat, float>> formats{{ClipFormat::master, 5e-5F}, {ClipFormat::float32, 1e-6F}};
  for (const auto& [format, tolerance] : formats) {
    export_clip(*video_, {.format = format, .output = folder_ / "other.mkv", .first_frame = 1, .end_frame = 4});
    GeometryVideoReader other(folder_ / "other.mkv");
    ASSERT_EQ(other.frame_count(), 3);
    EXPECT_EQ(other.header().fps, kFps);
    EXPECT_EQ(other.header().first_frame, kFirst + 1);
    EXPECT_TRUE(other.header().statuses[1].interpolated);
    for (int i = 0; i < 3; ++i) {
      const auto expected = video_->read(i + 1), image = other.read(i);
      for (std::size_t v = 0; v < image.positions.size(); ++v)
        ASSERT_LT((image.positions[v] - expected.positions[v]).norm(), tolerance) << static_cast<int>(format);
    }
  }
}

TEST_F(ClipExportTest, AtAnotherRateKeepsTheLengthInTime) {
  for (const auto& [fps, frames] : {std::pair(25.0, 7), std::pair(6.25, 2), std::pair(10.0, 3)}) {
    const auto report =
        export_clip(*video_, {.format = ClipFormat::master, .output = folder_ / "rate.mkv", .fps = fps});
    GeometryVideoReader other(folder_ / "rate.mkv");
    ASSERT_EQ(other.frame_count(), frames) << fps;
    EXPECT_EQ(report.frames, static_cast<std::size_t>(frames));
    EXPECT_EQ(other.header().fps, fps);
  }
  EXPECT_THROW(export_clip(*video_, {.output = folder_ / "no.glb", .fps = -1.0}), InvalidInput);
}

TEST_F(ClipExportTest, MasterAsAviComesBackWithItsFilesBeside) {
  const auto report = run(ClipFormat::master, "other.avi");
  EXPECT_EQ(report.files, 3U);
  GeometryVideoReader other(folder_ / "other.avi");
  EXPECT_TRUE(other.header().statuses[2].interpolated);
  EXPECT_LT((other.read(3).positions[40] - ball(3).positions[40]).norm(), 1e-4F);
}

TEST_F(ClipExportTest, StreamOfASteadyMotionStaysWithinTwoMillimetres) {
  std::vector<GeometryImage> images;
  for (int i = 0; i < 9; ++i)  // more frames than the filter's
    images.push_back(test::round_geometry_image(
        {.level = 6, .colour_level = 6, .centre = {0.02F * static_cast<float>(i), 0.0F, 1.0F}}));
  write_geometry_video(folder_ / "steady.mkv", images);
  GeometryVideoReader steady(folder_ / "steady.mkv");
  export_clip(steady, {.format = ClipFormat::stream, .output = folder_ / "stream.mkv"});
  GeometryVideoReader stream(folder_ / "stream.mkv");
  for (const int i : {8, 0, 4}) {
    const auto read = stream.read(i);
    for (std::size_t v = 0; v < images[0].positions.size(); ++v)
      ASSERT_LT((read.positions[v] - images[static_cast<std::size_t>(i)].positions[v]).norm(), 2e-3F) << i;
  }
  EXPECT_THROW(run(ClipFormat::stream, "coarse.mkv"), InvalidInput);  // level 4
  EXPECT_FALSE(fs::exists(folder_ / "coarse.mkv"));
}

TEST_F(ClipExportTest, PaperModeIsTheAviWithItsJson) {
  const auto report = run(ClipFormat::paper, "paper.avi");
  EXPECT_EQ(report.files, 2U);
  PaperVideoReader paper(folder_ / "paper.avi", folder_ / "paper.json");
  EXPECT_EQ(paper.header().frame_count(), kFrames);
  EXPECT_LT((paper.read(2).positions[8 * 17 + 8] - ball(2).positions[8 * 17 + 8]).cwiseAbs().maxCoeff(), 0.0051F);
}

TEST_F(ClipExportTest, OneFrameIsAMeshWithoutAnimation) {
  export_clip(*video_, {.format = ClipFormat::glb, .output = folder_ / "one.glb", .first_frame = 3, .end_frame = 4});
  const auto& scene = open("one.glb");
  EXPECT_EQ(scene.mNumAnimations, 0U);
  EXPECT_EQ(scene.mMeshes[0]->mNumAnimMeshes, 0U);
  EXPECT_LT((z_up(vector_of(scene.mMeshes[0]->mVertices[5])) - ball(3).positions[5]).norm(), kSame);
}

TEST_F(ClipExportTest, RefusesFramesAndLevelsThatAreNotThere) {
  const auto with = [&](int first, int end, int level) {
    export_clip(*video_, {.output = folder_ / "no.glb", .first_frame = first, .end_frame = end, .level = level});
  };
  EXPECT_THROW(with(0, 5, 0), InvalidInput);
  EXPECT_THROW(with(-1, 2, 0), InvalidInput);
  EXPECT_THROW(with(2, 2, 0), InvalidInput);
  EXPECT_THROW(with(0, 4, kLevel + 1), InvalidInput);
  EXPECT_FALSE(fs::exists(folder_ / "no.glb"));
}

TEST_F(ClipExportTest, StoppedOrWithoutRoomItLeavesNothingHalfMade) {
  std::stop_source stop;
  int read = 0;
  const ClipExportOptions options{.output = folder_ / "no.glb",
                                  .progress = [&](std::size_t, std::size_t) { read += stop.request_stop() ? 1 : 0; },
                                  .stop = stop.get_token()};
  EXPECT_THROW(export_clip(*video_, options), std::system_error);
  EXPECT_EQ(read, 1);
  fs::create_directory(folder_ / "taken.glb");
  EXPECT_THROW(run(ClipFormat::glb, "taken.glb"), std::system_error);  // a folder has that name
  std::vector<std::string> left;
  for (const auto& entry : fs::directory_iterator(folder_)) left.push_back(entry.path().filename());
  EXPECT_THAT(left, testing::UnorderedElementsAre("geometry.mkv", "taken.glb"));
}

}  // namespace
}  // namespace rotunda::recon
