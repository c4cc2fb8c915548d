#include "rig/cli/calibrate_check.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "capture/calibration/board_folder.h"
#include "capture/calibration/board_search.h"
#include "capture/calibration/board_watch.h"
#include "capture/calibration/take_watch.h"
#include "capture/calibration_file.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "recon/take_cameras.h"
#include "recon/take_studio.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// What is told of a camera: by what stands still behind the performer, by the performer's outlines, or by a board.
struct Checked {
  capture::CameraMove move;
  recon::CameraStanding outlines;
};

Checked together(capture::CameraMove move, const recon::CameraStanding& standing) {
  const auto& outlines = standing.shift;
  if (!outlines) return {move, standing};
  const auto by_outlines = fmt::format("outlines: {:.1f} +- {:.1f} px", outlines->shift_px, outlines->deviation_px);
  move.how = move.shift_px ? fmt::format("{}: {:.1f} px; {}", move.how, *move.shift_px, by_outlines) : by_outlines;
  if (outlines->moved || !move.shift_px) move.shift_px = outlines->shift_px;
  move.moved = move.moved || outlines->moved;
  return {move, standing};
}

// Of a take without a calibration, or in front of no screen, the background alone tells.
std::vector<recon::CameraStanding> by_outlines(const capture::TakeReader& take, const fs::path& calibration,
                                               const std::stop_token& stop) {
  const std::vector<recon::CameraStanding> nothing(take.info().cameras.size());
  if (calibration.empty() && !fs::exists(capture::calibration_file(take.folder()))) return nothing;
  const auto studio =
      recon::read_take_studio(take, calibration.empty() ? std::nullopt : std::optional<fs::path>(calibration));
  try {
    return recon::camera_standings(take, studio.views, stop);
  } catch (const InvalidInput& cannot) {
    fmt::print(stderr, "outlines tell nothing: {}\n", cannot.what());
    return nothing;
  }
}

std::vector<Checked> check_take(const CheckRequest& request, const std::stop_token& stop) {
  const capture::TakeReader take(request.take);
  const auto moves = capture::camera_moves(take, request.background);
  const auto standings = by_outlines(take, request.calibration, stop);
  std::vector<Checked> all;
  for (std::size_t i = 0; i < moves.size(); ++i) all.push_back(together(moves[i], standings[i]));
  return all;
}

capture::CameraMove by_boards(const std::string& camera, const capture::BoardShift& shift) {
  capture::CameraMove move{.camera = camera, .how = "not told: it saw no board together with another camera"};
  if (shift.corners == 0) return move;
  move.shift_px = shift.shift_px;
  move.moved = shift.moved;
  move.how = fmt::format("{} corners", shift.corners);
  if (shift.disputed) move.how += "; two cameras disagree: show the board to a third as well to tell which moved";
  return move;
}

std::vector<Checked> check_boards_seen(const CheckRequest& request, const std::stop_token& stop) {
  if (request.boards.empty() || request.calibration.empty())
    throw InvalidInput("to check with pictures of boards give --board FILE and --calibration FILE as well");
  std::vector<capture::Board> boards;
  for (const auto& file : request.boards) {
    const auto some = capture::read_boards(file);
    boards.insert(boards.end(), some.begin(), some.end());
  }
  const auto cameras = capture::read_calibration(request.calibration);
  const auto folder = capture::read_board_folder(request.images);
  const capture::BoardDetector detector(boards);
  auto search = capture::search_boards(folder.pictures, detector, {.boards = boards}, stop);
  std::vector<capture::Sighting> known;
  for (auto& sighting : search.sightings)
    for (std::size_t i = 0; i < cameras.size(); ++i)
      if (cameras[i].name == search.sizes[sighting.camera].name &&
          cameras[i].width == search.sizes[sighting.camera].width) {
        auto& renumbered = known.emplace_back(sighting);
        renumbered.camera = i;
      }
  const auto shifts = capture::board_shifts(cameras, known, boards);
  std::vector<Checked> all;
  for (std::size_t i = 0; i < cameras.size(); ++i) all.push_back({by_boards(cameras[i].name, shifts[i]), {}});
  return all;
}

json to_json(const Checked& one) {
  json entry{{"camera", one.move.camera}, {"moved", one.move.moved}, {"how", one.move.how}};
  if (one.move.shift_px) entry["shift_px"] = *one.move.shift_px;
  if (one.outlines.shift) entry["outlines"] = json::parse(recon::to_json(std::span(&one.outlines, 1))).front();
  return entry;
}

int tell(const std::vector<Checked>& all, bool as_json) {
  json list = json::array();
  bool good = true;
  for (const auto& one : all) {
    good = good && one.move.shift_px && !one.move.moved;
    list.push_back(to_json(one));
    if (as_json) continue;
    const auto shift = one.move.shift_px ? fmt::format("{:.2f} px", *one.move.shift_px) : "-";
    fmt::print("{:<12} {:>9}  {:<6} {}\n", one.move.camera, shift, one.move.moved ? "MOVED" : "", one.move.how);
  }
  if (as_json) fmt::print("{}\n", list.dump(2));
  return good ? kDone : kDoneWithLoss;
}

}  // namespace

int check_cameras(const CheckRequest& request, bool as_json, const std::stop_token& stop) {
  if (!request.take.empty()) return tell(check_take(request, stop), as_json);
  return tell(check_boards_seen(request, stop), as_json);
}

}  // namespace rotunda::rig
