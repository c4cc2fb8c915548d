#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <tuple>

#include "config/errors.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/people/gltf_performance.h"
#include "tests/support/glb_writer.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using nlohmann::json;
using testing::HasSubstr;

// A folder of its own for a test, gone afterwards.
class Gltf : public testing::Test {
 protected:
  Gltf() : folder(std::filesystem::temp_directory_path() / ("rotunda-gltf-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder);
  }
  ~Gltf() override { std::filesystem::remove_all(folder); }
  std::filesystem::path file(const std::string& bytes, const std::string& name = "anna.glb") const {
    GlbWriter::write(folder / name, bytes);
    return folder / name;
  }
  std::string refusal(const std::string& bytes, const std::string& act = "bend",
                      const std::string& name = "anna.glb") const {
    try {
      GltfPerformance(file(bytes, name), act);
    } catch (const CorruptData& error) {
      return error.what();
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "taken";
  }
  std::filesystem::path folder;
};

// A post of 1.6 m with a joint at half height, in the file's frame (y up): four corners low, amid and high. What lies
// low is carried by "hips", what lies high by "arm", what lies amid by both alike. "bend" turns the arm about z by 90
// degrees in 0.4 s and back; "jump" does it by steps, "spline" with flat tangents.
struct Post {
  GlbWriter glb;
  std::vector<Vector3f> corners;

  explicit Post(float unit = 1.0F, const std::vector<std::string>& clips = {"bend", "jump", "spline"}) {
    std::vector<float> positions, weights, uv;
    std::vector<std::uint8_t> joints;
    for (int level = 0; level < 3; ++level)
      for (int i = 0; i < 4; ++i) {
        const float x = i == 0 || i == 3 ? -0.1F : 0.1F, z = i < 2 ? -0.1F : 0.1F;
        corners.emplace_back(unit * x, unit * 0.8F * static_cast<float>(level), unit * z);
        positions.insert(positions.end(), corners.back().begin(), corners.back().end());
        joints.insert(joints.end(), {0, 1, 0, 0});
        const float arm = 0.5F * static_cast<float>(level);
        weights.insert(weights.end(), {1.0F - arm, arm, 0.0F, 0.0F});
        uv.insert(uv.end(), {static_cast<float>(i) / 4.0F, 1.0F - static_cast<float>(level) / 2.0F});
      }
    std::vector<std::uint16_t> indices;
    for (std::uint16_t level = 0; level < 2; ++level)
      for (std::uint16_t i = 0; i < 4; ++i) {
        const auto a = static_cast<std::uint16_t>(4 * level + i),
                   b = static_cast<std::uint16_t>(4 * level + (i + 1) % 4);
        for (const int corner : {+a, b + 4, +b, +a, a + 4, b + 4})
          indices.push_back(static_cast<std::uint16_t>(corner));
      }
    for (const int corner : {0, 1, 2, 0, 2, 3, 8, 10, 9, 8, 11, 10})
      indices.push_back(static_cast<std::uint16_t>(corner));
    auto& j = glb.json;
    j["meshes"] = {{{"primitives",
                     {{{"attributes",
                        {{"POSITION", glb.accessor(positions, "VEC3")},
                         {"JOINTS_0", glb.accessor(joints, "VEC4")},
                         {"WEIGHTS_0", glb.accessor(weights, "VEC4")},
                         {"TEXCOORD_0", glb.accessor(uv, "VEC2")}}},
                       {"indices", glb.accessor(indices, "SCALAR")},
                       {"material", 0}}}}}};
    j["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {1.0, 0.0, 0.0, 1.0}}}}}};
    j["nodes"] = {{{"name", "anna"},
                   {"mesh", 0},
                   {"skin", 0},
                   {"translation", {9, 9, 9}}},  // a skinned node's own place does not count
                  {{"name", "hips"}, {"children", {2}}},
                  {{"name", "arm"}, {"translation", {0.0, 0.8F * unit, 0.0}}}};
    j["scenes"] = {{{"nodes", {0, 1}}}};
    std::vector<float> inverse(32, 0.0F);
    for (std::size_t i = 0; i < 32; i += i % 16 == 15 ? 1 : 5) inverse[i] = 1.0F;
    inverse[16 + 13] = -0.8F * unit;
    j["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", glb.accessor(inverse, "MAT4")}}};
    const float half = std::numbers::sqrt2_v<float> / 2.0F;
    const std::vector<float> flat(4, 0.0F), keys = {0, 0, 0, 1, 0, 0, half, half, 0, 0, 0, 1};
    std::vector<float> spline;
    for (std::size_t k = 0; k < 3; ++k)
      for (const auto* from : {flat.data(), keys.data() + 4 * k, flat.data()})
        spline.insert(spline.end(), from, from + 4);
    for (const auto& clip : clips)
      add_clip(clip,
               clip == "spline" ? "CUBICSPLINE"
               : clip == "jump" ? "STEP"
                                : "LINEAR",
               clip == "spline" ? spline : keys);
  }
  void add_clip(const std::string& name, const char* interpolation, const std::vector<float>& rotations) {
    const int times = glb.accessor(std::vector<float>{1.0F, 1.4F, 1.8F}, "SCALAR");
    glb.json["animations"].push_back(
        {{"name", name},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}}},
         {"samplers",
          {{{"input", times}, {"output", glb.accessor(rotations, "VEC4")}, {"interpolation", interpolation}}}}});
  }
  json& primitive() { return glb.json["meshes"][0]["primitives"][0]; }
};

