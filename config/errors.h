#pragma once
// What the house throws when the caller cannot go on. Programs map them to exit codes (config/exit_code.h):
// ConfigError, InvalidInput and CorruptData to 3; DeviceError and std::system_error to 4. What is expected to
// happen (a lost frame, a solver that stops short) is a value, never one of these.
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace rotunda {

// One mistake in a settings file. Lines and columns count from 1; 0 where the file as a whole is meant.
struct ConfigProblem {
  int line = 0;
  int column = 0;
  std::string key;      // dotted path, e.g. "cameras[3].exposure_us"; empty for the whole file
  std::string message;  // what was expected, what was found, what to do
};

// A settings file that cannot be used; carries every mistake found in one reading.
class ConfigError : public std::runtime_error {
 public:
  ConfigError(const std::filesystem::path& file, std::vector<ConfigProblem> problems);
  const std::vector<ConfigProblem>& problems() const { return problems_; }

 private:
  std::vector<ConfigProblem> problems_;
};

// The caller's mistake: spans of unequal size, an empty silhouette, a name that is not in the calibration.
class InvalidInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A file that is not what it says it is. The offset, where known, is in bytes from its start.
class CorruptData : public std::runtime_error {
 public:
  CorruptData(const std::filesystem::path& file, std::uint64_t offset, const std::string& what);
  explicit CorruptData(const std::string& what) : std::runtime_error(what) {}
};

// A camera, trigger or display that does not do what it must; the message names it first.
class DeviceError : public std::runtime_error {
 public:
  DeviceError(const std::string& device, const std::string& what);
};

}  // namespace rotunda
