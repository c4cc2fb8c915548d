// Claims about recon/mesh/scan_file: scans with pictures, materials and colours, as programs write them.
#include "recon/mesh/scan_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "config/errors.h"
#include "recon/mesh/mesh_file.h"
#include "tests/support/glb_writer.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr Colour kRed = {255, 0, 0}, kGreen = {0, 255, 0}, kBlue = {0, 0, 255}, kWhite = {255, 255, 255};
constexpr Colour kRedAndBlue = {188, 0, 188};  // half the light of each

class ScanFile : public testing::Test {
 protected:
  ScanFile() {
    fs::create_directories(folder_);
    cv::Mat quarters(64, 64, CV_8UC3, cv::Scalar(255, 255, 255));  // BGR; lower right: white
    quarters(cv::Rect(0, 0, 32, 32)).setTo(cv::Scalar(0, 0, 255));
    quarters(cv::Rect(32, 0, 32, 32)).setTo(cv::Scalar(0, 255, 0));
    quarters(cv::Rect(0, 32, 32, 32)).setTo(cv::Scalar(255, 0, 0));
    cv::imwrite((folder_ / "quarters.png").string(), quarters);
  }
  ~ScanFile() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  std::string bytes_of(const std::string& name) const {
    std::ifstream stream(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  fs::path folder_ = fs::temp_directory_path() / ("rotunda_scan_file_test_" + std::to_string(::getpid()));
};

// What is thrown speaks of the file.
std::string refusal(const fs::path& file) {
  try {
    read_scan(file);
  } catch (const CorruptData& error) {
    return error.what();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "nothing";
}

const char* const kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt .25 .25\nvt .75 .25\nvt .75 .75\nvt .25 .75\n";
const char* const kMaterials = "newmtl skin\nmap_Kd quarters.png\nnewmtl cloth\nKd 1 0 0\n";

TEST_F(ScanFile, ObjTakesItsPicturesColoursAndKeepsTheFilesTriangles) {
  write("scan.mtl", kMaterials);
  const auto scan =
      read_scan(write("scan.obj", std::string("mtllib scan.mtl\n") + kSquare +
                                      "usemtl skin\nf 1/1 2/2 3/3\nf 1/1 1/1 2/2\ng other\nf 1/1 3/3 4/4\n"));
  EXPECT_THAT(scan.notes, IsEmpty());
  EXPECT_EQ(scan.mesh.triangles, (Triangles{{0, 1, 2}, {0, 0, 1}, {0, 2, 3}}));
  EXPECT_THAT(scan.mesh.colours, ElementsAre(kBlue, kWhite, kGreen, kRed));  // v points upwards
}

TEST_F(ScanFile, TrianglesHaveTheFilesOrderThroughObjectsAndMaterials) {
  write("scan.mtl", kMaterials);
  const auto file = write("scan.obj", std::string("mtllib scan.mtl\n") + kSquare +
                                          "o a\nusemtl skin\nf 1/1 2/2 3/3 4/4\no b\nusemtl cloth\nf 4 3 2 1\no a\n"
                                          "usemtl skin\nf 1/1 3/3 4/4\nusemtl cloth\nf 3 2 1\n");
  EXPECT_EQ(read_scan(file).mesh.triangles,
            (Triangles{{0, 1, 2}, {0, 2, 3}, {3, 2, 1}, {3, 1, 0}, {0, 2, 3}, {2, 1, 0}}));
  EXPECT_EQ(read_scan(file).mesh.triangles, read_mesh(file).triangles);
}

TEST_F(ScanFile, TrianglesThatAreWrittenAsQuadsHaveTheirNumbersAndColours) {
  write("scan.mtl", kMaterials);
  const auto scan = read_scan(write("scan.obj", std::string("mtllib scan.mtl\n") + kSquare +
                                                    "usemtl skin\nf 1/1 2/2 3/3 -2/-2\nf 1/1 3/3 4/4\nf 2 2 2\n"));
  EXPECT_EQ(scan.mesh.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}, {1, 1, 1}}));
  EXPECT_THAT(scan.mesh.colours, ElementsAre(kBlue, kWhite, kGreen, kRed));
}

