#include "playback/graph_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "playback/character_view.h"
#include "playback/display/headless.h"
#include "playback/render/orbit_film.h"
#include "recon/motion/character.h"
#include "recon/motion/motion_seam.h"

namespace rotunda::playback {
namespace {

namespace fs = std::filesystem;

const cv::Scalar kPaper(250, 250, 248), kInk(40, 42, 48), kForward(38, 110, 180), kBack(190, 84, 40),
    kAction(60, 130, 70);
constexpr recon::Colour kPaperColour{250, 250, 248};
constexpr int kNodeWidth = 200, kNodeHeight = 260, kGap = 230, kArc = 190;
constexpr int kThumbWidth = 84, kThumbHeight = 112;

// Draws single moments of clips, facing the reader half turned.
class Portraits {
 public:
  Portraits(const fs::path& character, const recon::MotionGraph& graph)
      : graph_(graph), view_(character, graph), roots_(view_.renderer().roots()) {}

  cv::Mat of(const std::string& clip, int frame, int width, int height) {
    const auto at = static_cast<std::size_t>(&graph_.clip(clip) - graph_.clips.data());
    const double heading = graph_.clips[at].heading;
    const Eigen::Vector2d root = recon::FloorPose{0.0, 0.0, -heading} * roots_[at][static_cast<std::size_t>(frame)];
    return of({{{at, static_cast<double>(frame), 1.0, {-root.x(), -root.y(), -heading}}}}, width, height);
  }
  cv::Mat of(const Appearance& appearance, int width, int height) {
    const RenderTarget target(2 * width, 2 * height);
    view_.orbit() = view_.orbit_for(static_cast<double>(width) / height);
    view_.orbit().azimuth = -0.7;
    view_.follow(appearance, 1e9);
    target.bind();
    view_.draw(appearance, 2 * width, 2 * height, {kPaperColour, true, {}});
    cv::Mat rgb;
    cv::cvtColor(reduce(target.read_rgba(), 2), rgb, cv::COLOR_RGBA2RGB);
    return rgb;
  }
  const RootPaths& roots() const { return roots_; }

 private:
  const recon::MotionGraph& graph_;
  CharacterView view_;
  RootPaths roots_;
};

void write(cv::Mat picture, const std::string& text, cv::Point middle, double size, const cv::Scalar& colour) {
  int below = 0;
  const auto extent = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &below);
  cv::putText(picture, text, {middle.x - extent.width / 2, middle.y + extent.height / 2}, cv::FONT_HERSHEY_SIMPLEX,
              size, colour, 1, cv::LINE_AA);
}

void put(const cv::Mat& tile, cv::Mat picture, cv::Point corner) {
  const cv::Rect at(corner, tile.size());
  const cv::Rect inside = at & cv::Rect({0, 0}, picture.size());
  tile(cv::Rect(inside.tl() - corner, inside.size())).copyTo(picture(inside));
}

// An arc from one point to another over `apex`, with its arrow head; dashed for what nobody was recorded doing.
void draw_arc(cv::Mat picture, cv::Point2d from, cv::Point2d apex, cv::Point2d to, const cv::Scalar& colour,
              bool dashed) {
  constexpr int kPieces = 64;
  const cv::Point2d control = 2.0 * apex - 0.5 * (from + to);
  const auto at = [&](int i) {
    const double t = static_cast<double>(i) / kPieces;
    return (1 - t) * (1 - t) * from + 2 * t * (1 - t) * control + t * t * to;
  };
  for (int i = 0; i < kPieces; ++i)
    if (!dashed || i / 3 % 2 == 0) cv::line(picture, at(i), at(i + 1), colour, 2, cv::LINE_AA);
  cv::arrowedLine(picture, at(kPieces - 4), to, colour, 2, cv::LINE_AA, 0, 0.8);
}

std::string price_text(const recon::MotionTransition& transition) {
  double error = transition.synthesised() ? 0.0 : transition.arrive.price.error_mm, least = 1e9;
  for (const auto& leave : transition.leaves) least = std::min(least, leave.price.error_mm);
  return fmt::format("seams {:.0f} mm", std::max(error, least));
}

class GraphDrawing {
 public:
  GraphDrawing(const recon::MotionGraph& graph, Portraits& portraits) : graph_(graph), portraits_(portraits) {
    const int states = static_cast<int>(graph.states.size());
    int farthest = 1;
    for (const auto& transition : graph.transitions)
      farthest = std::max(farthest, std::abs(index_of(transition.to) - index_of(transition.from)));
    rise_ = kArc + 110 * (farthest - 1) + 20;
    picture_.create(2 * rise_ + kNodeHeight + 80, states * kNodeWidth + (states + 1) * kGap - kGap / 2, CV_8UC3);
    picture_.setTo(kPaper);
  }

