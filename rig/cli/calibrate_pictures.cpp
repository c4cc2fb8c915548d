#include "rig/cli/calibrate_pictures.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/calibration/board_folder.h"
#include "capture/calibration/board_video.h"
#include "capture/calibration/calibration_report.h"
#include "capture/calibration_file.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "rig/cli/calibrate_live.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;
using capture::CalibrationResult;
using capture::Verdict;

json to_json(const CalibrationResult& result, std::size_t i) {
  const auto& quality = result.quality[i];
  const auto& deviation = quality.deviation;
  return {{"name", result.cameras[i].name},
          {"verdict", to_string(quality.verdict)},
          {"views", quality.views},
          {"corners", quality.corners},
          {"outliers", quality.outliers},
          {"rms_px", quality.rms_px},
          {"p95_px", quality.p95_px},
          {"held_out_rms_px", quality.held_out_rms_px},
          {"outermost_radius", quality.coverage.outermost_radius},
          {"deviation",
           {{"fx", deviation.fx},
            {"fy", deviation.fy},
            {"cx", deviation.cx},
            {"cy", deviation.cy},
            {"distortion", std::vector<double>(deviation.distortion.begin(), deviation.distortion.end())},
            {"centre_m", deviation.centre},
            {"rotation_deg", deviation.rotation_deg},
            {"rim_px", deviation.rim_px}}},
          {"advice", quality.advice}};
}

json to_json(const CalibrationResult& result) {
  json cameras = json::array(), ties = json::array();
  for (std::size_t i = 0; i < result.cameras.size(); ++i) cameras.push_back(to_json(result, i));
  for (const auto& tie : result.ties)
    ties.push_back({{"cameras", {result.cameras[tie.a].name, result.cameras[tie.b].name}},
                    {"moments", tie.moments},
                    {"baseline_m", tie.baseline},
                    {"baseline_deviation_m", tie.baseline_deviation}});
  return {{"verdict", to_string(result.verdict)},
          {"world", result.world},
          {"rms_px", result.rms_px},
          {"p95_px", result.p95_px},
          {"held_out_rms_px", result.held_out_rms_px},
          {"held_out_moments", result.held_out_moments},
          {"corner_noise_px", result.corner_noise_px},
          {"corners", result.corners},
          {"outliers", result.outliers},
          {"volume_share", result.volume.share},
          {"cameras", cameras},
          {"ties", ties},
          {"problems", result.problems},
          {"advice", result.advice}};
}

void tell(const CalibrationResult& result) {
  fmt::print("{:<12} {:>8} {:>6} {:>8} {:>8} {:>8} {:>9} {:>9} {:>10} {:>9}\n", "camera", "verdict", "views",
             "outliers", "rms px", "p95 px", "held out", "centre mm", "rotation", "coverage");
  for (std::size_t i = 0; i < result.cameras.size(); ++i) {
    const auto& quality = result.quality[i];
    fmt::print("{:<12} {:>8} {:>6} {:>8} {:>8.3f} {:>8.3f} {:>9.3f} {:>9.2f} {:>9.4f}\u00b0 {:>7.0f} %\n",
               result.cameras[i].name, to_string(quality.verdict), quality.views, quality.outliers, quality.rms_px,
               quality.p95_px, quality.held_out_rms_px, 1e3 * quality.deviation.centre, quality.deviation.rotation_deg,
               100.0 * quality.coverage.outermost_radius);
  }
  fmt::print("all: rms {:.3f} px, p95 {:.3f} px, held out {:.3f} px {}; {} corners, {} left out\n", result.rms_px,
             result.p95_px, result.held_out_rms_px, held_out_where(result), result.corners, result.outliers);
  fmt::print("world: {}\n", result.world);
  for (const auto& problem : result.problems) fmt::print("problem: {}\n", problem);
  for (const auto& quality : result.quality)
    for (const auto& advice : quality.advice) fmt::print("  {}\n", advice);
  for (const auto& advice : result.advice) fmt::print("  {}\n", advice);
  fmt::print("verdict: {}\n", to_string(result.verdict));
}

void refuse_to_overwrite(const PicturesRequest& request) {
  if (request.force) return;
  for (const auto& file : {request.out, request.report})
    if (!file.empty() && fs::exists(file))
      throw InvalidInput(file.string() + " exists already: give another name, or --force to replace it");
}

void write_text(const fs::path& file, const std::string& text) {
  errno = 0;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream << text;
  if (!stream.flush())
    throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), file.string() + " cannot be written");
}

