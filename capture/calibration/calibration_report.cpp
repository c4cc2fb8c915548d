#include "capture/calibration/calibration_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/calibration/html_page.h"
#include "capture/calibration/rig_drawing.h"
#include "capture/calibration/view_drawing.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr int kRigWidth = 370, kCoverageWidth = 270, kViewWidth = 360;  // pixels

void check(const CalibrationResult& result) {
  bool fits = result.quality.size() == result.cameras.size();
  for (const auto& view : result.views)
    fits = fits && view.camera < result.cameras.size() && view.moment < result.moments.size() &&
           view.board < result.boards.size();
  for (const auto& tie : result.ties) fits = fits && tie.a < result.cameras.size() && tie.b < result.cameras.size();
  for (const auto& pose : result.poses) fits = fits && pose.board < result.boards.size();
  if (!fits)
    throw InvalidInput("a calibration's views, ties and poses name cameras, moments or boards that it has not");
}

std::string word(Verdict verdict) {
  return fmt::format("<span class=\"word {0}\">{0}</span>", to_string(verdict));
}

std::string list(const std::vector<std::string>& sentences) {
  if (sentences.empty()) return {};
  std::string html = "<ul>";
  for (const auto& sentence : sentences) html += "<li>" + html_escaped(sentence) + "</li>";
  return html + "</ul>\n";
}

std::string millimetres(double metres) {
  return fmt::format("{:.2f} mm", metres * 1e3);
}

std::string verdict_box(const CalibrationResult& result) {
  const char* meaning = result.verdict == Verdict::good     ? "as good as this rig allows"
                        : result.verdict == Verdict::usable ? "will do, could be better"
                                                            : "do not work with it";
  std::string html =
      fmt::format("<div class=\"verdict {}\"><p>{}: {}. ", to_string(result.verdict), word(result.verdict), meaning);
  html += fmt::format("{} cameras, {} moments, {} corners; RMS {:.3f} px, 95 % below {:.3f} px", result.cameras.size(),
                      result.moments.size(), result.corners, result.rms_px, result.p95_px);
  html += fmt::format("; {:.3f} px {} that took no part", result.held_out_rms_px, held_out_where(result));
  return html + ".</p>\n" + list(result.problems) + list(result.advice) + "</div>\n";
}

// What concerns one camera.
std::string advice_by_camera(const CalibrationResult& result) {
  std::string html;
  for (std::size_t i = 0; i < result.cameras.size(); ++i)
    if (!result.quality[i].advice.empty())
      html += fmt::format("<h3>{} {}</h3>{}", html_escaped(result.cameras[i].name), word(result.quality[i].verdict),
                          list(result.quality[i].advice));
  return html.empty() ? html : "<h2>What to do, camera by camera</h2>\n" + html;
}

std::string rig(const CalibrationResult& result) {
  const auto from = [&](Side side, const char* caption) {
    return "<figure>" + draw_rig(result, side, kRigWidth) + "<figcaption>" + caption + "</figcaption></figure>\n";
  };
  return "<h2>The rig</h2>\n<div class=\"row\">" + from(Side::above, "from above") +
         from(Side::front, "from the front (along y)") + from(Side::right, "from the right (against x)") +
         "</div>\n<p class=\"quiet\">Pyramids are cameras, coloured by their verdict; blue outlines are boards; a line "
         "joins cameras that saw "
         "boards at the same moments, thicker the oftener. World: " +
         html_escaped(result.world) + ".</p>\n";
}

using Row = std::vector<std::string>;

std::string table(const Row& head, const std::vector<Row>& rows) {
  std::string html = "<div class=\"scroll\"><table><tr>";
  for (const auto& cell : head) html += "<th>" + cell + "</th>";
  html += "</tr>\n";
  for (const auto& row : rows) {
    html += "<tr>";
    for (const auto& cell : row) html += "<td>" + cell + "</td>";
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string figures(const CalibrationResult& result) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < result.cameras.size(); ++i) {
    const auto& q = result.quality[i];
    rows.push_back(
        {html_escaped(result.cameras[i].name), word(q.verdict), fmt::format("{}", q.views),
         fmt::format("{}", q.corners), fmt::format("{}", q.outliers), fmt::format("{:.3f}", q.rms_px),
         fmt::format("{:.3f}", q.p95_px), q.held_out_rms_px > 0 ? fmt::format("{:.3f}", q.held_out_rms_px) : "&ndash;",
         fmt::format("{:.0f} %", 100 * q.coverage.outermost_radius),
         fmt::format("{:.2f} &ndash; {:.2f}", q.coverage.nearest, q.coverage.farthest), millimetres(q.deviation.centre),
         fmt::format("{:.3f}", q.deviation.rotation_deg), fmt::format("{:.2f}", q.deviation.rim_px)});
  }
  return "<h2>How far to trust each camera</h2>\n" +
         table({"camera", "verdict", "views", "corners", "outliers", "RMS px", "95 % px", "held-out px",
                "outermost<br>corner", "boards at, m", "centre &plusmn;", "rotation &plusmn; &deg;", "rim &plusmn; px"},
               rows) +
         "<p class=\"quiet\">&plusmn; is a standard deviation, from the adjustment's covariance; held-out: RMS at "
         "moments that took no part. The "
         "outermost corner's distance from the principal point, as a share of the picture's own: below 75 % what the "
         "lens does at the rim is concluded from farther in, as well as the last column says.</p>\n";
}

std::string with_deviation(double value, double deviation, int digits) {
  return deviation > 0 ? fmt::format("{:.{}f} &plusmn; {:.{}f}", value, digits, deviation, digits)
                       : fmt::format("{:.{}f}", value, digits);
}

