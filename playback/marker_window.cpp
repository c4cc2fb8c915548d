#include "playback/marker_window.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <utility>

#include "playback/display/headless.h"
#include "playback/display/open_display.h"
#include "playback/marker_view.h"
#include "playback/picture_clock.h"

namespace rotunda::playback {
namespace {

// From where the scan, as it stands, fills its half.
Orbit front_of(const recon::TriangleMesh& scan, int width, int height) {
  constexpr double kFilled = 0.82;
  Eigen::AlignedBox3d box;
  for (const auto& p : scan.positions) box.extend(p.cast<double>());
  Orbit orbit{.target = box.center(), .elevation = 0.05};
  const double high = std::max(box.sizes().z(), box.sizes().y() / (0.5 * width / height));
  orbit.distance = 0.5 * high / kFilled / std::tan(0.5 * orbit.field_of_view) + 0.5 * box.sizes().x();
  return orbit;
}

TakeTold told_of(const recon::BodyMotion& motion) {
  return {.frames = static_cast<int>(motion.poses.size()), .fps = 1.0 / motion.frame_time};
}

// Of a message, as many as there is room for.
std::vector<std::string> lines_of(const std::string& text) {
  constexpr std::size_t kMost = 4;
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; lines.size() < kMost && std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// One editor on the screen: desk and preview, and how they and a view, which lives in a graphics context and may be
// lost with it, hang together.
class Session {
 public:
  Session(const recon::PreparedScan& scan, recon::MarkerEditor& editor, const recon::BodyMotion& motion, int width,
          int height)
      : front_(front_of(scan.mesh, width, height)),
        editor_(editor),
        desk_(editor, told_of(motion), front_),
        preview_(scan, editor.markers().fit.value(), motion),
        at_scan_(editor.markers().fit->pose.root) {
    show(preview_.newest());
  }

  MarkerDesk& desk() { return desk_; }

  // True if something else is to be seen than before.
  bool refresh() {
    preview_.wish(wish(), editor_.markers());
    const bool bound_before = std::exchange(binds_, preview_.binds());
    const auto newest = preview_.newest();
    if (newest == shown_) return binds_ != bound_before;
    show(newest);
    return true;
  }
  void wait() { show(preview_.wait_for(wish(), editor_.markers())); }
  // Into the bound framebuffer. The view is the context's.
  void draw(MarkerView& view, const MarkerLayout& layout, const std::string& rate) {
    auto lines = desk_.lines(rate);
    if (binds_) lines[0] += "   binding the scan";
    const auto told = lines_of(shown_->told);
    lines.insert(lines.begin() + 2, told.begin(), told.end());
    view.show(shown_, desk_);
    view.draw(desk_, layout, lines);
  }
  MarkerScene scene(const MarkerLayout& layout) const { return {shown_->body, shown_->scan, layout}; }

 private:
  PreviewWish wish() const { return {editor_.revision(), desk_.frame(), desk_.shows_residuals()}; }
  void show(std::shared_ptr<const Preview> preview) {
    shown_ = std::move(preview);
    desk_.look_at(front_.target + shown_->performer - at_scan_);
  }

  Orbit front_;
  recon::MarkerEditor& editor_;
  MarkerDesk desk_;
  MarkerPreview preview_;
  Eigen::Vector3d at_scan_;
  std::shared_ptr<const Preview> shown_;
  bool binds_ = false;
};

bool is_idle(const WindowInput& input) {
  return input.keys.empty() && input.digits.empty() && input.clicks.empty() && input.buttons.empty() &&
         !input.dragged && input.drag_x == 0.0 && input.drag_y == 0.0 && input.shift_x == 0.0 && input.shift_y == 0.0 &&
         input.scroll == 0.0 && !input.gamepad;
}

// Looks at the input without anything new, after which the picture is drawn again: another window may have covered it.
constexpr int kRedrawn = 20;

void keep(MarkerDesk& desk, recon::MarkerEditor& editor, recon::MarkerKeeper& keeper) {
  try {
    if (desk.take_save()) {
      keeper.save(editor);
      desk.say("saved: " + keeper.file().string());
    }
    keeper.keep(editor);
  } catch (const std::system_error& error) {
    desk.say(fmt::format("not kept: {}", error.what()));
  }
}

}  // namespace

EditMarkersReport edit_markers(const recon::PreparedScan& scan, recon::MarkerEditor& editor,
                               recon::MarkerKeeper& keeper, const recon::BodyMotion& motion,
                               const EditMarkersOptions& options) {
  Session session(scan, editor, motion, options.width, options.height);
  MarkerDesk& desk = session.desk();
  EditMarkersReport report;
  PictureClock clock;
  const auto edit_in = [&](Display& window) {
    MarkerView view;
    MarkerLayout layout{0, 0};
    int stood = kRedrawn;  // looks at the input since the last picture
    while (window.is_open() && !desk.ended() && !options.stop.stop_requested() &&
           (options.picture_limit == 0 || report.pictures < options.picture_limit)) {
      const double passed = clock.begin();
      const MarkerLayout before = layout;
      layout = {window.width(), window.height()};
      const auto input = window.take_input();
      if (layout.has_room()) desk.apply(input, session.scene(layout), passed);
      keep(desk, editor, keeper);
      desk.go_on(passed);
      const bool other = session.refresh();
      const bool still = !other && is_idle(input) && !desk.moves() && before == layout;
      if (still && options.picture_limit == 0 && ++stood < kRedrawn) {
        window.wait_for_input(0.05);
        continue;
      }
      stood = 0;
      window.bind();
      session.draw(view, layout, clock.told());
      window.present();
      ++report.pictures;
      clock.end(false);
    }
  };
  with_display({.window = {.title = "rotunda: markers " + keeper.file().filename().string(),
                           .width = options.width,
                           .height = options.height,
                           .fullscreen = options.fullscreen}},
               edit_in);
  report.seconds = clock.seconds();
  report.frame = desk.frame();
  return report;
}

cv::Mat picture_of_markers(const recon::PreparedScan& scan, recon::MarkerEditor& editor,
                           const recon::BodyMotion& motion, int width, int height) {
  const HeadlessDisplay display;
  const RenderTarget target(width, height);
  const MarkerLayout layout{width, height};
  Session session(scan, editor, motion, width, height);
  MarkerView view;
  cv::Mat both;
  const auto draw = [&] {
    session.wait();
    target.bind();
    session.draw(view, layout, "");
    cv::Mat rgb;
    cv::cvtColor(target.read_rgba(), rgb, cv::COLOR_RGBA2RGB);
    both.push_back(rgb);
  };
  editor.select_next(1);
  draw();
  session.desk().apply({.keys = {Key::rest, Key::residuals}, .digits = {5}}, session.scene(layout), 0.0);
  draw();
  return both;
}

}  // namespace rotunda::playback
