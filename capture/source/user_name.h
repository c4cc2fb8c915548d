#pragma once
// The user-defined name of a GigE Vision camera, which Aravis does not tell: one GVCP READMEM, which needs no control.
#include <string>

namespace rotunda::capture {

// Empty if the camera has none, or does not answer within a second.
std::string read_user_name(const std::string& address);

}  // namespace rotunda::capture
