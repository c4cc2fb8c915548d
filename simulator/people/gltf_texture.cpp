#include "simulator/people/gltf_texture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "capture/srgb.h"
#include "simulator/people/texture_atlas.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kPaintedTexels = 6;  // along an edge, of triangles with colours at their corners
constexpr int kMostTiles = 8;      // of a picture that repeats within a triangle

cv::Mat tinted(const cv::Mat& picture, const Vector3f& factor) {
  if (factor == Vector3f::Ones()) return picture;
  cv::Mat table(1, 256, CV_8UC3), result;
  for (int i = 0; i < 256; ++i)
    for (int c = 0; c < 3; ++c)
      table.at<cv::Vec3b>(i)[c] = capture::srgb8_of(
          static_cast<double>(capture::linear_table()[static_cast<std::size_t>(i)]) * static_cast<double>(factor[c]));
  cv::LUT(picture, table, result);
  return result;
}

cv::Mat plain(const Vector3f& linear) {
  return tinted(cv::Mat(4, 4, CV_8UC3, cv::Scalar::all(255)), linear);
}

// Texture coordinates of a triangle brought next to the picture: their least whole part taken off where it repeats.
std::array<Vector2f, 3> near_zero(std::array<Vector2f, 3> uv, const std::array<recon::PictureWrap, 2>& wrap) {
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    const auto kind = wrap[static_cast<std::size_t>(axis)];
    float low = std::floor(std::min({uv[0][axis], uv[1][axis], uv[2][axis]}));
    if (kind == recon::PictureWrap::mirrored) low = 2.0F * std::floor(low / 2.0F);
    for (auto& corner : uv)
      corner[axis] = kind == recon::PictureWrap::clamp ? std::clamp(corner[axis], 0.0F, 1.0F) : corner[axis] - low;
  }
  return uv;
}

cv::Mat tiled(const cv::Mat& picture, const cv::Size& tiles, const std::array<recon::PictureWrap, 2>& wrap) {
  if (tiles == cv::Size(1, 1)) return picture;
  cv::Mat result(picture.rows * tiles.height, picture.cols * tiles.width, CV_8UC3);
  for (int y = 0; y < tiles.height; ++y)
    for (int x = 0; x < tiles.width; ++x) {
      const bool flip_x = wrap[0] == recon::PictureWrap::mirrored && x % 2 == 1,
                 flip_y = wrap[1] == recon::PictureWrap::mirrored && y % 2 == 1;
      cv::Mat tile = picture;
      if (flip_x || flip_y) cv::flip(picture, tile, flip_x && flip_y ? -1 : flip_x ? 1 : 0);
      tile.copyTo(result(cv::Rect(x * picture.cols, y * picture.rows, picture.cols, picture.rows)));
    }
  return result;
}

recon::SurfaceMaterial material_of(const recon::GltfCharacter& character, const recon::CharacterPart& part) {
  return part.material < 0 ? recon::SurfaceMaterial{} : character.materials[static_cast<std::size_t>(part.material)];
}

// Nearest texel, linear: enough under colours at the corners, which are there because a picture says little.
Vector3d sample(const cv::Mat& picture, const Vector2f& uv) {
  const auto texel = [](float at, int size) {
    return std::clamp(static_cast<int>((at - std::floor(at)) * static_cast<float>(size)), 0, size - 1);
  };
  const auto& found = picture.at<cv::Vec3b>(texel(uv.y(), picture.rows), texel(uv.x(), picture.cols));
  return capture::linear_of(found);
}

Vector3d barycentric(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p) {
  const Vector3d u = b - a, v = c - a, w = p - a;
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), det = uu * vv - uv * uv;
  if (det <= 1e-30) return {1.0, 0.0, 0.0};
  const double s = (vv * w.dot(u) - uv * w.dot(v)) / det, t = (uu * w.dot(v) - uv * w.dot(u)) / det;
  return {1.0 - s - t, s, t};
}

SurfaceTexture painted(const recon::GltfCharacter& character, const recon::CharacterPart& part) {
  const auto material = material_of(character, part);
  recon::TriangleMesh mesh;
  mesh.positions = part.positions;
  mesh.triangles = part.triangles;
  return paint_surface(mesh, kPaintedTexels, [&](std::size_t triangle, const Vector3d& point) {
    const auto& t = part.triangles[triangle];
    const auto at = [&](std::size_t i) -> Vector3d { return part.positions[t[i]].cast<double>(); };
    const Vector3d share = barycentric(at(0), at(1), at(2), point);
    Vector3d linear = Vector3d::Zero();
    Vector2f uv = Vector2f::Zero();
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto corner = t[static_cast<std::size_t>(i)];
      linear += share[i] * part.colours[corner].head<3>().cast<double>();
      if (!part.uv.empty()) uv += static_cast<float>(share[i]) * part.uv[corner];
    }
    linear = linear.cwiseProduct(material.factor.cast<double>()).cwiseMax(0.0);
    if (material.picture >= 0 && !part.uv.empty())
      linear = linear.cwiseProduct(sample(character.pictures[static_cast<std::size_t>(material.picture)], uv));
    return Vector3d(linear.unaryExpr(&capture::srgb_of_linear));
  });
}

