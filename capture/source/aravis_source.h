#pragma once
// GenICam cameras (GigE Vision and USB3 Vision) through unmodified Aravis 0.8.
// Pixels are handed on where Aravis put them: the buffer goes back to the stream when the last reader lets go.
#include "capture/source/source.h"

namespace rotunda::capture {

std::unique_ptr<Source> make_aravis_source(const SourceSettings& settings);

}  // namespace rotunda::capture
