#include "rig/cli/calibrate_colour.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "capture/calibration/board_colours.h"
#include "capture/calibration/colour_match.h"
#include "capture/calibration_file.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "recon/colour/colour_samples.h"
#include "recon/take_studio.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kFrames = 8;      // spread over the take: other poses show other cloth to other cameras
constexpr double kPoorAgreement = 8.0;  // levels; what is left of gloss and small offsets stays below

std::vector<std::size_t> reconstructed_frames(const fs::path& take, std::size_t count) {
  std::vector<std::size_t> frames;
  for (std::size_t frame = 0; frame < count; ++frame)
    if (fs::exists(take / "recon" / "frames" / capture::frame_file_name(frame, "ply"))) frames.push_back(frame);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < std::min(kFrames, frames.size()); ++i)
    chosen.push_back(frames[i * frames.size() / std::min(kFrames, frames.size())]);
  return chosen;
}

std::vector<capture::ColourSample> samples_of_take(const capture::TakeReader& take, const recon::TakeStudio& studio,
                                                   const std::vector<std::string>& names) {
  const auto frames = reconstructed_frames(take.folder(), take.frame_set_count());
  if (frames.empty())
    throw InvalidInput(fmt::format("{} has no surface whose colours could be compared: run rotunda recon {} first",
                                   take.info().name, take.info().name));
  std::vector<capture::ColourSample> samples;
  std::size_t places = 0;
  Progress bar("comparing colours");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto surface = recon::frame_surface(take.folder(), frames[i]);
    recon::StageClock clock;
    const auto views =
        recon::key_frame(take.read(frames[i]), studio.views, recon::given_mattes(take, frames[i]), clock);
    const auto more = recon::colour_samples(*surface, views, names, places);
    samples.insert(samples.end(), more.begin(), more.end());
    places += surface->positions.size();
    bar.update(i + 1, frames.size());
  }
  return samples;
}

json to_json(const std::string& name, const capture::CameraColourMatch& camera) {
  const auto& m = camera.matrix;
  json matrix = json::array();
  for (Eigen::Index row = 0; row < 3; ++row) matrix.push_back({m(row, 0), m(row, 1), m(row, 2)});
  return {{"name", name},          {"samples", camera.samples},       {"before", camera.before},
          {"after", camera.after}, {"gains_only", camera.gains_only}, {"colour", matrix}};
}

void tell(const std::vector<std::string>& names, const capture::ColourMatch& match, const fs::path& out, bool as_json) {
  if (as_json) {
    json cameras = json::array();
    for (std::size_t i = 0; i < names.size(); ++i) cameras.push_back(to_json(names[i], match.cameras[i]));
    fmt::print("{}\n", json{{"before", match.before},
                            {"after", match.after},
                            {"cameras", cameras},
                            {"advice", match.advice},
                            {"file", out.string()}}
                           .dump(2));
    return;
  }
  fmt::print("{:<10} {:>8} {:>8} {:>8}   {:>6} {:>6} {:>6}\n", "camera", "samples", "before", "after", "red", "green",
             "blue");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto& camera = match.cameras[i];
    const Eigen::Vector3d gains = camera.matrix.rowwise().sum();
    fmt::print("{:<10} {:>8} {:>8.2f} {:>8.2f}   {:>6.3f} {:>6.3f} {:>6.3f}{}\n", names[i], camera.samples,
               camera.before, camera.after, gains[0], gains[1], gains[2],
               camera.gains_only ? "  gains alone: too grey for more" : "");
  }
  fmt::print("cameras differ by {:.2f} levels of 255 before, {:.2f} after (RMS, a tenth left out): {}\n", match.before,
             match.after, out.string());
  for (const auto& sentence : match.advice) fmt::print(stderr, "warning: {}\n", sentence);
  if (match.after > kPoorAgreement)
    fmt::print(stderr, "warning: {:.1f} levels are left: is the calibration right, and is the surface not glossy?\n",
               match.after);
}

capture::ColourMatch match_on_take(const ColourRequest& request, const fs::path& calibration,
                                   std::vector<std::string>& names) {
  const capture::TakeReader take(request.take);
  const auto studio = recon::read_take_studio(take, calibration);
  for (const auto& camera : studio.views.cameras) names.push_back(camera.name);
  return capture::match_colours(names, samples_of_take(take, studio, names));
}

// Of cameras that the calibration has; pictures of others are passed over.
capture::ColourMatch match_on_boards(const ColourRequest& request, const capture::CalibrationFile& calibration,
                                     std::vector<std::string>& names) {
  std::vector<capture::Board> boards;
  for (const auto& file : request.boards) {
    const auto some = capture::read_boards(file);
    boards.insert(boards.end(), some.begin(), some.end());
  }
  capture::BoardColours colours;
  {
    Progress bar("boards");
    colours = capture::colours_of_boards(request.images, boards,
                                         [&](std::size_t done, std::size_t total) { bar.update(done, total); });
  }
  for (const auto& camera : calibration.cameras)
    if (std::find(colours.cameras.begin(), colours.cameras.end(), camera.name) != colours.cameras.end())
      names.push_back(camera.name);
  std::vector<capture::ColourSample> samples;
  for (auto sample : colours.samples) {
    const auto name = std::find(names.begin(), names.end(), colours.cameras[sample.camera]);
    if (name == names.end()) continue;
    sample.camera = static_cast<std::size_t>(name - names.begin());
    samples.push_back(sample);
  }
  return capture::match_colours(names, samples);
}

}  // namespace

int calibrate_colour(const ColourRequest& request, bool as_json) {
  if (!request.force && fs::exists(request.out))
    throw InvalidInput(request.out.string() + " exists already: give another name, or --force to replace it");
  const bool on_boards = request.take.empty();
  if (on_boards && (request.images.empty() || request.boards.empty() || request.calibration.empty()))
    throw InvalidInput(
        "--colour needs a reconstructed take, or pictures of boards: --images DIR --board FILE --calibration FILE");
  const auto file = request.calibration.empty() ? capture::calibration_file(request.take) : request.calibration;
  std::vector<std::string> names;
  auto calibration = capture::read_calibration_file(file);
  const auto match = on_boards ? match_on_boards(request, calibration, names) : match_on_take(request, file, names);
  for (std::size_t i = 0; i < names.size(); ++i) calibration.colour[names[i]] = match.cameras[i].matrix;
  capture::write_calibration(request.out, calibration);
  tell(names, match, request.out, as_json);
  return match.advice.empty() ? kDone : kDoneWithLoss;
}

}  // namespace rotunda::rig
