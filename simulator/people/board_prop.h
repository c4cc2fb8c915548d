#pragma once
// The calibration board as a prop: a ChArUco pattern (Garrido-Jurado et al. 2014; OpenCV 4.6's layout) printed matt on
// a foam plate. Board frame as in board_act.h: origin at the middle of the printed face, x right, y up as one reads it,
// z out of the face; metres.
#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "simulator/people/board_act.h"
#include "simulator/people/performance.h"

namespace rotunda::simulator {

struct CharucoPattern {
  int columns = 6, rows = 4;  // squares
  double square = 0.100, marker = 0.075;
  std::string dictionary = "DICT_4X4_50";  // as OpenCV calls it
};

// A closed box with the pattern on its face, two texels a millimetre. Its bind mesh lies in the board's frame. Throws
// InvalidInput for a dictionary that is unknown or has too few markers, or a pattern that does not fit on the plate.
Figure board_figure(const CarriedBoard& plate = {}, const CharucoPattern& pattern = {});

// The board where it is carried to: the bind mesh moved as a whole.
recon::TriangleMesh carried(const recon::TriangleMesh& bind, const Eigen::Isometry3d& world_from_board);

// The inner corners by OpenCV's corner number, in the board's frame: row by row from the upper left one.
std::vector<Eigen::Vector3d> board_corners(const CharucoPattern& pattern = {});

// The pattern as board.yaml, for calibration. Throws std::system_error if the file cannot be written.
std::string board_yaml(const CharucoPattern& pattern = {});
void write_board(const std::filesystem::path& file, const CharucoPattern& pattern = {});

}  // namespace rotunda::simulator
