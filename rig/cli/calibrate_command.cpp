// rotunda calibrate: where the cameras stand and how they see.
#include <memory>
#include <string>

#include "config/errors.h"
#include "config/exit_code.h"
#include "rig/cli/calibrate_check.h"
#include "rig/cli/calibrate_colour.h"
#include "rig/cli/calibrate_convert.h"
#include "rig/cli/calibrate_pictures.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

struct CalibrateRequest {
  std::filesystem::path images, out, calibration;  // that several ways share
  bool force = false, live = false;
  std::string checked, take;  // --check, --colour
  bool check = false, is_colour = false;
  PicturesRequest pictures;
  ConvertRequest convert;
  ColourRequest colour;
};

int run_check(const CommandLine& line, const CalibrateRequest& request, const std::stop_token& stop) {
  CheckRequest check{.images = request.images, .calibration = request.calibration, .boards = request.pictures.boards};
  if (!request.checked.empty()) check.take = find_take(line, request.checked);
  if (check.take.empty() && check.images.empty())
    throw InvalidInput("--check needs a take, or --images DIR of boards; see rotunda calibrate --help");
  return check_cameras(check, line.json, stop);
}

int run(const CommandLine& line, CalibrateRequest request, const std::stop_token& stop) {
  if (request.check) return run_check(line, request, stop);
  if (request.out.empty()) throw InvalidInput("say with -o FILE where the calibration goes");
  request.convert.out = request.colour.out = request.pictures.out = request.out;
  request.convert.images = request.pictures.images = request.images;
  request.convert.force = request.colour.force = request.pictures.force = request.force;
  request.colour.calibration = request.calibration;
  if (request.live) return calibrate_live(request.pictures, line.daemon, line.json, stop);
  if (!request.convert.in.empty()) return convert_calibration(request.convert, line.json);
  if (request.is_colour) {
    if (!request.take.empty()) request.colour.take = find_take(line, request.take);
    request.colour.images = request.images;
    request.colour.boards = request.pictures.boards;
    return calibrate_colour(request.colour, line.json);
  }
  if (request.images.empty())
    throw InvalidInput(
        "say what to calibrate from: --images DIR, --live, --convert FILE, --colour TAKE or --check TAKE");
  return calibrate_pictures(request.pictures, line.json, stop);
}

}  // namespace

void add_calibrate_command(CommandLine& line) {
  auto* calibrate = line.app.add_subcommand(
      "calibrate", "where the cameras stand and how they see: from pictures of boards, or other programs' files");
  auto request = std::make_shared<CalibrateRequest>();
  calibrate->add_option("-o,--output", request->out, "the calibration to write");
  calibrate->add_option(
      "--images", request->images,
      "DIR/<camera>/*.png or *.jpg with boards, files of one name are one moment; or DIR/<camera>.mp4");
  calibrate->add_flag("--force", request->force, "replace what is there");
  calibrate->add_option("--calibration", request->calibration,
                        "the calibration to complete with colours (else the take's), or to check");
  add_picture_options(*calibrate, request->pictures);
  add_convert_options(*calibrate, request->convert);
  auto* ways = calibrate->add_option_group("what to do, instead of --images alone");
  ways->require_option(0, 1);
  ways->add_flag("--live", request->live,
                 "pictures from the running rig while you walk with the board; ends by itself");
  ways->add_option(calibrate->get_option("--convert"));
  auto* colour =
      ways->add_option("--colour", request->take,
                       "make cameras' colours agree: on a reconstructed take's surface, or on the white of boards "
                       "(--images, --board, --calibration)")
          ->expected(0, 1);
  auto* check =
      ways->add_option("--check", request->checked,
                       "has a camera moved? A take against its empty studio, or --images against --calibration")
          ->expected(0, 1);
  calibrate->footer(
      "Formats and their conventions: docs/calibration-formats.md\n"
      "Example:\n  rotunda calibrate --images shots --board board.yaml -o calibration.yaml --report report.html\n"
      "  rotunda calibrate --live --board board.yaml -o calibration.yaml\n"
      "  rotunda calibrate --check demo\n"
      "  rotunda calibrate --convert projections.txt --images shots -o calibration.yaml\n"
      "  rotunda calibrate --colour demo -o coloured.yaml\n"
      "  rotunda calibrate --colour --images shots --board board.yaml --calibration calibration.yaml -o coloured.yaml");
  calibrate->callback([&line, request, check, colour] {
    request->check = check->count() > 0;
    request->is_colour = colour->count() > 0;
    line.run = [&line, request](const std::stop_token& stop) { return run(line, *request, stop); };
  });
}

}  // namespace rotunda::rig