TEST_F(ScanFile, PlacesWhereChartsMeetAreOneAndHaveTheMeanOfThem) {
  write("scan.mtl", kMaterials);
  const auto scan = read_scan(write("scan.obj", std::string("mtllib scan.mtl\n") + kSquare +
                                                    "vt .2 .2\nusemtl skin\nf 1/4 2/4 3/4\nf 1/5 3/1 4/5\n"));
  ASSERT_EQ(scan.mesh.positions.size(), 4U);
  EXPECT_THAT(scan.mesh.colours, ElementsAre(kRedAndBlue, kRed, kRedAndBlue, kBlue));
}

TEST_F(ScanFile, PicturesRepeat) {
  write("scan.mtl", kMaterials);
  const auto scan = read_scan(
      write("scan.obj",
            "mtllib scan.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 3.25 -1.75\nvt 3.75 -1.75\nvt 3.75 -1.25\n"
            "vt 3.25 -1.25\nusemtl skin\nf 1/1 2/2 3/3 4/4\n"));
  EXPECT_THAT(scan.mesh.colours, ElementsAre(kBlue, kWhite, kGreen, kRed));
}

TEST_F(ScanFile, APictureFinerThanTheMeshIsAveragedInLinearLight) {
  cv::Mat board(64, 64, CV_8UC3, cv::Scalar::all(0));
  for (int y = 0; y < 64; ++y)
    for (int x = y % 2; x < 64; x += 2) board.at<cv::Vec3b>(y, x) = cv::Vec3b::all(255);
  cv::imwrite((folder_ / "board.png").string(), board);
  write("scan.mtl", "newmtl skin\nmap_Kd board.png\n");
  const auto scan =
      read_scan(write("scan.obj", std::string("mtllib scan.mtl\n") + kSquare + "usemtl skin\nf 1/1 2/2 3/3 4/4\n"));
  for (const auto& colour : scan.mesh.colours) EXPECT_NEAR(colour[0], 188, 6);
}

TEST_F(ScanFile, ObjWithColoursOfMaterialsOrVertices) {
  write("scan.mtl", kMaterials);
  const auto cloth =
      read_scan(write("cloth.obj", std::string("mtllib scan.mtl\n") + kSquare + "usemtl cloth\nf 1 2 3\n"));
  EXPECT_THAT(cloth.mesh.colours, ElementsAre(kRed, kRed, kRed, testing::_));
  const auto painted = read_scan(write("painted.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nf 1 2 3\n"));
  EXPECT_THAT(painted.mesh.colours, ElementsAre(kRed, kGreen, kBlue));
  const auto plain = read_scan(write("plain.obj", std::string(kSquare) + "f 1/1 2/2 3/3\n"));
  EXPECT_THAT(plain.mesh.colours, IsEmpty());
}

TEST_F(ScanFile, WhatIsMissingIsToldAndOtherColoursStay) {
  write("scan.mtl", "newmtl skin\nKd 1 0 0\nmap_Kd -s 1 1 1 C:\\scans\\my skin.png\n");
  const auto text = std::string("mtllib scan.mtl\n") + kSquare + "usemtl skin\nf 1/1 2/2 3/3 4/4\n";
  const auto red = read_scan(write("scan.obj", text));
  EXPECT_THAT(red.notes, Contains(HasSubstr("my skin.png is missing")));
  EXPECT_THAT(red.mesh.colours, ElementsAre(kRed, kRed, kRed, kRed));
  fs::copy_file(folder_ / "quarters.png", folder_ / "my skin.png");
  EXPECT_THAT(read_scan(folder_ / "scan.obj").mesh.colours, ElementsAre(kBlue, kWhite, kGreen, kRed));
  fs::remove(folder_ / "scan.mtl");
  const auto grey = read_scan(folder_ / "scan.obj");
  EXPECT_THAT(grey.notes, Contains(HasSubstr("scan.mtl are missing")));
  EXPECT_THAT(grey.mesh.colours, IsEmpty());
}

std::string ply(const std::string& of_vertices, const std::string& of_faces, const std::string& data,
                const std::string& pictures = "comment TextureFile quarters.png\n") {
  return "ply\nformat ascii 1.0\n" + pictures +
         "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
         "property uchar green\nproperty uchar blue\n" +
         of_vertices + "element face 2\nproperty list uchar int vertex_indices\n" + of_faces + "end_header\n" + data;
}
const char* const kAtCorners = "property list uchar float texcoord\n";
const char* const kCornersOfBoth =
    "0 0 0 9 8 7\n1 0 0 9 8 7\n1 1 0 9 8 7\n0 1 0 9 8 7\n3 0 1 2 6 .25 .25 .75 .25 .75 .75\n3 0 2 3 6 .25 .25 .75 .75 "
    ".25 .75\n";

