#include "recon/body/length_unit.h"

#include <algorithm>
#include <array>

namespace rotunda::recon {
namespace {

struct Row {
  LengthUnit unit;
  bool in_motions, in_surfaces;
};

// To know another unit: a row here, likelier ones first.
// 0.0564 m: the unit of the ASF files of Carnegie Mellon's database (1 in / 0.45).
constexpr std::array<Row, 6> kUnits = {{{{1.0, "metres"}, true, true},
                                        {{0.01, "centimetres"}, true, true},
                                        {{0.0254, "inches"}, true, true},
                                        {{0.0564, "units of CMU's database"}, true, false},
                                        {{0.001, "millimetres"}, true, true},
                                        {{100.0, "metres, shrunk a hundred times"}, true, true}}};

}  // namespace

std::optional<LengthUnit> unit_of(double length, const Plausible& plausible, FileOf kind) {
  const auto fits = [&](const Row& row) {
    const double metres = length * row.unit.metres;
    return (kind == FileOf::motion ? row.in_motions : row.in_surfaces) && metres > plausible.least &&
           metres < plausible.most;
  };
  const auto* found = std::find_if(kUnits.begin(), kUnits.end(), fits);
  return found != kUnits.end() ? std::optional(found->unit) : std::nullopt;
}

}  // namespace rotunda::recon
