// How good the key and the surface colours are on the simulated people, and what they cost: overlap (IoU), distance
// between the outlines, and its signed mean (positive: the matte is too large) against the simulator's truth; then CPU
// time. Pictures go through the mosaic as a camera's do.
// usage: key_bench [DIR]   writes pictures of the worst mattes to DIR
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "capture/matte/chroma_key.h"
#include "capture/picture.h"
#include "recon/colour/surface_colour.h"
#include "recon/hull/signed_silhouette.h"
#include "simulator/people/person.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/pixel_encoding.h"
#include "simulator/studio/scene_renderer.h"

namespace {

using namespace rotunda;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Signed distance to the other outline at the sub-pixel crossings of one matte; far ones are other pieces, kept at 20.
void append_crossings(const cv::Mat& alpha, const cv::Mat& other, double sign, std::vector<double>& distances) {
  const auto cross = [&](int x, int y, int dx, int dy) {
    const double a = alpha.at<std::uint8_t>(y, x) - 127.5, b = alpha.at<std::uint8_t>(y + dy, x + dx) - 127.5;
    if ((a < 0) == (b < 0)) return;
    const double s = a / (a - b);
    const double there = (1 - s) * other.at<float>(y, x) + s * other.at<float>(y + dy, x + dx);
    distances.push_back(sign * std::clamp(there, -20.0, 20.0));
  };
  for (int y = 0; y + 1 < alpha.rows; ++y)
    for (int x = 0; x + 1 < alpha.cols; ++x) cross(x, y, 1, 0), cross(x, y, 0, 1);
}

struct Score {
  double overlap = 0, edge = 0, p95 = 0, bias = 0;
};

Score score_of(const cv::Mat& found, const cv::Mat& truth) {
  const cv::Mat a = found >= 128, b = truth >= 128;
  std::vector<double> distances;
  append_crossings(found, recon::signed_silhouette({truth}), -1.0, distances);
  append_crossings(truth, recon::signed_silhouette({found}), 1.0, distances);
  Score score;
  score.overlap = cv::countNonZero(a & b) / std::max(1.0, static_cast<double>(cv::countNonZero(a | b)));
  // The bias is of the outline proper: what is farther than 2 px is a piece too many or too few.
  double near = 0;
  int near_count = 0;
  for (double& d : distances) {
    if (std::abs(d) < 2.0) near += d, ++near_count;
    d = std::abs(d);
  }
  std::sort(distances.begin(), distances.end());
  const auto count = std::max<std::size_t>(1, distances.size());
  score.edge = std::accumulate(distances.begin(), distances.end(), 0.0) / static_cast<double>(count);
  score.p95 = distances.empty() ? 0 : distances[distances.size() * 95 / 100];
  score.bias = near / std::max(1, near_count);
  return score;
}

cv::Mat as_sent(const cv::Mat& rgb) {
  return capture::to_rgb(capture::make_image(rgb.cols, rgb.rows, capture::PixelFormat::bayer_rg8,
                                             simulator::encode_pixels(rgb, capture::PixelFormat::bayer_rg8)));
}

struct Worst {
  double overlap = 2.0;
  cv::Mat picture;
};

cv::Mat side_by_side(const cv::Mat& rgb, const cv::Mat& found, const cv::Mat& truth) {
  cv::Mat both, out;
  cv::merge(std::vector<cv::Mat>{found, truth, truth}, both);  // red: too much, cyan: too little
  cv::hconcat(rgb, both, out);
  return out;
}

struct Totals {
  std::vector<Score> scores;
  double cpu = 0;
  Worst worst;
};

void key_one(const cv::Mat& rgb, const cv::Mat& truth, const cv::Mat& plate, Totals& totals) {
  const double start = cpu_seconds();
  const auto matte = capture::chroma_key(rgb, {}, plate);
  totals.cpu += cpu_seconds() - start;
  totals.scores.push_back(score_of(matte.alpha, truth));
  if (totals.scores.back().overlap < totals.worst.overlap)
    totals.worst = {totals.scores.back().overlap, side_by_side(rgb, matte.alpha, truth)};
}

void print(const std::string& name, const Totals& totals) {
  Score mean;
  double worst_overlap = 1, worst_bias = 0;
  const auto count = static_cast<double>(totals.scores.size());
  for (const auto& s : totals.scores) {
    mean.overlap += s.overlap / count, mean.edge += s.edge / count, mean.p95 += s.p95 / count;
    mean.bias += s.bias / count;
    worst_overlap = std::min(worst_overlap, s.overlap);
    worst_bias = std::abs(s.bias) > std::abs(worst_bias) ? s.bias : worst_bias;
  }
  fmt::print("{:24} IoU {:.4f} worst {:.4f}  edge {:.3f} px p95 {:.2f}  bias {:+.3f} worst {:+.3f} px  {:.1f} ms CPU\n",
             name, mean.overlap, worst_overlap, mean.edge, mean.p95, mean.bias, worst_bias, 1e3 * totals.cpu / count);
}

void colours(simulator::SceneRenderer& studio) {
  const auto mesh = studio.performance().surfaces_at(0.0).front();
  std::vector<recon::ColourView> views;
  const auto pictures = studio.pictures(0.0, 7);
  for (std::size_t i = 0; i < pictures.size(); ++i)
    views.push_back({studio.cameras()[i], as_sent(pictures[i].rgb), {pictures[i].matte}});
  const double start = cpu_seconds();
  const auto found = recon::surface_colour(mesh.positions, mesh.normals, mesh, views);
  const double seconds = cpu_seconds() - start;
  const auto seen = std::count(found.coverage.begin(), found.coverage.end(), 255);
  fmt::print("colour {} points, {} triangles, {} views: {:.0f} ms CPU, {:.1f} % seen\n", mesh.positions.size(),
             mesh.triangles.size(), views.size(), 1e3 * seconds,
             100.0 * static_cast<double>(seen) / static_cast<double>(mesh.positions.size()));
}

}  // namespace

int main(int argc, char** argv) {
  for (const auto& name : simulator::person_names()) {
    const auto performance = simulator::make_performance({.person = name, .act = "walk"});
    simulator::SceneRenderer studio(*performance, simulator::camera_layout());
    Totals with_plate, without;
    for (int frame = 0; frame < 24; frame += 8) {
      const auto pictures = studio.pictures(simulator::act_seconds(frame), static_cast<std::uint64_t>(frame));
      for (std::size_t i = 0; i < pictures.size(); ++i) {
        const cv::Mat rgb = as_sent(pictures[i].rgb);
        key_one(rgb, pictures[i].matte, as_sent(studio.clean_plate(i)), with_plate);
        key_one(rgb, pictures[i].matte, {}, without);
      }
    }
    print(name + ", clean plate", with_plate);
    print(name + ", plate fitted", without);
    colours(studio);
    if (argc > 1) {
      capture::write_png(std::filesystem::path(argv[1]) / (name + "-plate.png"), with_plate.worst.picture);
      capture::write_png(std::filesystem::path(argv[1]) / (name + "-fitted.png"), without.worst.picture);
    }
  }
}