std::string parameters(const CalibrationResult& result) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < result.cameras.size(); ++i) {
    const auto& camera = result.cameras[i];
    const auto& d = result.quality[i].deviation;
    Row row{html_escaped(camera.name),
            fmt::format("{} &times; {}", camera.width, camera.height),
            with_deviation(camera.K(0, 0), d.fx, 2),
            with_deviation(camera.K(1, 1), d.fy, 2),
            with_deviation(camera.K(0, 2), d.cx, 2),
            with_deviation(camera.K(1, 2), d.cy, 2)};
    for (Eigen::Index j = 0; j < 5; ++j) row.push_back(with_deviation(camera.distortion[j], d.distortion[j], 5));
    const Eigen::Vector3d centre = camera.centre();
    row.push_back(fmt::format("{:.4f}, {:.4f}, {:.4f}", centre.x(), centre.y(), centre.z()));
    rows.push_back(std::move(row));
  }
  return "<h2>Parameters</h2>\n" +
         table({"camera", "size px", "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "centre, m (x, y, z)"},
               rows);
}

std::string ties(const CalibrationResult& result) {
  std::vector<Row> rows;
  for (const auto& tie : result.ties)
    rows.push_back({html_escaped(result.cameras[tie.a].name + " and " + result.cameras[tie.b].name),
                    fmt::format("{}", tie.moments), fmt::format("{:.4f}", tie.baseline),
                    millimetres(tie.baseline_deviation)});
  if (rows.empty()) return {};
  return "<details><summary>Baselines: which cameras tie to which</summary>\n" +
         table({"cameras", "moments in common", "baseline, m", "&plusmn;"}, rows) + "</details>\n";
}

std::string volume(const CalibrationResult& result) {
  const auto& v = result.volume;
  if (v.box.isEmpty() || v.views.empty()) return {};
  return fmt::format(
      "<p class=\"quiet\">Boards were shown within {:.2f} &times; {:.2f} &times; {:.2f} m; two cameras or more saw "
      "them in "
      "{:.0f} % of its cells. Corner noise {:.3f} px an axis; board bend {}.</p>\n",
      v.box.sizes().x(), v.box.sizes().y(), v.box.sizes().z(), 100 * v.share, result.corner_noise_px,
      result.bend != 0.0 ? millimetres(result.bend) : "not estimated");
}

std::string coverage(const CalibrationResult& result, double magnification) {
  std::string html = "<h2>Where each camera saw corners</h2>\n<div class=\"row\">";
  for (std::size_t i = 0; i < result.cameras.size(); ++i)
    html += fmt::format("<figure>{}<figcaption>{}: {} corners in {} views</figcaption></figure>\n",
                        draw_coverage(result, i, magnification, kCoverageWidth), html_escaped(result.cameras[i].name),
                        result.quality[i].corners, result.quality[i].views);
  return html + fmt::format(
                    "</div>\n<p class=\"quiet\">Blue: corners, darker the more; 0: none. Arrows: from where a corner "
                    "was found to where the "
                    "calibration puts it, {:g} times longer than they are; red ones took no part. Arrows of one "
                    "direction in one region "
                    "mean that the lens model does not fit there.</p>\n",
                    magnification);
}

// The worst view, then views spread over the moments.
std::vector<const CalibratedView*> shown_views(const CalibrationResult& result, std::size_t camera, std::size_t count) {
  std::vector<const CalibratedView*> all;
  for (const auto& view : result.views)
    if (view.camera == camera) all.push_back(&view);
  std::stable_sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->rms_px > b->rms_px; });
  std::vector<const CalibratedView*> shown;
  if (all.empty() || count == 0) return shown;
  shown.push_back(all.front());
  all.erase(all.begin());
  std::stable_sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->moment < b->moment; });
  const std::size_t more = std::min(count - 1, all.size());
  for (std::size_t i = 0; i < more; ++i) shown.push_back(all[(2 * i + 1) * all.size() / (2 * more)]);
  return shown;
}

std::string view_figure(const CalibrationResult& result, const CalibratedView& view, double magnification) {
  const auto outliers =
      std::count_if(view.corners.begin(), view.corners.end(), [](const auto& c) { return c.outlier; });
  auto caption = fmt::format("{}, {}: {} corners, RMS {:.3f} px", html_escaped(result.moments[view.moment]),
                             html_escaped(result.boards[view.board].name), view.corners.size(), view.rms_px);
  if (outliers > 0) caption += fmt::format(", {} outliers", outliers);
  if (view.predicted) caption += "; missed by the detector, found by prediction";
  return "<figure>" + draw_view(result, view, magnification, kViewWidth) + "<figcaption>" + caption +
         "</figcaption></figure>\n";
}

std::string views(const CalibrationResult& result, const CalibrationReportOptions& options, double magnification) {
  std::string html = "<h2>Views</h2>\n<p class=\"quiet\">The worst of each camera first.</p>\n";
  for (std::size_t i = 0; i < result.cameras.size(); ++i) {
    html += "<h3>" + html_escaped(result.cameras[i].name) + "</h3>\n<div class=\"row\">";
    for (const auto* view : shown_views(result, i, options.views_per_camera))
      html += view_figure(result, *view, magnification);
    html += "</div>\n";
  }
  return html;
}

}  // namespace

std::string calibration_report(const CalibrationResult& result, const CalibrationReportOptions& options) {
  check(result);
  const double magnification = residual_magnification(result);
  return html_page(options.title, "<h1>" + html_escaped(options.title) + "</h1>\n" + verdict_box(result) +
                                      advice_by_camera(result) + rig(result) + volume(result) + figures(result) +
                                      ties(result) + coverage(result, magnification) + parameters(result) +
                                      views(result, options, magnification));
}

}  // namespace rotunda::capture
