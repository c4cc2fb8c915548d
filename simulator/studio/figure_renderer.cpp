#include "simulator/studio/figure_renderer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "simulator/studio/sample_raster.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;
using Eigen::Vector4f;

constexpr int kBandRows = 16;       // of the picture
constexpr double kNear = 0.2;       // metres: what is nearer is not drawn
constexpr float kBrightest = 8.0F;  // of a sample: a glint may saturate its pixel, not its neighbours

// One drawing of the figures: a moment of the exposure and a place of the sampling grid.
struct Pass {
  float moment;           // 0 opening, 1 closing
  Eigen::Vector2f shift;  // of the figures, pixels
};

struct Passes {
  int factor = 1;  // samples a pixel along each axis, of each pass
  std::vector<Pass> all;
};

// As many moments as the fastest vertex goes 1.3 pixels in, and so many samples each that their number stays.
Passes passes_for(double way_px, int supersampling) {
  int count = 1;
  while (count < 8 && way_px > (count == 1 ? 0.2 : 1.3 * count)) count *= 2;
  Passes passes;
  passes.factor = std::max(1, static_cast<int>(std::lround(supersampling / std::sqrt(count))));
  constexpr std::array<int, 8> kReversed{0, 4, 2, 6, 1, 5, 3, 7};  // bits: moments and rows have nothing in common
  for (int k = 0; k < count; ++k) {
    const double column = (k + 0.5) / count - 0.5;
    const double row = (kReversed[static_cast<std::size_t>(k)] * count / 8 + 0.5) / count - 0.5;
    const double moment = ((k * 3) % count + 0.5) / count;
    passes.all.push_back({static_cast<float>(moment), (Vector2d(column, row) / passes.factor).cast<float>()});
  }
  return passes;
}

// A vertex from the box's corner, in pixels.
struct BoxCorner {
  float x, y, nearness;
};
struct BoxVertex {
  BoxCorner opening, closing;
};

BoxCorner in_box(const SeenPoint& seen, const cv::Rect& box) {
  return {static_cast<float>(seen.pixel.x() + 0.5 - box.x), static_cast<float>(seen.pixel.y() + 0.5 - box.y),
          static_cast<float>(seen.depth > kNear ? 1.0 / seen.depth : 0.0)};
}

struct DrawnTriangle {
  std::uint32_t figure, triangle;
  std::array<std::uint32_t, 3> vertices;
};

