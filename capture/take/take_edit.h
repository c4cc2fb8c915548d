#pragma once
// Changes what is said of a take, never a frame of it.
#include <filesystem>
#include <optional>
#include <string>

#include "capture/take/take.h"

namespace rotunda::capture {

// Nothing: as it was.
struct TakeEdit {
  std::optional<std::string> note, slate;
  std::optional<bool> circled;
};

// Throws InvalidInput while the take is recorded, what read_take_info does, std::system_error.
TakeInfo edit_take(const std::filesystem::path& folder, const TakeEdit& edit);

// Gives it another name in the same storage and returns its new folder; in one step, never over another take. Throws
// InvalidInput (no name, taken, being recorded), std::system_error.
std::filesystem::path rename_take(const std::filesystem::path& folder, const std::string& name);

// Its writer died: state recording, and nobody records.
bool is_interrupted(const std::filesystem::path& folder, const TakeInfo& info);

}  // namespace rotunda::capture
