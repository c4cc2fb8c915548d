#include "rig/cli/calibrate_convert.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/calibration/calibration_format.h"
#include "config/errors.h"
#include "config/exit_code.h"

namespace rotunda::rig {
namespace {

using capture::CalibrationFormat;
using nlohmann::json;
namespace fs = std::filesystem;

std::optional<std::pair<int, int>> size_in(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const auto cross = text.find('x');
  int width = 0, height = 0;
  const char* end = text.data() + text.size();
  if (cross != std::string::npos &&
      std::from_chars(text.data(), text.data() + cross, width).ptr == text.data() + cross &&
      std::from_chars(text.data() + cross + 1, end, height).ptr == end && width > 0 && height > 0)
    return std::pair{width, height};
  throw InvalidInput("--image-size " + text + ": expected WIDTHxHEIGHT in pixels, as 720x576");
}

CalibrationFormat source_format(const ConvertRequest& request) {
  if (!fs::exists(request.in)) throw InvalidInput(request.in.string() + " does not exist");
  return request.from.empty() ? capture::format_of_file(request.in) : *capture::format_named(request.from);
}

CalibrationFormat target_format(const ConvertRequest& request) {
  return request.to.empty() ? capture::format_of_name(request.out) : *capture::format_named(request.to);
}

void require_free_place(const ConvertRequest& request, CalibrationFormat to) {
  const auto place = to == CalibrationFormat::colmap ? request.out / "cameras.txt" : request.out;
  if (!request.force && fs::exists(place))
    throw InvalidInput(place.string() + " exists already: give another name, or --force to replace it");
}

// What cannot be kept stops the conversion unless it is wanted so.
void permit(const std::vector<std::string>& losses, const ConvertRequest& request, CalibrationFormat to) {
  if (losses.empty() || request.allow_loss) return;
  throw InvalidInput(
      fmt::format("{} cannot hold all of this calibration:\n  {}\nwrite another format, or convert all the same "
                  "with --allow-loss",
                  capture::to_string(to), fmt::join(losses, "\n  ")));
}

bool left_handed(const capture::CalibrationFile& calibration) {
  for (const auto& camera : calibration.cameras)
    if (camera.R.determinant() < 0.0) return true;
  return false;
}

void tell(const ConvertRequest& request, const capture::ImportedCalibration& imported, CalibrationFormat from,
          CalibrationFormat to, const std::vector<std::string>& losses, bool as_json) {
  const auto& calibration = imported.calibration;
  if (as_json) {
    fmt::print("{}\n", json{{"from", to_string(from)},
                            {"to", to_string(to)},
                            {"file", request.out.string()},
                            {"cameras", calibration.cameras.size()},
                            {"unit", calibration.unit},
                            {"left_handed", left_handed(calibration)},
                            {"notes", imported.notes},
                            {"lost", losses}}
                           .dump(2));
    return;
  }
  fmt::print("{} cameras from {} ({}) to {} ({})\n", calibration.cameras.size(), request.in.string(), to_string(from),
             request.out.string(), to_string(to));
  for (const auto& note : imported.notes) fmt::print("note: {}\n", note);
  for (const auto& loss : losses) fmt::print(stderr, "warning: lost: {}\n", loss);
}

}  // namespace

void add_convert_options(CLI::App& calibrate, ConvertRequest& request) {
  const auto formats = CLI::IsMember({"opencv", "json", "projections", "colmap"});
  auto* convert = calibrate.add_option(
      "--convert", request.in,
      "another program's calibration: OpenCV YAML, JSON, projection matrices in text, COLMAP's text folder");
  const auto add = [&](const std::string& name, auto& into, const std::string& what) {
    return calibrate.add_option(name, into, what)->needs(convert);
  };
  add("--from", request.from, "its format, if its content does not tell")->check(formats);
  add("--to", request.to, "the format to write, if the name's ending does not tell")->check(formats);
  add("--image-size", request.image_size, "WxH of cameras whose size the file does not say");
  add("--unit", request.unit, "what lengths are measured in, as m");
  calibrate.add_flag("--mirror", request.mirror, "turn the world's z round: left-handed becomes right-handed")
      ->needs(convert);
  calibrate.add_flag("--allow-loss", request.allow_loss, "also write what the format cannot wholly hold")
      ->needs(convert);
}

int convert_calibration(const ConvertRequest& request, bool as_json) {
  const auto from = source_format(request), to = target_format(request);
  require_free_place(request, to);
  auto imported = capture::read_any_calibration(request.in, from);
  auto& calibration = imported.calibration;
  capture::complete_sizes(calibration, request.images, size_in(request.image_size));
  if (!request.unit.empty()) calibration.unit = request.unit;
  if (request.mirror) {
    capture::mirror_world(calibration);
    imported.notes.emplace_back("the world's z was turned round");
  }
  const auto losses = capture::losses_in(calibration, to);
  permit(losses, request, to);
  capture::write_any_calibration(request.out, calibration, to);
  tell(request, imported, from, to, losses, as_json);
  return losses.empty() ? kDone : kDoneWithLoss;
}

}  // namespace rotunda::rig