capture::CalibrateOptions options_of(const PicturesRequest& request) {
  capture::CalibrateOptions options;
  for (const auto& file : request.boards) {
    auto boards = capture::read_boards(file);
    if (boards.size() == 1 && boards.front().name == "board") boards.front().name = file.stem().string();
    options.boards.insert(options.boards.end(), boards.begin(), boards.end());
  }
  if (!request.intrinsics.empty()) options.known = capture::read_lenses(request.intrinsics);
  options.world_from = request.world_from;
  options.bend = request.bend;
  auto bar = std::make_shared<std::unique_ptr<Progress>>();
  auto shown = std::make_shared<std::string>();
  options.progress = [bar, shown](const std::string& step, std::size_t done, std::size_t total) {
    if (*shown != step || done == 1) {
      bar->reset();
      *bar = std::make_unique<Progress>(step);
      *shown = step;
    }
    (*bar)->update(done, total);
    if (done == total) bar->reset();
  };
  return options;
}

// Beside other programs' temporary files, and gone with its owner.
class ScratchFolder {
 public:
  ScratchFolder() : path_((fs::temp_directory_path() / "rotunda-boards.XXXXXX").string()) {
    if (mkdtemp(path_.data()) == nullptr) throw std::system_error(errno, std::generic_category(), path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  fs::path path() const { return path_; }

 private:
  std::string path_;
};

// Pictures stay; of videos the moments in which the board is held still become pictures first.
fs::path pictures_in(const fs::path& images, std::optional<ScratchFolder>& scratch) {
  const auto videos = capture::videos_in(images);
  if (videos.empty()) return images;
  scratch.emplace();
  Progress bar("videos");
  const auto stills = capture::write_board_stills(
      videos, scratch->path(), [&](std::size_t done, std::size_t total) { bar.update(done, total); });
  for (const auto& trouble : stills.troubles) fmt::print(stderr, "warning: {}\n", trouble);
  return scratch->path();
}

void require_boards(const PicturesRequest& request) {
  if (request.boards.empty())
    throw InvalidInput("say with --board FILE what the board is like (rotunda board writes one)");
}

int calibrate_and_write(const PicturesRequest& request, const capture::BoardPictures& pictures,
                        const capture::CalibrateOptions& options, bool as_json, const std::stop_token& stop) {
  const auto result = capture::calibrate(pictures, options, stop);
  if (as_json)
    fmt::print("{}\n", to_json(result).dump(2));
  else
    tell(result);
  if (!request.report.empty()) write_text(request.report, capture::calibration_report(result));
  const bool rejected = result.verdict == Verdict::rejected;
  if (rejected && !request.force) {
    fmt::print(stderr, "rotunda: the calibration is rejected and not written; --force writes it all the same\n");
    return kBadInput;
  }
  capture::write_calibration(request.out, result.cameras);
  return rejected || !result.problems.empty() ? kDoneWithLoss : kDone;
}

}  // namespace

void add_picture_options(CLI::App& calibrate, PicturesRequest& request) {
  calibrate.add_option("--board", request.boards, "board.yaml; once more for each further board");
  calibrate.add_option("--report", request.report, "write a report with pictures (HTML)");
  calibrate.add_option("--world-from", request.world_from,
                       "the world is this camera's frame (else the board that lay on the floor is its origin)");
  calibrate.add_option("--intrinsics", request.intrinsics,
                       "keep K and distortion of this calibration.yaml (R and t may be absent)");
  calibrate.add_flag("--bend", request.bend, "the board may sag: find by how much");
}

int calibrate_pictures(const PicturesRequest& request, bool as_json, const std::stop_token& stop) {
  require_boards(request);
  refuse_to_overwrite(request);
  const auto options = options_of(request);
  std::optional<ScratchFolder> scratch;  // until the report has its pictures
  const auto folder = capture::read_board_folder(pictures_in(request.images, scratch));
  for (const auto& skipped : folder.skipped) fmt::print(stderr, "warning: {}\n", skipped);
  const int code = calibrate_and_write(request, folder.pictures, options, as_json, stop);
  return code == kDone && !folder.skipped.empty() ? kDoneWithLoss : code;
}

int calibrate_live(const PicturesRequest& request, const fs::path& daemon, bool as_json, const std::stop_token& stop) {
  require_boards(request);
  refuse_to_overwrite(request);
  if (!request.images.empty() && fs::exists(request.images))
    throw InvalidInput(request.images.string() + " exists already: the pictures are kept in a new folder");
  const auto options = options_of(request);
  const auto walked = walk_with_board(daemon, options.boards, request.images, stop);
  if (!walked.enough) fmt::print(stderr, "warning: ended before every camera had enough\n");
  return calibrate_and_write(request, walked.pictures, options, as_json, {});
}

}  // namespace rotunda::rig
