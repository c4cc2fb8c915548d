#include "simulator/people/texture_atlas.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace rotunda::simulator {
namespace {

constexpr int kMargin = 2;  // texels

cv::Size shrunk(const cv::Size& size, float scale) {
  const auto side = [&](int length) {
    return std::max(1, static_cast<int>(std::lround(static_cast<float>(length) * scale)));
  };
  return {side(size.width), side(size.height)};
}

// Shelves: the highest first, from left to right.
struct Shelves {
  std::vector<cv::Point> place;  // of the margin's corner
  cv::Size size;
};

Shelves shelve(const std::vector<cv::Mat>& pictures, float scale, int width) {
  std::vector<std::size_t> order(pictures.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return pictures[a].rows > pictures[b].rows; });
  Shelves shelves{std::vector<cv::Point>(pictures.size()), {0, 0}};
  int x = 0, y = 0, height = 0;
  for (const auto i : order) {
    const auto size = shrunk(pictures[i].size(), scale) + cv::Size(2 * kMargin, 2 * kMargin);
    if (x > 0 && x + size.width > width) {
      y += height;
      x = height = 0;
    }
    shelves.place[i] = {x, y};
    x += size.width;
    height = std::max(height, size.height);
    shelves.size = {std::max(shelves.size.width, x), y + height};
  }
  return shelves;
}

// About square.
int width_for(const std::vector<cv::Mat>& pictures, float scale, int largest) {
  double area = 0.0;
  int widest = 0;
  for (const auto& picture : pictures) {
    const auto size = shrunk(picture.size(), scale) + cv::Size(2 * kMargin, 2 * kMargin);
    area += static_cast<double>(size.width) * size.height;
    widest = std::max(widest, size.width);
  }
  return std::min(std::max(widest, static_cast<int>(std::ceil(1.1 * std::sqrt(area)))), largest);
}

}  // namespace

Eigen::Vector2f TextureAtlas::at(std::size_t index, const Eigen::Vector2f& texel) const {
  return place[index] + scale * texel;
}

TextureAtlas pack_pictures(const std::vector<cv::Mat>& pictures, int largest) {
  TextureAtlas atlas;
  auto shelves = shelve(pictures, atlas.scale, width_for(pictures, atlas.scale, largest));
  while (shelves.size.width > largest || shelves.size.height > largest) {
    atlas.scale *= 0.9F;
    shelves = shelve(pictures, atlas.scale, width_for(pictures, atlas.scale, largest));
  }
  atlas.picture = cv::Mat(shelves.size, CV_8UC3, cv::Scalar::all(0));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    cv::Mat fitted = pictures[i], framed;
    if (atlas.scale < 1.0F)
      cv::resize(pictures[i], fitted, shrunk(pictures[i].size(), atlas.scale), 0, 0, cv::INTER_AREA);
    cv::copyMakeBorder(fitted, framed, kMargin, kMargin, kMargin, kMargin, cv::BORDER_REPLICATE);
    framed.copyTo(atlas.picture(cv::Rect(shelves.place[i], framed.size())));
    atlas.place.emplace_back(static_cast<float>(shelves.place[i].x + kMargin),
                             static_cast<float>(shelves.place[i].y + kMargin));
  }
  return atlas;
}

}  // namespace rotunda::simulator
