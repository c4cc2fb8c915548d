#pragma once
// In which unit somebody's file is, told by a length of a body in it.
#include <optional>

namespace rotunda::recon {

struct LengthUnit {
  double metres;
  const char* name;  // for the user, plural
};

// BVH files hold motions, glTF files surfaces: each kind has units of its own besides those of all.
enum class FileOf { motion, surface };

// The likeliest unit in which the length lies between two, in metres; nothing if there is none.
struct Plausible {
  double least, most;
};
std::optional<LengthUnit> unit_of(double length, const Plausible& plausible, FileOf kind);

}  // namespace rotunda::recon
