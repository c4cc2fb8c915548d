#include "playback/marker_view.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "playback/render/stage.h"
#include "playback/surface_pick.h"

namespace rotunda::playback {
namespace {

constexpr int kMargin = 12;  // of what is laid over, pixels

const std::vector<recon::Colour>& residual_colours() {
  static const auto colours = [] {
    cv::Mat ramp(1, 256, CV_8UC1), coloured;
    for (int i = 0; i < 256; ++i) ramp.at<std::uint8_t>(0, i) = static_cast<std::uint8_t>(i);
    cv::applyColorMap(ramp, coloured, cv::COLORMAP_VIRIDIS);
    std::vector<recon::Colour> all;
    for (int i = 0; i < 256; ++i) {
      const auto& bgr = coloured.at<cv::Vec3b>(0, i);
      all.push_back({bgr[2], bgr[1], bgr[0]});
    }
    return all;
  }();
  return colours;
}

cv::Mat scale_card() {
  constexpr int kWide = 240, kHigh = 14;
  cv::Mat card(56, kWide + 44, CV_8UC4, cv::Scalar(16, 18, 22, 170));
  for (int x = 0; x < kWide; ++x) {
    const auto colour = residual_colour(static_cast<float>(kResidualScale * x / (kWide - 1)));
    card(cv::Rect(16 + x, 24, 1, kHigh)).setTo(cv::Scalar(colour[0], colour[1], colour[2], 255));
  }
  const auto write = [&](const std::string& text, int x, int y) {
    cv::putText(card, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, 0.4, cv::Scalar(235, 235, 235, 255), 1, cv::LINE_AA);
  };
  write("template from scan, mm", 16, 17);
  for (int mm = 0; mm <= 30; mm += 10) write(std::to_string(mm) + (mm == 30 ? "+" : ""), 10 + kWide * mm / 30, 51);
  return card;
}

cv::Mat bar_of(const MarkerDesk& desk, int width) {
  cv::Mat bar(MarkerLayout::kBar, width, CV_8UC4, cv::Scalar(52, 56, 62, 255));
  if (!desk.frame()) return bar;
  const int at = std::clamp(static_cast<int>(desk.share() * width), 0, width - 1);
  bar.colRange(0, at + 1).setTo(cv::Scalar(110, 150, 190, 255));
  bar.colRange(std::max(0, at - 2), std::min(width, at + 3)).setTo(cv::Scalar(240, 240, 240, 255));
  return bar;
}

recon::TriangleMesh coloured(const recon::TriangleMesh& mesh, const std::vector<float>& residuals) {
  auto copy = mesh;
  copy.colours.clear();
  for (const float residual : residuals) copy.colours.push_back(residual_colour(residual));
  return copy;
}

MarkerLabel label_at(const recon::TriangleMesh& mesh, std::uint32_t triangle, MarkerLabel look) {
  look.place = recon::middle_of(mesh, triangle);
  look.normal = outwards(mesh, triangle);
  return look;
}

}  // namespace

recon::Colour segment_colour(std::size_t segment) {
  // Segments follow each other from the trunk outwards (body_template.h): the trunk's four, then arms and legs, left
  // and right alike in hue.
  static constexpr recon::Colour kTrunk[] = {{230, 60, 60}, {240, 150, 40}, {235, 215, 50}, {190, 110, 235}};
  static constexpr recon::Colour kLimbs[] = {{50, 200, 80},  {40, 200, 200}, {70, 120, 255},
                                             {150, 220, 40}, {255, 90, 180}, {60, 170, 255}};
  if (segment < 4) return kTrunk[segment];
  const std::size_t left = std::min(segment, recon::mirrored_segment(segment));
  recon::Colour colour = kLimbs[left < 10 ? left - 4 : left - 10 + 3];
  if (segment != left)
    for (auto& channel : colour) channel = static_cast<std::uint8_t>((channel + 2 * 255) / 3);
  return colour;
}

recon::Colour residual_colour(float distance) {
  const double share = std::clamp(static_cast<double>(distance) / kResidualScale, 0.0, 1.0);
  return residual_colours()[static_cast<std::size_t>(share * 255.0)];
}

void MarkerView::upload(const Preview& preview) {
  if (preview.of.residuals) {
    left_.body.upload(coloured(preview.body, preview.body_residuals));
    right_.body.upload(coloured(preview.scan, preview.scan_residuals));
  } else {
    left_.body.upload(preview.body);
    right_.body.upload(preview.scan);
  }
}

void MarkerView::set_labels(const MarkerDesk& desk) {
  std::vector<MarkerLabel> left, right;
  const auto *selected = desk.editor().selected(), *mirror = desk.editor().mirror_of_selected();
  for (const auto& marker : desk.editor().markers().pairs) {
    const MarkerLabel look{.colour = segment_colour(recon::segment_of_triangle(marker.template_triangle)),
                           .text = std::to_string(marker.number),
                           .selected = selected && selected->number == marker.number,
                           .goes_along = mirror && mirror->number == marker.number};
    left.push_back(label_at(shown_->body, marker.template_triangle, look));
    right.push_back(label_at(shown_->scan, desk.editor().on_prepared(marker), look));
  }
  const MarkerLabel waiting{.text = "?", .selected = true};
  if (desk.pending().body) left.push_back(label_at(shown_->body, *desk.pending().body, waiting));
  if (desk.pending().scan) right.push_back(label_at(shown_->scan, *desk.pending().scan, waiting));
  left_.labels.set(std::move(left));
  right_.labels.set(std::move(right));
}

void MarkerView::show(std::shared_ptr<const Preview> preview, const MarkerDesk& desk) {
  if (preview != shown_) upload(*preview);
  shown_ = std::move(preview);
  set_labels(desk);
}

void MarkerView::draw_half(Half& half, MarkerSide side, const MarkerDesk& desk, const MarkerLayout& layout) {
  const auto eye = layout.viewpoint(side, desk.orbit());
  glViewport(layout.left(side), 0, eye.width, eye.height);
  DrawOptions draw{.shading = desk.draw().shading, .cull = false};  // scans have holes
  if (shown_->of.residuals) draw.shading = Shading::lit;
  half.body.draw(eye, draw);
  half.labels.draw(eye, depth_range(eye, half.body.box()));
}

void MarkerView::draw_overlays(const MarkerDesk& desk, const MarkerLayout& layout,
                               const std::vector<std::string>& lines) {
  const int width = layout.width, height = layout.height, below = height - MarkerLayout::kBar;
  overlay_.draw(cv::Mat(below, 2, CV_8UC4, cv::Scalar(90, 94, 100, 255)), width / 2 - 1, 0, width, height);
  overlay_.draw(bar_of(desk, width), 0, below, width, height);
  const auto name = [&](const char* text, MarkerSide side) {
    const auto card = text_card({text});
    overlay_.draw(card, layout.left(side) + kMargin, below - card.rows - kMargin, width, height);
  };
  name("template", MarkerSide::body);
  name("scan", MarkerSide::scan);
  if (shown_->of.residuals) {
    static const auto card = scale_card();
    overlay_.draw(card, width - card.cols - kMargin, below - card.rows - kMargin, width, height);
  }
  overlay_.draw(text_card(lines), kMargin, kMargin, width, height);
}

void MarkerView::draw(const MarkerDesk& desk, const MarkerLayout& layout, const std::vector<std::string>& lines) {
  glViewport(0, 0, layout.width, layout.height);
  clear(kDarkRoom);
  if (!layout.has_room()) return;
  draw_half(left_, MarkerSide::body, desk, layout);
  draw_half(right_, MarkerSide::scan, desk, layout);
  glViewport(0, 0, layout.width, layout.height);
  draw_overlays(desk, layout, lines);
}

}  // namespace rotunda::playback
