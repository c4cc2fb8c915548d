#pragma once
// A camera's images as a Matroska video track: under which name players know them. docs/take-format.md has the table.
#include "capture/frame.h"
#include "capture/take/take.h"

struct AVCodecParameters;

namespace rotunda::capture {

// Pixels as the camera sent them: V_UNCOMPRESSED as Y800 (mono, Bayer) or under its own name (Y'CbCr), or V_MJPEG.
void describe_as_it_came(AVCodecParameters& parameters, const TakeCamera& camera);
// True if that is how `parameters` describe the format.
bool is_as_it_came(const AVCodecParameters& parameters, PixelFormat format);
// Pixels in a row of such a track, whose width counts bytes where the samples went in as grey.
int pixels_across(const AVCodecParameters& parameters, PixelFormat format);

void describe_colours(AVCodecParameters& parameters, YcbcrCoding coding);
YcbcrCoding coding_of(const AVCodecParameters& parameters);

}  // namespace rotunda::capture
