#pragma once
// The rig drawn from three sides, as SVG: cameras as small pyramids with their names, where boards were, lines between
// cameras that saw boards together (thicker: oftener), a grid of metres. World frame, metres; parallel projection.
#include <string>

#include "capture/calibration/calibration_result.h"

namespace rotunda::capture {

enum class Side { above, front, right };  // looking along -z, +y, -x

// An <svg> of `width` pixels; its height follows from the rig.
std::string draw_rig(const CalibrationResult& result, Side side, int width);

}  // namespace rotunda::capture