// Everything a band needs, made once a picture.
class Drawing {
 public:
  Drawing(const std::vector<Figure>& figures, const std::vector<bool>& is_closed, const LitFigures& lit,
          const std::vector<SeenFigure>& seen, const cv::Rect& box, const Passes& passes)
      : figures_(figures), seen_(seen), box_(box), passes_(passes) {
    for (const auto& figure : seen_) {
      auto& vertices = vertices_.emplace_back(figure.opening.size());
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), 2048), [&](const auto& range) {
        for (std::size_t v = range.begin(); v < range.end(); ++v)
          vertices[v] = {in_box(figure.opening[v], box_), in_box(figure.closing[v], box_)};
      });
    }
    by_band_.resize(static_cast<std::size_t>((box_.height + kBandRows - 1) / kBandRows));
    for (std::size_t figure = 0; figure < seen_.size(); ++figure) sort_into_bands(figure, lit, is_closed[figure]);
  }

  std::size_t bands() const { return by_band_.size(); }

  void draw(std::size_t band, cv::Mat& rgba) const {
    const int from = static_cast<int>(band) * kBandRows, to = std::min(from + kBandRows, box_.height);
    cv::Mat rows = rgba.rowRange(from, to);
    rows.setTo(cv::Scalar::all(0.0));
    SampleRaster raster(box_.width * passes_.factor, (to - from) * passes_.factor);
    std::vector<BandTriangle> triangles;
    for (const std::uint32_t number : by_band_[band]) triangles.push_back(gathered(drawn_[number]));
    for (const Pass& pass : passes_.all) {
      for (std::size_t i = 0; i < triangles.size(); ++i) {
        triangles[i].corners = corners(drawn_[by_band_[band][i]], pass, from);
        raster.add(triangles[i].corners, static_cast<std::uint32_t>(i + 1));
      }
      shade(raster, triangles, rows);
      raster.clear();
    }
    rows.convertTo(rows, -1, 1.0 / (passes_.factor * passes_.factor * static_cast<double>(passes_.all.size())));
  }

 private:
  void sort_into_bands(std::size_t figure, const LitFigures& lit, bool is_closed) {
    const auto& vertices = vertices_[figure];
    const auto& triangles = lit.opening[figure].triangles;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const BoxVertex &a = vertices[triangles[t][0]], &b = vertices[triangles[t][1]], &c = vertices[triangles[t][2]];
      if (std::min({a.opening.nearness, b.opening.nearness, c.opening.nearness, a.closing.nearness, b.closing.nearness,
                    c.closing.nearness}) <= 0.0F)
        continue;
      if (is_closed && is_turned_away(a.opening, b.opening, c.opening) &&
          is_turned_away(a.closing, b.closing, c.closing))
        continue;
      const auto [low, high] =
          std::minmax({a.opening.y, b.opening.y, c.opening.y, a.closing.y, b.closing.y, c.closing.y});
      const int last = static_cast<int>(by_band_.size()) - 1;
      if (high < -1.0F || low > static_cast<float>(box_.height + 1)) continue;
      drawn_.push_back({static_cast<std::uint32_t>(figure), static_cast<std::uint32_t>(t), triangles[t]});
      const int first_band = std::clamp(static_cast<int>(std::floor((low - 1.0F) / kBandRows)), 0, last);
      const int last_band = std::clamp(static_cast<int>(std::floor((high + 1.0F) / kBandRows)), 0, last);
      for (int band = first_band; band <= last_band; ++band)
        by_band_[static_cast<std::size_t>(band)].push_back(static_cast<std::uint32_t>(drawn_.size() - 1));
    }
  }

  // y runs down in pictures: a triangle seen from outside has a negative area there.
  static bool is_turned_away(const BoxCorner& a, const BoxCorner& b, const BoxCorner& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) >= 0.0F;
  }

  SampleTriangle corners(const DrawnTriangle& drawn, const Pass& pass, int from) const {
    const auto& vertices = vertices_[drawn.figure];
    const auto factor = static_cast<float>(passes_.factor);
    SampleTriangle corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& [a, b] = vertices[drawn.vertices[i]];
      corners[i] = {(a.x + pass.moment * (b.x - a.x) + pass.shift.x()) * factor,
                    (a.y + pass.moment * (b.y - a.y) + pass.shift.y() - static_cast<float>(from)) * factor,
                    a.nearness + pass.moment * (b.nearness - a.nearness)};
    }
    return corners;
  }

  // What shading asks of a corner, four by four: diffuse light and the texel's column, gloss and its row.
  struct ShadedCorner {
    Vector4f light_column, gloss_row;
  };
  struct BandTriangle {
    SampleTriangle corners;  // of this pass
    std::array<ShadedCorner, 3> shaded;
    const cv::Mat* picture;
  };

  BandTriangle gathered(const DrawnTriangle& drawn) const {
    const auto& texture = figures_[drawn.figure].texture;
    BandTriangle triangle{{}, {}, &texture.picture};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& texel = texture.corners[3 * drawn.triangle + i];
      const auto& [light, gloss] = seen_[drawn.figure].light[drawn.vertices[i]];
      triangle.shaded[i] = {{light.x(), light.y(), light.z(), texel.x()}, {gloss.x(), gloss.y(), gloss.z(), texel.y()}};
    }
    return triangle;
  }

  // Samples two by two: what they see of one triangle is shaded once, in their middle.
  void shade(const SampleRaster& raster, const std::vector<BandTriangle>& triangles, cv::Mat& rows) const {
    const int factor = passes_.factor;
    for (int row = 0; row<rows.rows * factor; row += factor> 1 && row % factor + 1 < factor ? 2 : 1) {
      const bool is_pair = row % factor + 1 < factor;
      auto [first, last] = raster.touched(row);
      if (is_pair) {
        const auto below = raster.touched(row + 1);
        first = std::min(first, below[0]);
        last = std::max(last, below[1]);
      }
      auto* out = rows.ptr<cv::Vec4f>(row / factor);
      for (int x = first / factor; x * factor < last; ++x)
        for (int i = 0; i < factor; i += 2)
          shade_block(raster, triangles, {x * factor + i, row, std::min(2, factor - i), is_pair ? 2 : 1}, out[x]);
    }
  }

  static void shade_block(const SampleRaster& raster, const std::vector<BandTriangle>& triangles, const cv::Rect& block,
                          cv::Vec4f& sum) {
    std::array<std::uint32_t, 4> numbers{};
    std::array<cv::Point2f, 4> places;
    std::size_t count = 0;
    for (int y = block.y; y < block.y + block.height; ++y)
      for (int x = block.x; x < block.x + block.width; ++x) {
        const auto number = raster.at(x, y);
        if (number == 0) continue;
        numbers[count] = number;
        places[count++] = {static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F};
      }
    for (std::size_t i = 0; i < count; ++i) {
      const auto number = numbers[i];
      if (number == 0) continue;
      cv::Point2f middle;
      float share = 0.0F;
      for (std::size_t j = i; j < count; ++j)
        if (numbers[j] == number) {
          middle += places[j];
          share += 1.0F;
          numbers[j] = 0;
        }
      const auto& triangle = triangles[number - 1];
      const Vector4f light = colour_of(triangle, weights_at(triangle.corners, middle.x / share, middle.y / share));
      Eigen::Map<Vector4f>(sum.val) += share * light;
    }
  }

  static Vector4f colour_of(const BandTriangle& triangle, const Vector3f& weights) {
    const auto& [a, b, c] = triangle.shaded;
    const Vector4f diffuse = weights[0] * a.light_column + weights[1] * b.light_column + weights[2] * c.light_column;
    const Vector4f gloss = weights[0] * a.gloss_row + weights[1] * b.gloss_row + weights[2] * c.gloss_row;
    const Vector4f lit = reflectance(*triangle.picture, diffuse[3], gloss[3]).cwiseProduct(diffuse) + gloss;
    Vector4f colour = lit.cwiseMax(0.0F).cwiseMin(kBrightest);
    colour[3] = 1.0F;
    return colour;
  }

  // Bilinear, of linear light; (0.5, 0.5) is the centre of the first texel.
  static Vector4f reflectance(const cv::Mat& picture, float column, float row) {
    const float x = std::clamp(column - 0.5F, 0.0F, static_cast<float>(picture.cols - 1));
    const float y = std::clamp(row - 0.5F, 0.0F, static_cast<float>(picture.rows - 1));
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
    const auto* upper = picture.ptr<cv::Vec3b>(top) + left;
    const auto* lower = picture.ptr<cv::Vec3b>(std::min(top + 1, picture.rows - 1)) + left;
    const int next = left + 1 < picture.cols ? 1 : 0;
    const auto& linear = linear_of_srgb();
    const auto texel = [&linear](const cv::Vec3b& c) {
      return Vector4f(linear[c[0]], linear[c[1]], linear[c[2]], 0.0F);
    };
    const Vector4f above = texel(upper[0]) + u * (texel(upper[next]) - texel(upper[0]));
    const Vector4f below = texel(lower[0]) + u * (texel(lower[next]) - texel(lower[0]));
    return above + v * (below - above);
  }

  static const std::array<float, 256>& linear_of_srgb() {
    static const auto kTable = [] {
      std::array<float, 256> table{};
      for (std::size_t i = 0; i < table.size(); ++i) {
        const double s = static_cast<double>(i) / 255.0;
        table[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
      }
      return table;
    }();
    return kTable;
  }

  const std::vector<Figure>& figures_;
  const std::vector<SeenFigure>& seen_;
  const cv::Rect box_;
  const Passes& passes_;
  std::vector<std::vector<BoxVertex>> vertices_;
  std::vector<DrawnTriangle> drawn_;
  std::vector<std::vector<std::uint32_t>> by_band_;  // of drawn_
};

