#pragma once
// The camera's GenICam description (GenApi 1.1 schema), naming the registers of device_registers.h by the Standard
// Features Naming Convention (SFNC 2.x): generated, so that sizes and formats are this camera's.
#include <string>

#include "simulator/gige/camera_options.h"

namespace rotunda::simulator {

std::string genicam_xml(const GigeCameraOptions& options);

}  // namespace rotunda::simulator
