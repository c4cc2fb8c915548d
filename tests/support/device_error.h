#pragma once
// What a call says when it fails for a device's sake.
#include <string>

#include "config/errors.h"

namespace rotunda::tests {

// The message of the DeviceError that the call throws, or "no DeviceError".
template <class Call>
std::string device_error_of(Call call) {
  try {
    call();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "no DeviceError";
}

}  // namespace rotunda::tests
