// rotunda calibrate: where the cameras stand and how they see.
#include <memory>
#include <string>

#include "config/exit_code.h"
#include "rig/cli/calibrate_colour.h"
#include "rig/cli/calibrate_convert.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

struct CalibrateRequest {
  ConvertRequest convert;
  std::string take;  // --colour
  ColourRequest colour;
};

int run(const CommandLine& line, CalibrateRequest request) {
  if (!request.convert.in.empty()) return convert_calibration(request.convert, line.json);
  if (!request.take.empty()) request.colour.take = find_take(line, request.take);
  request.colour.out = request.convert.out;
  request.colour.force = request.convert.force;
  return calibrate_colour(request.colour, line.json);
}

}  // namespace

void add_calibrate_command(CommandLine& line) {
  auto* calibrate =
      line.app.add_subcommand("calibrate", "calibrations: converts other programs' files, matches colours");
  auto request = std::make_shared<CalibrateRequest>();
  calibrate->add_option("-o,--output", request->convert.out, "the calibration to write")->required();
  calibrate->add_option("--images", request->convert.images, "DIR/<camera>/*.png or *.jpg");
  calibrate->add_flag("--force", request->convert.force, "replace what is there");
  add_convert_options(*calibrate, request->convert);
  auto* ways = calibrate->add_option_group("what to do");
  ways->require_option(1);
  ways->add_option(calibrate->get_option("--convert"));
  ways->add_option("--colour", request->take, "a reconstructed take: make cameras' colours agree on its surface");
  ways->add_option("--colour-card", request->colour.card,
                   "pictures of a ColorChecker held in the volume, DIR/<camera>/*.png: make colours agree, and true");
  calibrate->add_option("--calibration", request->colour.calibration, "to complete with colours (else the take's)");
  calibrate->footer(
      "Formats and their conventions: docs/calibration-formats.md\n"
      "Example:\n  rotunda calibrate --convert projections.txt --images shots -o calibration.yaml\n"
      "  rotunda calibrate --colour demo -o calibration.yaml");
  calibrate->callback(
      [&line, request] { line.run = [&line, request](std::stop_token) { return run(line, *request); }; });
}

}  // namespace rotunda::rig