// Every edge has its opposite, as on the outside of a solid.
bool is_outside_of_solid(const recon::TriangleMesh& mesh) {
  std::vector<std::array<std::uint32_t, 2>> edges, opposite;
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      edges.push_back({t[i], t[(i + 1) % 3]});
      opposite.push_back({t[(i + 1) % 3], t[i]});
    }
    volume += static_cast<double>(mesh.positions[t[0]].dot(mesh.positions[t[1]].cross(mesh.positions[t[2]])));
  }
  std::sort(edges.begin(), edges.end());
  std::sort(opposite.begin(), opposite.end());
  return volume > 0.0 && edges == opposite;
}

}  // namespace

int default_supersampling(int picture_width) {
  return std::clamp((2800 + picture_width / 2) / picture_width, 2, 8);
}

FigureRenderer::FigureRenderer(const std::vector<Figure>& figures) : figures_(figures) {
  for (const auto& figure : figures_) is_closed_.push_back(is_outside_of_solid(figure.bind));
}

FigureLayer FigureRenderer::draw(const capture::CameraModel& camera, const LitFigures& figures,
                                 int supersampling) const {
  std::vector<SeenFigure> seen;
  for (std::size_t i = 0; i < figures_.size(); ++i)
    seen.push_back(see_figure(camera, figures, i, figures_[i], is_closed_[i]));
  FigureLayer layer;
  layer.box = box_of(seen, camera);
  if (layer.box.empty()) return layer;
  layer.rgba.create(layer.box.size(), CV_32FC4);
  const auto passes = passes_for(longest_way(seen), supersampling);
  const Drawing drawing(figures_, is_closed_, figures, seen, layer.box, passes);
  tbb::parallel_for(std::size_t{0}, drawing.bands(), [&](std::size_t band) { drawing.draw(band, layer.rgba); });
  return layer;
}

}  // namespace rotunda::simulator