TEST_F(ScanFile, PlyHasCoordinatesAtCornersOrVertices) {
  const auto corners = read_scan(write("corners.ply", ply("", kAtCorners, kCornersOfBoth)));
  EXPECT_THAT(corners.mesh.colours, ElementsAre(kBlue, kWhite, kGreen, kRed));
  EXPECT_EQ(corners.mesh.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
  for (const auto& [u, v] : {std::pair("s", "t"), std::pair("u", "v"), std::pair("texture_u", "texture_v")}) {
    const auto properties = std::string("property float ") + u + "\nproperty float " + v + "\n";
    const auto vertices = read_scan(write("vertices.ply", ply(properties, "",
                                                              "0 0 0 9 8 7 .25 .25\n1 0 0 9 8 7 .75 .25\n"
                                                              "1 1 0 9 8 7 .75 .75\n0 1 0 9 8 7 .25 .75\n"
                                                              "3 0 1 2\n3 0 2 3\n")));
    EXPECT_THAT(vertices.mesh.colours, ElementsAre(kBlue, kWhite, kGreen, kRed)) << u;
  }
}

TEST_F(ScanFile, PlyWithSeveralPicturesOneOfThemMissing) {
  const auto numbers = std::string(kAtCorners) + "property int texnumber\n";
  const std::string data =
      "0 0 0 9 8 7\n1 0 0 9 8 7\n1 1 0 9 8 7\n0 1 0 9 8 7\n"
      "3 0 1 2 6 .25 .75 .25 .75 .25 .75 1\n3 0 2 3 6 .25 .25 .25 .25 .25 .25 0\n";
  const auto scan = read_scan(write("scan.ply", ply("", numbers, data,
                                                    "comment TextureFile nowhere.png\n"
                                                    "comment TextureFile quarters.png\n")));
  EXPECT_THAT(scan.notes, ElementsAre(HasSubstr("nowhere.png is missing")));
  EXPECT_EQ(scan.mesh.colours[1], kRed);
  EXPECT_EQ(scan.mesh.colours[3], (Colour{9, 8, 7}));
}

TEST_F(ScanFile, PlyWithoutPicturesIsReadAsEver) {
  const auto plain =
      write("plain.ply", ply("", "", "0 0 0 1 2 3\n1 0 0 4 5 6\n1 1 0 7 8 9\n0 1 0 1 1 1\n3 0 1 2\n3 0 0 2\n", ""));
  const auto scan = read_scan(plain);
  EXPECT_EQ(scan.mesh.colours, read_ply(plain).colours);
  EXPECT_EQ(scan.mesh.triangles, (Triangles{{0, 1, 2}, {0, 0, 2}}));
  EXPECT_THAT(scan.notes, IsEmpty());
}

// Two triangles that share no vertex, of one square: red and blue of the picture, whose v points downwards.
GlbWriter two_charts() {
  GlbWriter writer;
  const auto triangle = [&](const std::vector<float>& positions, float v) {
    return nlohmann::json{{"attributes",
                           {{"POSITION", writer.accessor(positions, "VEC3")},
                            {"TEXCOORD_0", writer.accessor<float>({.25F, v, .25F, v, .25F, v}, "VEC2")}}},
                          {"material", 0}};
  };
  writer.json["meshes"] = {{{"primitives", {triangle({0, 0, 0, 1, 0, 0, 1, 1, 0}, .25F)}}},
                           {{"primitives", {triangle({0, 0, 0, 1, 1, 0, 0, 1, 0}, .75F)}}}};
  writer.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  writer.json["textures"] = {{{"source", 0}}};
  writer.json["images"] = {{{"uri", "quarters.png"}}};
  writer.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 1}}};
  writer.json["scenes"] = {{{"nodes", {0, 1}}}};
  return writer;
}

TEST_F(ScanFile, GlbMeetsAtItsSeams) {
  const auto scan = read_scan(write("scan.glb", two_charts().glb()));
  EXPECT_THAT(scan.mesh.colours, ElementsAre(kRedAndBlue, kRed, kRedAndBlue, kRedAndBlue, kRedAndBlue, kBlue));
  EXPECT_EQ(scan.mesh.triangles, (Triangles{{0, 1, 2}, {3, 4, 5}}));
}