  cv::Mat draw() {
    for (const auto& transition : graph_.transitions) draw_transition(transition);
    for (const auto& state : graph_.states) draw_state(state);
    return picture_;
  }

 private:
  int index_of(const std::string& state) const { return static_cast<int>(&graph_.state(state) - graph_.states.data()); }
  cv::Point middle_of(int index) const {
    return {kGap * 3 / 4 + kNodeWidth / 2 + index * (kNodeWidth + kGap), rise_ + kNodeHeight / 2 + 40};
  }

  void draw_state(const recon::MotionState& state) {
    const cv::Point middle = middle_of(index_of(state.name));
    const cv::Rect box(middle.x - kNodeWidth / 2, middle.y - kNodeHeight / 2, kNodeWidth, kNodeHeight);
    put(portraits_.of(state.clip, (state.loop.enter + state.loop.leave) / 2, kNodeWidth, kNodeHeight), picture_,
        box.tl());
    cv::rectangle(picture_, box, kInk, state.name == graph_.start ? 3 : 1, cv::LINE_AA);
    const double speed = graph_.clip(state.clip).speed;
    write(picture_, state.name, {middle.x, box.y + 18}, 0.65, kInk);
    write(picture_, fmt::format("{} frames{}", state.period(), speed > 0.0 ? fmt::format(", {:.2f} m/s", speed) : ""),
          {middle.x, box.br().y - 30}, 0.42, kInk);
    write(picture_, fmt::format("cycle's seam {:.0f} mm", state.loop.price.error_mm), {middle.x, box.br().y - 12}, 0.42,
          kInk);
  }

  void draw_transition(const recon::MotionTransition& transition) {
    const int from = index_of(transition.from), to = index_of(transition.to);
    const cv::Point2d a = middle_of(from), b = middle_of(to);
    const bool action = from == to, forward = to > from;
    const double up = action || forward ? -1.0 : 1.0;
    const double lift = kNodeHeight / 2 + (action ? 100 : kArc - 70 + 110 * (std::abs(to - from) - 1));
    const cv::Point2d apex(action ? a.x + 0.62 * kNodeWidth + 40 : 0.5 * (a.x + b.x), a.y + up * (action ? 10 : lift));
    const cv::Scalar colour = action ? kAction : forward ? kForward : kBack;
    if (action) {
      draw_arc(picture_, {a.x + kNodeWidth / 2, a.y - 70}, apex, {a.x + kNodeWidth / 2, a.y + 90}, colour, false);
    } else {
      const double side = forward ? 1.0 : -1.0;
      draw_arc(picture_, {a.x + side * 50, a.y + up * kNodeHeight / 2}, apex,
               {b.x - side * 50, b.y + up * kNodeHeight / 2}, colour, transition.synthesised());
    }
    label(transition, apex, colour, up);
  }

  void label(const recon::MotionTransition& transition, cv::Point2d apex, const cv::Scalar& colour, double up) {
    const cv::Point corner(static_cast<int>(apex.x) - kThumbWidth / 2, static_cast<int>(apex.y) - kThumbHeight / 2);
    if (!transition.synthesised()) {
      const int frame = (transition.leaves.front().enter + transition.arrive.leave) / 2;
      put(portraits_.of(transition.clip, frame, kThumbWidth, kThumbHeight), picture_, corner);
      cv::rectangle(picture_, cv::Rect(corner, cv::Size(kThumbWidth, kThumbHeight)), colour, 2, cv::LINE_AA);
    }
    const int text = static_cast<int>(apex.y) + static_cast<int>(up * (kThumbHeight / 2 + 26));
    const int x = static_cast<int>(apex.x);
    write(picture_, transition.name + (transition.synthesised() ? " (synthesised)" : ""), {x, text - 8}, 0.5, colour);
    write(picture_, price_text(transition), {x, text + 9}, 0.4, kInk);
  }

  const recon::MotionGraph& graph_;
  Portraits& portraits_;
  cv::Mat picture_;
  int rise_ = 0;
};

// Where each clip begins in the sheet of all frames.
std::vector<int> offsets_of(const recon::MotionGraph& graph, int cell, int margin) {
  std::vector<int> offsets{margin};
  for (const auto& clip : graph.clips) offsets.push_back(offsets.back() + clip.frames * cell + 2);
  return offsets;
}

}  // namespace