// In the file's frame: turned about z at the joint's height by the share of the arm, blended linearly.
Vector3f bent(const Vector3f& p, double angle) {
  const Vector3d joint(0, 0.8, 0), at = p.cast<double>();
  const Vector3d turned = joint + Eigen::AngleAxisd(angle, Vector3d::UnitZ()) * (at - joint);
  const double arm = at.y() / 1.6;
  return ((1.0 - arm) * at + arm * turned).cast<float>();
}

// World of a point of the file, given what the clip's box makes of the stage.
std::vector<Vector3f> on_stage(std::vector<Vector3f> points, const Vector3f& foot) {
  for (auto& p : points) p = Vector3f(p.z(), p.x(), p.y()) - foot;
  return points;
}

double farthest(const std::vector<Vector3f>& wanted, const std::vector<Vector3f>& found) {
  double most = 0.0;
  for (const auto& w : wanted) {
    double least = 1e9;
    for (const auto& f : found) least = std::min<double>(least, (w - f).norm());
    most = std::max(most, least);
  }
  return most;
}

TEST_F(Gltf, SkinsAsClosedFormSays) {
  const Post post;
  for (const auto& [act, share] : {std::tuple{"bend", 0.25}, {"jump", 0.0}, {"spline", 0.25 * 0.25 * (3 - 2 * 0.25)}}) {
    const GltfPerformance anna(file(post.glb.glb()), act);
    EXPECT_EQ(anna.frames(), 20);  // 0.8 s
    EXPECT_TRUE(anna.is_cyclic());
    ASSERT_EQ(anna.figures().size(), 1U);
    EXPECT_EQ(anna.figures()[0].bind.positions.size(), 12U);
    EXPECT_TRUE(recon::topology_of(anna.figures()[0].bind).is_sphere());
    EXPECT_GT(recon::signed_volume(anna.figures()[0].bind), 0.0);
    // The spline's quaternions are blended and then normalised, not turned evenly.
    const double half = std::numbers::pi / 4, blend = std::sin(half) * share;
    const double angle = std::string_view(act) == "spline"
                             ? 2.0 * std::atan2(blend, 1.0 - share + share * std::cos(half))
                             : share * std::numbers::pi / 2;
    std::vector<Vector3f> wanted;
    for (const auto& p : post.corners) wanted.push_back(bent(p, angle));
    const auto rest = anna.figures()[0].bind.positions;
    Vector3f foot = Vector3f::Zero();  // where the file's origin has come to
    for (const auto& p : rest) foot -= p / 12.0F;
    foot += Vector3f(0.0F, 0.0F, 0.8F);
    const auto found = anna.surfaces_at(0.1)[0].positions;
    EXPECT_LT(farthest(on_stage(wanted, foot), found), 1e-5) << act;
    EXPECT_LT(farthest(found, on_stage(wanted, foot)), 1e-5) << act;
    EXPECT_LT(farthest(anna.surfaces_at(0.9)[0].positions, found), 1e-5);  // 0.8 s later
  }
}

