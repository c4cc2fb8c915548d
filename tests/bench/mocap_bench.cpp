// How near motion capture comes to what simulated people really did:
//   mocap_bench TAKE RENDERED [FRAMES]
// RENDERED is what `rotunda-sim render` left (truth/joints.json, truth/mattes), TAKE its import. Joint errors are told
// raw, and with each joint's mean offset in its own frame taken off: the simulator's joints and the template's are not
// the same anatomical points. Overlap is that of the template with the true mattes. Baselines from the same run: the
// paper's way (silhouette overlap alone), and holding the last frame's pose.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/calibration_file.h"
#include "capture/take/take.h"
#include "recon/body/motion_capture.h"
#include "recon/take_outlines.h"

namespace {

using namespace rotunda;
using namespace rotunda::recon;
using Eigen::Vector3d;
namespace fs = std::filesystem;

using JointTrack = std::map<std::string, std::vector<Vector3d>>;

JointTrack read_truth(const fs::path& file) {
  std::ifstream stream(file);
  const auto json = nlohmann::json::parse(stream);
  JointTrack track;
  for (const auto& frame : json["frames"])
    for (std::size_t j = 0; j < json["joints"].size(); ++j) {
      const auto& p = frame["positions"][j];
      track[json["joints"][j]["name"]].emplace_back(p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
    }
  return track;
}

struct Errors {
  std::vector<double> raw, without_offset, held;  // metres
  std::map<std::string, std::pair<double, double>> by_joint;
};

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

Errors errors_of(const CapturedMotion& motion, const JointTrack& truth) {
  Errors errors;
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const std::string name(to_string(body_joint(j)));
    const auto track = truth.find(name);
    if (track == truth.end()) continue;
    std::vector<Vector3d> offsets;
    std::vector<double> raw, rest;
    for (std::size_t i = 0; i < motion.frames.size(); ++i) {
      const auto at = joint_transforms(motion.body.skeleton, motion.frames[i].fit.pose)[j];
      const auto& expected = track->second.at(motion.first_frame + i);
      raw.push_back((at.translation() - expected).norm());
      offsets.emplace_back(at.linear().transpose() * (expected - at.translation()));
      if (i > 0)
        errors.held.push_back(
            (joint_positions(motion.body.skeleton, motion.frames[i - 1].fit.pose)[j] - expected).norm());
    }
    Vector3d offset = Vector3d::Zero();
    for (const auto& o : offsets) offset += o / static_cast<double>(offsets.size());
    for (const auto& o : offsets) rest.push_back((o - offset).norm());
    errors.by_joint[name] = {mean(raw), mean(rest)};
    errors.raw.insert(errors.raw.end(), raw.begin(), raw.end());
    errors.without_offset.insert(errors.without_offset.end(), rest.begin(), rest.end());
  }
  return errors;
}

cv::Mat template_mask(const TriangleMesh& mesh, const capture::CameraModel& camera) {
  constexpr int kShift = 4, kOne = 1 << kShift;
  cv::Mat mask = cv::Mat::zeros(camera.height, camera.width, CV_8UC1);
  for (const auto& triangle : mesh.triangles) {
    std::vector<cv::Point> corners;
    for (const auto v : triangle)
      if (const auto pixel = capture::project(camera, mesh.positions[v].cast<double>()))
        corners.emplace_back(static_cast<int>(std::lround(pixel->x() * kOne)),
                             static_cast<int>(std::lround(pixel->y() * kOne)));
    if (corners.size() == 3) cv::fillConvexPoly(mask, corners, cv::Scalar(255), cv::LINE_8, kShift);
  }
  return mask;
}

// Of every view and every fifth frame.
std::vector<double> overlaps(const CapturedMotion& motion, const std::vector<capture::CameraModel>& cameras,
                             const fs::path& mattes) {
  std::vector<double> result;
  for (std::size_t i = 0; i < motion.frames.size(); i += 5) {
    const auto mesh = pose_template(motion.body, motion.frames[i].fit.pose);
    for (const auto& camera : cameras) {
      const cv::Mat truth = cv::imread(
          (mattes / camera.name / capture::frame_file_name(motion.first_frame + i)).string(), cv::IMREAD_GRAYSCALE);
      if (truth.empty()) continue;
      const cv::Mat mask = template_mask(mesh, camera), inside = truth > 127;
      result.push_back(static_cast<double>(cv::countNonZero(mask & inside)) /
                       std::max(1, cv::countNonZero(mask | inside)));
    }
  }
  return result;
}

double track_cpu_ms(const MotionCaptureReport& report) {
  for (const auto& stage : report.stages)
    if (stage.stage == "track") return stage.median_ms;
  return 0.0;
}

std::size_t lost(const CapturedMotion& motion) {
  return static_cast<std::size_t>(std::count_if(motion.frames.begin(), motion.frames.end(),
                                                [](const auto& frame) { return frame.state == TrackState::lost; }));
}

void print(const std::string& name, const MotionCaptureReport& report, const Errors& errors,
           const std::vector<double>& overlap) {
  const auto frames = static_cast<double>(report.motion.frames.size());
  fmt::print(
      "{:<10} mean {:5.1f} mm, p95 {:5.1f}; without offsets {:5.1f}, p95 {:5.1f}; overlap mean {:.3f}, p5 {:.3f}\n",
      name, 1000 * mean(errors.raw), 1000 * percentile(errors.raw, 0.95), 1000 * mean(errors.without_offset),
      1000 * percentile(errors.without_offset, 0.95), mean(overlap), percentile(overlap, 0.05));
  fmt::print(
      "{:<10} lost {:.0f} of 1000; {:.1f} frames/s, {:.0f} ms CPU a frame, all in; following {:.1f} ms a frame\n", "",
      1000.0 * static_cast<double>(lost(report.motion)) / frames, frames / report.wall_s,
      1000.0 * report.cpu_s / frames, track_cpu_ms(report));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "mocap_bench TAKE RENDERED [FRAMES]\n");
    return 2;
  }
  const fs::path rendered = argv[2];
  const auto truth = read_truth(rendered / "truth" / "joints.json");
  const auto cameras = capture::read_calibration(rendered / "truth" / "calibration.yaml");
  TakeOutlines silhouettes(argv[1], std::nullopt);
  MotionCaptureOptions options;
  if (argc > 3) options.frames = {0, static_cast<std::size_t>(std::stoul(argv[3]))};
  const auto report = capture_motion(silhouettes, options, {}, {});
  const auto errors = errors_of(report.motion, truth);
  print("rotunda", report, errors, overlaps(report.motion, cameras, rendered / "truth" / "mattes"));
  for (const auto& stage : report.stages)
    fmt::print("           {:<10} {:5} times, {:7.2f} ms CPU (median), {:6.2f} s in all\n", stage.stage, stage.count,
               stage.median_cpu_ms, stage.cpu_s);
  for (const auto& [name, both] : errors.by_joint)
    fmt::print("           {:<16} {:5.1f} mm, without offset {:5.1f}\n", name, 1000 * both.first, 1000 * both.second);
  options.only_overlap = true;
  const auto paper = capture_motion(silhouettes, options, {}, {});
  print("paper", paper, errors_of(paper.motion, truth), overlaps(paper.motion, cameras, rendered / "truth" / "mattes"));
  fmt::print("{:<10} mean {:5.1f} mm, p95 {:5.1f}\n", "last pose", 1000 * mean(errors.held),
             1000 * percentile(errors.held, 0.95));
}