cv::Mat graph_picture(const fs::path& character, const recon::MotionGraph& graph) {
  const HeadlessDisplay display;
  Portraits portraits(character, graph);
  return GraphDrawing(graph, portraits).draw();
}

cv::Mat similarity_sheet(const fs::path& character, const recon::MotionGraph& graph) {
  constexpr int kCell = 3, kMargin = 90;
  constexpr double kFarthest = 0.25;  // metres rms: a stride against a stand
  std::vector<recon::ClipShape> shapes;
  for (const auto& clip : graph.clips) {
    recon::GeometryVideoReader video(recon::clip_video_of(character, clip.name));
    shapes.push_back(recon::clip_shape(video, clip.name, 5));
  }
  const auto offsets = offsets_of(graph, kCell, kMargin);
  cv::Mat sheet(offsets.back() + 10, offsets.back() + 10, CV_8UC3, kPaper);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = 0; j < shapes.size(); ++j)
      put(recon::similarity_picture(recon::PairTable(shapes[i], shapes[j]), kCell, kFarthest), sheet,
          {offsets[j], offsets[i]});
    cv::putText(sheet, graph.clips[i].name, {offsets[i], kMargin - 8 - 16 * static_cast<int>(i % 3)},
                cv::FONT_HERSHEY_SIMPLEX, 0.42, kInk, 1, cv::LINE_AA);
    cv::putText(sheet, graph.clips[i].name, {4, offsets[i] + 14}, cv::FONT_HERSHEY_SIMPLEX, 0.42, kInk, 1, cv::LINE_AA);
  }
  const auto ring = [&](const std::string& from, const std::string& to, const recon::Join& join,
                        const cv::Scalar& colour) {
    const auto row = static_cast<std::size_t>(&graph.clip(from) - graph.clips.data());
    const auto column = static_cast<std::size_t>(&graph.clip(to) - graph.clips.data());
    cv::circle(sheet, {offsets[column] + kCell * join.enter + 1, offsets[row] + kCell * join.leave + 1}, 5, colour, 1,
               cv::LINE_AA);
  };
  for (const auto& state : graph.states) ring(state.clip, state.clip, state.loop, {255, 230, 90});
  for (const auto& transition : graph.transitions) {
    const auto& from = graph.state(transition.from).clip;
    const auto& to = graph.state(transition.to).clip;
    for (const auto& leave : transition.leaves)
      ring(from, transition.synthesised() ? to : transition.clip, leave, {110, 255, 140});
    if (!transition.synthesised()) ring(transition.clip, to, transition.arrive, {255, 130, 110});
  }
  return sheet;
}

cv::Mat transition_strip(const fs::path& character, const recon::MotionGraph& graph,
                         const std::vector<std::string>& path, int pictures) {
  const HeadlessDisplay display;
  Portraits portraits(character, graph);
  recon::MotionGraph begun = graph;
  begun.start = path.front();
  CharacterPlayer player(begun, portraits.roots());
  constexpr int kWidth = 120, kHeight = 200, kCaption = 18;
  std::vector<std::pair<Appearance, std::string>> seen;
  const double step = 1.0 / graph.fps;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i > 0) player.command({.state = path[i]});
    // Until it does what was asked (an action: has done it), then half a second more.
    const long before = player.seams();
    const bool action = i > 0 && player.wanted() != path[i];
    for (int frame = 0, after = 0; frame < 400 && after < static_cast<int>(0.5 * graph.fps); ++frame) {
      seen.emplace_back(player.appearance(), player.doing());
      player.advance(step);
      const bool there =
          player.in_state() && player.doing() == player.wanted() && (!action || player.seams() > before + 1);
      after += there ? 1 : 0;
    }
  }
  cv::Mat strip(kHeight + kCaption, pictures * kWidth, CV_8UC3, kPaper);
  for (int i = 0; i < pictures; ++i) {
    const auto& [appearance, doing] =
        seen[static_cast<std::size_t>(i) * (seen.size() - 1) / static_cast<std::size_t>(std::max(1, pictures - 1))];
    put(portraits.of(appearance, kWidth, kHeight), strip, {i * kWidth, kCaption});
    write(strip, doing, {i * kWidth + kWidth / 2, 9}, 0.38, kInk);
  }
  return strip;
}

}  // namespace rotunda::playback