TEST_F(ScanFile, GlbHasItsNodesInPlaceAndMirroredOnesTurned) {
  auto writer = two_charts();
  writer.json["nodes"][0]["translation"] = {0, 2, 0};
  writer.json["nodes"][1]["scale"] = {-1, 1, 1};
  const auto scan = read_scan(write("scan", writer.glb()));  // told by its first bytes
  EXPECT_EQ(scan.mesh.positions[1], Eigen::Vector3f(1, 2, 0));
  EXPECT_EQ(scan.mesh.positions[4], Eigen::Vector3f(-1, 1, 0));
  EXPECT_EQ(scan.mesh.triangles, (Triangles{{0, 1, 2}, {3, 5, 4}}));
}

TEST_F(ScanFile, GlbWithoutItsPictureHasItsMaterialsColour) {
  auto writer = two_charts();
  writer.json["images"][0]["uri"] = "nowhere.png";
  writer.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0, 1, 0, 1};
  const auto scan = read_scan(write("scan.glb", writer.glb()));
  EXPECT_THAT(scan.notes, Contains(HasSubstr("nowhere.png is missing")));
  EXPECT_THAT(scan.mesh.colours, testing::Each(kGreen));
}

TEST_F(ScanFile, RefusesWhatItCannotReadByNameAndReason) {
  for (const char* extension : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}) {
    auto writer = two_charts();
    writer.json["extensionsUsed"] = writer.json["extensionsRequired"] = {extension};
    EXPECT_THAT(refusal(write("packed.glb", writer.glb())),
                testing::AllOf(HasSubstr("packed.glb"), HasSubstr(extension)));
  }
  EXPECT_THAT(refusal(write("wrong.glb", "GLTF2...............")), HasSubstr("wrong.glb: is no glTF"));
  EXPECT_THAT(refusal(write("wrong.obj", "\x89PNG\r\n")), HasSubstr("is no OBJ mesh"));
  EXPECT_THAT(refusal(write("wrong.ply", "glTX")), HasSubstr("is no PLY mesh"));
  EXPECT_THAT(refusal(folder_ / "nowhere.glb"), HasSubstr("there is no such file"));
  EXPECT_THAT(refusal(write("endless.obj",
                            std::string("mtllib ../../../../../../../../../../dev/zero\n") + kSquare + "f 1 2 3\n")),
              HasSubstr("is no file"));
  write("huge.ply", "ply\n");
  fs::resize_file(folder_ / "huge.ply", std::uintmax_t{5} << 30);
  EXPECT_THAT(refusal(folder_ / "huge.ply"), HasSubstr("at most 4 GiB"));
}

TEST_F(ScanFile, BrokenPicturesAreNamed) {
  write("scan.mtl", kMaterials);
  const auto file = write("scan.obj", std::string("mtllib scan.mtl\n") + kSquare + "usemtl skin\nf 1/1 2/2 3/3\n");
  const auto picture = bytes_of("quarters.png");
  write("quarters.png", picture.substr(0, 60));
  EXPECT_THAT(refusal(file), testing::AllOf(HasSubstr("quarters.png"), HasSubstr("cannot be decoded")));
  auto absurd = picture;
  absurd.replace(16, 4, "\x7F\xFF\xFF\xFF");
  write("quarters.png", absurd);
  EXPECT_THAT(read_scan(file).notes, Contains(HasSubstr("wider or higher than 16384")));
  write("quarters.png", "RIFF....WEBPVP8 ");
  EXPECT_THAT(read_scan(file).notes, Contains(HasSubstr("WebP; PNG and JPEG are read")));
}

TEST_F(ScanFile, NoCutFileAndNoChangedByteCrashesIt) {
  write("scan.mtl", kMaterials);
  const std::map<std::string, std::string> files = {
      {"scan.glb", two_charts().glb()},
      {"scan.ply", ply("", kAtCorners, kCornersOfBoth)},
      {"scan.obj", std::string("mtllib scan.mtl\n") + kSquare + "usemtl skin\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"}};
  for (const auto& [name, whole] : files) {
    int refused = 0;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      refused += refusal(write(name, whole.substr(0, at))) != "nothing" ? 1 : 0;
      auto changed = whole;
      changed[at] = std::array{'\0', '9', '-', '\xFF'}[at % 4];
      refusal(write(name, changed));
    }
    EXPECT_GT(refused, static_cast<int>(whole.size()) / 3) << name;
  }
}

}  // namespace
}  // namespace rotunda::recon