TEST_F(Gltf, StandsOnTheFloorAtTheMiddleInMetres) {
  const GltfPerformance anna(file(Post(100.0F).glb.glb()), "bend");
  EXPECT_THAT(anna.notes(), testing::Contains(HasSubstr("taken as centimetres")));
  Eigen::AlignedBox3f box;
  for (int i = 0; i < anna.frames(); ++i) {
    const auto surfaces = anna.surfaces_at(act_seconds(i));
    for (const auto& p : surfaces[0].positions) box.extend(p);
  }
  EXPECT_NEAR(box.min().z(), 0.0F, 1e-4F);
  Eigen::AlignedBox3f upright;
  const auto straight = anna.surfaces_at(0.0);
  for (const auto& p : straight[0].positions) upright.extend(p);
  EXPECT_NEAR(upright.max().z(), 1.6F, 1e-4F);
  EXPECT_NEAR(box.center().head<2>().norm(), 0.0F, 1e-3F);
  // The joint of the arm is where the file puts it, and turns as the clip says: about the file's z, our x.
  const auto joints = anna.joints_at(0.4);
  EXPECT_EQ(anna.joints()[1].parent, 0);
  EXPECT_NEAR(joints[1].position.z(), 0.8, 1e-4);
  EXPECT_LT(joints[1].rotation.angularDistance(
                Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX()))),
            1e-5);
}

TEST_F(Gltf, KeepsTexturesColoursAndSparseParts) {
  Post post;
  // One half red, one half green; the second primitive has colours at its corners and a sparse corner moved aside.
  cv::Mat halves(8, 8, CV_8UC3, cv::Scalar(0, 0, 255));
  halves.colRange(4, 8) = cv::Scalar(0, 255, 0);
  std::vector<uchar> png;
  cv::imencode(".png", halves, png);
  auto& j = post.glb.json;
  j["images"] = {{{"bufferView", post.glb.view(png.data(), png.size())}, {"mimeType", "image/png"}}};
  j["textures"] = {{{"source", 0}}};
  j["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}, {"alphaMode", "MASK"}}};
  const std::vector<float> triangle = {0.5F, 0, 0, 0.7F, 0, 0, 0.5F, 0.2F, 0};
  const std::vector<std::uint8_t> blue = {0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 255};
  const int place = post.glb.accessor(triangle, "VEC3");
  j["accessors"][static_cast<std::size_t>(place)]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", post.glb.view("\2\0\0", 4)}, {"componentType", 5121}}},
      {"values", {{"bufferView", post.glb.view(std::vector<float>{0.5F, 0.3F, 0}.data(), 12)}}}};
  j["meshes"].push_back(
      {{"primitives", {{{"attributes", {{"POSITION", place}, {"COLOR_0", post.glb.accessor(blue, "VEC4", true)}}}}}}});
  j["nodes"].push_back({{"name", "flag"}, {"mesh", 1}, {"scale", {1, 2, 1}}});
  j["scenes"][0]["nodes"].push_back(3);
  const GltfPerformance anna(file(post.glb.glb()), "bend");
  const auto& figure = anna.figures()[0];
  EXPECT_THAT(anna.notes(), testing::Contains(HasSubstr("transparency is left out")));
  ASSERT_EQ(figure.bind.positions.size(), 15U);
  EXPECT_NEAR(figure.bind.positions[14].z() - figure.bind.positions[12].z(), 0.6F, 1e-5F);  // 0.3 twice as high
  EXPECT_EQ(figure.bind.colours[14], (recon::Colour{0, 0, 255}));
  ASSERT_EQ(figure.texture.corners.size(), 3 * figure.bind.triangles.size());
  // Each triangle of the post shows the picture where its texture coordinates say.
  const auto colour_in = [&](std::size_t t) {
    const Eigen::Vector2f middle =
        (figure.texture.corners[3 * t] + figure.texture.corners[3 * t + 1] + figure.texture.corners[3 * t + 2]) / 3.0F;
    return figure.texture.picture.at<cv::Vec3b>(static_cast<int>(middle.y()), static_cast<int>(middle.x()));
  };
  EXPECT_EQ(colour_in(0), cv::Vec3b(255, 0, 0));  // u from 0 to 0.25
  EXPECT_EQ(colour_in(4), cv::Vec3b(0, 255, 0));  // u from 0.5 to 0.75
  EXPECT_NO_THROW(recon::write_ply(folder / "anna.ply", anna.surfaces_at(0.2)[0]));
}

