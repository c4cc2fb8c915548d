#pragma once
// A camera's GenICam features by name, their values as text: a number, true or false, the word of an enumeration's
// entry. The seam between what the rig knows of cameras (PTP, clocks, settings) and how one is reached.
// Calls block like all device calls; one thread a camera.
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>

namespace rotunda::capture {

class FeatureAccess {
 public:
  virtual ~FeatureAccess() = default;
  virtual bool has(const std::string& name) = 0;  // there, and not switched off by another setting
  // Each throws DeviceError naming camera and feature.
  virtual std::string read(const std::string& name) = 0;
  virtual void write(const std::string& name, const std::string& value) = 0;
  virtual void execute(const std::string& name) = 0;
};

// The first of the names that the camera has: makers and standards call one thing differently. Empty: it has none.
std::string first_of(FeatureAccess& camera, std::initializer_list<const char*> names);

// The feature as a number; nothing if the camera answers with something else.
std::optional<std::int64_t> read_integer(FeatureAccess& camera, const std::string& name);
std::optional<double> read_number(FeatureAccess& camera, const std::string& name);

}  // namespace rotunda::capture
