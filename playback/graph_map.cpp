#include "playback/graph_map.h"

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace rotunda::playback {
namespace {

constexpr int kSide = 220;
constexpr double kRing = 68.0, kNode = 9.0, kApart = 5.0;  // pixels
const cv::Scalar kCard(16, 18, 22, 170), kQuiet(150, 152, 158, 255), kBright(255, 190, 70, 255),
    kText(235, 235, 235, 255);

class MapDrawing {
 public:
  MapDrawing(const recon::MotionGraph& graph, const std::string& doing) : graph_(graph), doing_(doing) {}

  cv::Mat draw(const std::string& wanted) {
    for (const auto& transition : graph_.transitions)
      if (transition.name != doing_) draw_transition(transition, kQuiet);
    for (const auto& transition : graph_.transitions)
      if (transition.name == doing_) draw_transition(transition, kBright);
    for (const auto& state : graph_.states) draw_state(state.name, wanted);
    return picture_;
  }

 private:
  cv::Point2d place_of(const std::string& state) const {
    const auto at = static_cast<double>(&graph_.state(state) - graph_.states.data());
    const double angle = 2.0 * std::numbers::pi * at / static_cast<double>(graph_.states.size());
    return cv::Point2d(0.5 * kSide, 0.5 * kSide) + kRing * cv::Point2d(std::sin(angle), -std::cos(angle));
  }

  void draw_transition(const recon::MotionTransition& transition, const cv::Scalar& colour) {
    const auto from = place_of(transition.from), to = place_of(transition.to);
    const double length = std::hypot(to.x - from.x, to.y - from.y);
    if (length < 1.0) return draw_action(from, colour);
    const cv::Point2d along = (to - from) / length, beside(-along.y * kApart, along.x * kApart);
    const auto begin = from + 1.4 * kNode * along + beside, end = to - 1.4 * kNode * along + beside;
    constexpr double kDash = 5.0;  // pixels
    const double way = length - 2.8 * kNode, step = transition.synthesised() ? 2.0 * kDash : way;
    for (double s = 0.0; s < way; s += step)
      cv::line(picture_, begin + s * along, begin + std::min(s + (transition.synthesised() ? kDash : way), way) * along,
               colour, 1, cv::LINE_AA);
    cv::arrowedLine(picture_, end - 8.0 * along, end, colour, 1, cv::LINE_AA, 0, 0.6);
  }

  // A loop on the side away from the middle.
  void draw_action(cv::Point2d state, const cv::Scalar& colour) {
    const cv::Point2d outwards = (state - cv::Point2d(0.5 * kSide, 0.5 * kSide)) / kRing;
    cv::circle(picture_, state + 1.6 * kNode * outwards, static_cast<int>(kNode), colour, 1, cv::LINE_AA);
  }

  void draw_state(const std::string& name, const std::string& wanted) {
    const auto at = place_of(name);
    cv::circle(picture_, at, static_cast<int>(kNode), name == doing_ ? kBright : kQuiet, cv::FILLED, cv::LINE_AA);
    if (name == wanted) cv::circle(picture_, at, static_cast<int>(kNode) + 3, kBright, 1, cv::LINE_AA);
    int below = 0;
    const auto extent = cv::getTextSize(name, cv::FONT_HERSHEY_SIMPLEX, 0.42, 1, &below);
    const int x = std::clamp(static_cast<int>(at.x) - extent.width / 2, 2, std::max(2, kSide - extent.width - 2));
    cv::putText(picture_, name, {x, static_cast<int>(at.y + 2.9 * kNode)}, cv::FONT_HERSHEY_SIMPLEX, 0.42, kText, 1,
                cv::LINE_AA);
  }

  const recon::MotionGraph& graph_;
  const std::string& doing_;
  cv::Mat picture_ = cv::Mat(kSide, kSide, CV_8UC4, kCard);
};

}  // namespace

cv::Mat graph_map(const recon::MotionGraph& graph, const std::string& doing, const std::string& wanted) {
  return MapDrawing(graph, doing).draw(wanted);
}

}  // namespace rotunda::playback