TEST_F(Gltf, ReadsBuffersBesideAndInsideAndStaticMeshes) {
  Post post;
  post.glb.json["buffers"] = {{{"byteLength", post.glb.binary.size()}, {"uri", "anna%20post.bin"}}};
  GlbWriter::write(folder / "anna post.bin", post.glb.binary);
  EXPECT_EQ(refusal(post.glb.json.dump(), "bend", "anna.gltf"), "taken");
  std::filesystem::remove(folder / "anna post.bin");
  EXPECT_THAT(refusal(post.glb.json.dump(), "bend", "anna.gltf"), HasSubstr("buffers[0]: its file"));
  json still = json::parse(
      R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
  const GltfPerformance anna(file(still.dump(), "still.gltf"), "walk");
  EXPECT_EQ(anna.frames(), 1);
  EXPECT_EQ(anna.figures()[0].bind.triangles.size(), 1U);
}

TEST_F(Gltf, TellsTheClipsThereAre) {
  EXPECT_THAT(refusal(Post().glb.glb(), "walk"), HasSubstr("has no clip 'walk'; its clips: bend, jump, spline"));
  EXPECT_EQ(refusal(Post().glb.glb(), "Bend"), "taken");
}

TEST_F(Gltf, RefusesBadFilesNamingTheElement) {
  const auto with = [&](auto change) {
    Post post;
    change(post);
    return refusal(post.glb.glb());
  };
  EXPECT_THAT(with([](Post& p) { p.primitive()["indices"] = 99; }),
              HasSubstr("meshes[0].primitives[0].indices: there is no accessors[99]"));
  EXPECT_THAT(with([](Post& p) { p.primitive()["material"] = 9; }), HasSubstr("there is no materials[9]"));
  EXPECT_THAT(with([](Post& p) { p.glb.json["accessors"][0]["count"] = 1'000'000; }),
              HasSubstr("do not fit in the 144 bytes"));
  EXPECT_THAT(with([](Post& p) { p.glb.json["accessors"][0]["count"] = 1'000'000'000; }),
              HasSubstr("meshes[0].primitives[0].POSITION"));
  EXPECT_THAT(with([](Post& p) { p.glb.json["accessors"][0]["byteOffset"] = 1LL << 62; }), HasSubstr("absurd"));
  EXPECT_THAT(with([](Post& p) { p.glb.json["bufferViews"][0]["byteOffset"] = 1 << 29; }), HasSubstr("bufferViews[0]"));
  EXPECT_THAT(with([](Post& p) { p.glb.json["nodes"][2]["children"] = {1}; }), HasSubstr("its own ancestor"));
  EXPECT_THAT(with([](Post& p) { p.glb.json["nodes"][1]["children"] = {7}; }), HasSubstr("there is no nodes[7]"));
  EXPECT_THAT(with([](Post& p) {
                p.glb.json["skins"][0]["joints"] = {1, 77};
              }),
              HasSubstr("skins[0]: there is no nodes[77]"));
  EXPECT_THAT(with([](Post& p) { p.glb.json["extensionsRequired"] = {"KHR_draco_mesh_compression"}; }),
              HasSubstr("needs the extension KHR_draco"));
  EXPECT_THAT(with([](Post& p) { p.glb.json["asset"]["version"] = "1.0"; }), HasSubstr("glTF version 1.0"));
  EXPECT_THAT(with([](Post& p) {
                const float nan = std::numeric_limits<float>::quiet_NaN();
                std::memcpy(p.glb.binary.data() + 16, &nan, 4);
              }),
              HasSubstr("element 1 of accessors[0] is nan"));
  EXPECT_THAT(
      with([](Post& p) { p.glb.binary[p.glb.json["bufferViews"][1]["byteOffset"].get<std::size_t>() + 33] = 5; }),
      HasSubstr("vertex 8: joint 5 of 2"));
  EXPECT_THAT(with([](Post& p) {
                json deep = 1;
                for (int i = 0; i < 2000; ++i) deep = json::array({std::move(deep)});
                p.glb.json["extras"] = std::move(deep);
              }),
              HasSubstr("nests deeper"));
  EXPECT_THAT(refusal("PNG"), HasSubstr("is no glTF"));
  EXPECT_THROW(GltfPerformance("/nowhere.glb", "bend"), std::system_error);
}

// Once as it stands, and once with a header that owns up to the new size, so that what lies deeper has to notice.
TEST_F(Gltf, RefusesEveryTruncationAndSurvivesFlippedBytes) {
  const std::string whole = Post(1.0F, {"bend"}).glb.glb();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    auto cut = whole.substr(0, size);
    EXPECT_NE(refusal(cut), "taken") << size;
    const auto honest = static_cast<std::uint32_t>(size);
    if (size >= 12) std::memcpy(cut.data() + 8, &honest, 4);
    EXPECT_NE(refusal(cut), "taken") << size;
  }
  std::mt19937 random(1);
  for (int i = 0; i < 800; ++i) {
    std::string bytes = whole;
    for (int flips = 0; flips < 2; ++flips) bytes[random() % bytes.size()] ^= static_cast<char>(1U << (random() % 8));
    (void)refusal(bytes);
  }
}

}  // namespace
}  // namespace rotunda::simulator
