#include "simulator/people/board_prop.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "config/errors.h"
#include "simulator/people/texture_atlas.h"

namespace rotunda::simulator {
namespace {

constexpr double kTexelsAMetre = 2000.0;
constexpr double kCell = 0.020;         // metres, of the surface's grid: lenses bend its straight lines
constexpr int kInk = 56, kPaper = 237;  // sRGB of matt black ink (4 % reflectance) and paper (85 %)
constexpr std::array kDictionaries = {std::pair{"DICT_4X4_50", cv::aruco::DICT_4X4_50},
                                      std::pair{"DICT_4X4_100", cv::aruco::DICT_4X4_100},
                                      std::pair{"DICT_5X5_50", cv::aruco::DICT_5X5_50},
                                      std::pair{"DICT_5X5_100", cv::aruco::DICT_5X5_100},
                                      std::pair{"DICT_6X6_250", cv::aruco::DICT_6X6_250},
                                      std::pair{"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL}};

cv::Ptr<cv::aruco::Dictionary> dictionary_of(const CharucoPattern& pattern) {
  for (const auto& [name, number] : kDictionaries) {
    if (pattern.dictionary != name) continue;
    auto dictionary = cv::aruco::getPredefinedDictionary(number);
    if (pattern.columns * pattern.rows / 2 > dictionary->bytesList.rows)
      throw InvalidInput(fmt::format("{} has {} markers; a board of {} x {} squares needs {}", name,
                                     dictionary->bytesList.rows, pattern.columns, pattern.rows,
                                     pattern.columns * pattern.rows / 2));
    return dictionary;
  }
  throw InvalidInput("there is no dictionary " + pattern.dictionary);
}

cv::Mat face_picture(const CarriedBoard& plate, const CharucoPattern& pattern) {
  const auto texels = [](double metres) { return static_cast<int>(std::lround(metres * kTexelsAMetre)); };
  const cv::Size printed(pattern.columns * texels(pattern.square), pattern.rows * texels(pattern.square));
  const cv::Size whole(texels(plate.width), texels(plate.height));
  if (printed.width > whole.width || printed.height > whole.height || !(pattern.marker < pattern.square))
    throw InvalidInput("the board's pattern does not fit on its plate");
  const auto board = cv::aruco::CharucoBoard::create(pattern.columns, pattern.rows, static_cast<float>(pattern.square),
                                                     static_cast<float>(pattern.marker), dictionary_of(pattern));
  cv::Mat pattern_picture, grey(whole, CV_8UC1, cv::Scalar(255)), face;
  board->draw(printed, pattern_picture, 0, 1);
  const cv::Rect middle((whole.width - printed.width) / 2, (whole.height - printed.height) / 2, printed.width,
                        printed.height);
  pattern_picture.copyTo(grey(middle));
  grey.convertTo(grey, CV_8U, (kPaper - kInk) / 255.0, kInk);
  cv::cvtColor(grey, face, cv::COLOR_GRAY2RGB);
  return face;
}

// A grid over the face, one over the back, strips between their rims.
struct BoxGrid {
  int columns, rows;
  std::uint32_t at(int x, int y, bool back) const {
    return static_cast<std::uint32_t>((back ? (columns + 1) * (rows + 1) : 0) + y * (columns + 1) + x);
  }
};

void add_vertices(const CarriedBoard& plate, const BoxGrid& grid, recon::TriangleMesh& mesh) {
  for (const bool back : {false, true})
    for (int y = 0; y <= grid.rows; ++y)
      for (int x = 0; x <= grid.columns; ++x) {
        const double across = static_cast<double>(x) / grid.columns - 0.5,
                     up = static_cast<double>(y) / grid.rows - 0.5;
        mesh.positions.push_back(
            Eigen::Vector3d(across * plate.width, up * plate.height, back ? -plate.thickness : 0.0).cast<float>());
        mesh.normals.emplace_back(0.0F, 0.0F, back ? -1.0F : 1.0F);  // the rim belongs to the faces
        mesh.colours.push_back({kPaper, kPaper, kPaper});
      }
}

void add_quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d, recon::TriangleMesh& mesh) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

void add_faces(const BoxGrid& grid, recon::TriangleMesh& mesh) {
  for (const bool back : {false, true})
    for (int y = 0; y < grid.rows; ++y)
      for (int x = 0; x < grid.columns; ++x) {
        const auto a = grid.at(x, y, back), b = grid.at(x + 1, y, back), c = grid.at(x + 1, y + 1, back),
                   d = grid.at(x, y + 1, back);
        back ? add_quad(a, d, c, b, mesh) : add_quad(a, b, c, d, mesh);
      }
}

void add_rim(const BoxGrid& grid, recon::TriangleMesh& mesh) {
  const auto strip = [&](int x0, int y0, int x1, int y1) {
    add_quad(grid.at(x0, y0, true), grid.at(x1, y1, true), grid.at(x1, y1, false), grid.at(x0, y0, false), mesh);
  };
  for (int x = 0; x < grid.columns; ++x) {
    strip(x, 0, x + 1, 0);
    strip(x + 1, grid.rows, x, grid.rows);
  }
  for (int y = 0; y < grid.rows; ++y) {
    strip(grid.columns, y, grid.columns, y + 1);
    strip(0, y + 1, 0, y);
  }
}

recon::TriangleMesh plate_mesh(const CarriedBoard& plate) {
  const BoxGrid grid{static_cast<int>(std::lround(plate.width / kCell)),
                     static_cast<int>(std::lround(plate.height / kCell))};
  recon::TriangleMesh mesh;
  add_vertices(plate, grid, mesh);
  add_faces(grid, mesh);
  add_rim(grid, mesh);
  return mesh;
}

}  // namespace

Figure board_figure(const CarriedBoard& plate, const CharucoPattern& pattern) {
  Figure figure;
  figure.bind = plate_mesh(plate);
  figure.openness.assign(figure.bind.positions.size(), 1.0F);
  const cv::Mat foam(8, 8, CV_8UC3, cv::Scalar::all(kPaper));
  const auto atlas = pack_pictures({face_picture(plate, pattern), foam});
  figure.texture.picture = atlas.picture;
  for (const auto& triangle : figure.bind.triangles) {
    const bool is_face =
        std::all_of(triangle.begin(), triangle.end(), [&](auto v) { return figure.bind.normals[v].z() > 0.0F; });
    for (const auto v : triangle) {
      const Eigen::Vector2d at = figure.bind.positions[v].head<2>().cast<double>();
      const Eigen::Vector2d texel(kTexelsAMetre * (at.x() + 0.5 * plate.width),
                                  kTexelsAMetre * (0.5 * plate.height - at.y()));
      figure.texture.corners.push_back(is_face ? atlas.at(0, texel.cast<float>()) : atlas.at(1, {4.0F, 4.0F}));
    }
  }
  return figure;
}

recon::TriangleMesh carried(const recon::TriangleMesh& bind, const Eigen::Isometry3d& world_from_board) {
  recon::TriangleMesh mesh = bind;
  const Eigen::Isometry3f transform = world_from_board.cast<float>();
  for (auto& position : mesh.positions) position = transform * position;
  for (auto& normal : mesh.normals) normal = transform.linear() * normal;
  return mesh;
}

std::vector<Eigen::Vector3d> board_corners(const CharucoPattern& pattern) {
  std::vector<Eigen::Vector3d> corners;
  for (int row = 1; row < pattern.rows; ++row)
    for (int column = 1; column < pattern.columns; ++column)
      corners.emplace_back((column - 0.5 * pattern.columns) * pattern.square,
                           (0.5 * pattern.rows - row) * pattern.square, 0.0);
  return corners;
}

std::string board_yaml(const CharucoPattern& pattern) {
  return fmt::format("type: charuco\nsquares: [{}, {}]\nsquare_mm: {}\nmarker_mm: {}\ndictionary: {}\n",
                     pattern.columns, pattern.rows, pattern.square * 1000.0, pattern.marker * 1000.0,
                     pattern.dictionary);
}

void write_board(const std::filesystem::path& file, const CharucoPattern& pattern) {
  errno = 0;
  std::ofstream stream(file, std::ios::binary);
  stream << board_yaml(pattern);
  if (!stream.flush())
    throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), file.string() + ": cannot be written");
}

}  // namespace rotunda::simulator