using Coordinates = std::vector<std::array<Vector2f, 3>>;  // of each triangle

Coordinates coordinates_of(const recon::CharacterPart& part, const recon::SurfaceMaterial& material) {
  Coordinates uv;
  for (const auto& t : part.triangles)
    uv.push_back(near_zero({part.uv[t[0]], part.uv[t[1]], part.uv[t[2]]}, material.wrap));
  return uv;
}

cv::Size tiles_for(const Coordinates& coordinates) {
  Vector2f most = Vector2f::Ones();
  for (const auto& triangle : coordinates)
    for (const auto& uv : triangle) most = most.cwiseMax(uv.cwiseMin(static_cast<float>(kMostTiles)));
  const auto whole = [](float tiles) { return std::max(1, static_cast<int>(std::ceil(tiles - 1e-4F))); };
  return {whole(most.x()), whole(most.y())};
}

// Collects the pictures of the parts, and where the corners of their triangles lie in them; then packs them.
class TextureCollector {
 public:
  explicit TextureCollector(const recon::GltfCharacter& character) : character_(character) {
    for (const auto& part : character.parts) {
      if (!is_textured(part)) continue;
      const auto need = tiles_for(coordinates_of(part, material_of(character, part)));
      auto& have = tiles_[part.material];
      have = {std::max(have.width, need.width), std::max(have.height, need.height)};
    }
    for (const auto& part : character.parts) take(part);
  }

  SurfaceTexture packed() const {
    const auto atlas = pack_pictures(pictures_);
    SurfaceTexture texture{atlas.picture, {}};
    for (std::size_t p = 0; p < corners_.size(); ++p)
      for (const auto& corner : corners_[p]) texture.corners.push_back(atlas.at(picture_of_[p], corner));
    return texture;
  }

 private:
  bool is_textured(const recon::CharacterPart& part) const {
    return part.colours.empty() && !part.uv.empty() && material_of(character_, part).picture >= 0;
  }
  void take(const recon::CharacterPart& part) {
    if (!part.colours.empty()) return take_painted(part);
    return is_textured(part) ? take_textured(part) : take_plain(part);
  }
  void take_painted(const recon::CharacterPart& part) {
    auto texture = painted(character_, part);
    picture_of_.push_back(pictures_.size());
    pictures_.push_back(std::move(texture.picture));
    corners_.push_back(std::move(texture.corners));
  }
  void take_textured(const recon::CharacterPart& part) {
    const auto material = material_of(character_, part);
    const auto& picture = character_.pictures[static_cast<std::size_t>(material.picture)];
    const auto& tiles = tiles_.at(part.material);
    share(part.material, [&] { return tiled(tinted(picture, material.factor), tiles, material.wrap); });
    const Vector2f size(static_cast<float>(picture.cols), static_cast<float>(picture.rows));
    const Vector2f most(static_cast<float>(tiles.width), static_cast<float>(tiles.height));
    auto& corners = corners_.emplace_back();
    for (const auto& triangle : coordinates_of(part, material))
      for (const auto& uv : triangle) corners.push_back(uv.cwiseMin(most).cwiseProduct(size));
  }
  void take_plain(const recon::CharacterPart& part) {
    const auto material = material_of(character_, part);
    Vector3f linear = material.factor;
    if (material.picture >= 0) {
      const auto& picture = character_.pictures[static_cast<std::size_t>(material.picture)];
      linear = linear.cwiseProduct(sample(picture, Vector2f::Zero()).cast<float>());
    }
    share(kPlain - part.material, [&] { return plain(linear); });
    corners_.emplace_back(3 * part.triangles.size(), Vector2f(2.0F, 2.0F));
  }
  template <class Make>
  void share(int key, const Make& make) {
    const auto [known, is_new] = shared_.try_emplace(key, pictures_.size());
    if (is_new) pictures_.push_back(make());
    picture_of_.push_back(known->second);
  }

  static constexpr int kPlain = -2;  // keys of plain materials lie below, those of textured ones above
  const recon::GltfCharacter& character_;
  std::map<int, cv::Size> tiles_;      // of a material's picture: as far as any of its parts needs
  std::map<int, std::size_t> shared_;  // a material's picture
  std::vector<cv::Mat> pictures_;
  std::vector<std::vector<Vector2f>> corners_;  // of each part, in the texels of its picture
  std::vector<std::size_t> picture_of_;         // of each part
};

}  // namespace

SurfaceTexture character_texture(const recon::GltfCharacter& character) {
  return TextureCollector(character).packed();
}

}  // namespace rotunda::simulator
