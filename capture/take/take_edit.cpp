#include "capture/take/take_edit.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>

#include <cerrno>
#include <system_error>

#include "capture/take/atomic_file.h"
#include "capture/take/take_lock.h"
#include "config/errors.h"

namespace rotunda::capture {

namespace fs = std::filesystem;

TakeInfo edit_take(const fs::path& folder, const TakeEdit& edit) {
  const TakeLock lock(folder);
  TakeInfo info = read_take_info(folder);
  if (edit.note) info.note = *edit.note;
  if (edit.slate) info.slate = *edit.slate;
  if (edit.circled) info.circled = *edit.circled;
  write_take_info(folder, info);
  return info;
}

fs::path rename_take(const fs::path& folder, const std::string& name) {
  if (!valid_take_name(name)) throw InvalidInput("'" + name + "' cannot be the name of a take");
  const TakeLock lock(folder);
  const auto path = fs::absolute(folder).lexically_normal();
  const auto here = path.has_filename() ? path : path.parent_path();
  const auto there = here.parent_path() / name;
  if (::renameat2(AT_FDCWD, here.c_str(), AT_FDCWD, there.c_str(), RENAME_NOREPLACE) != 0) {
    if (errno == EEXIST) throw InvalidInput(there.string() + " exists already: choose another name for the take");
    throw std::system_error(errno, std::generic_category(), fmt::format("cannot rename {} to {}", here.string(), name));
  }
  sync_folder(there.parent_path());
  return there;
}

bool is_interrupted(const fs::path& folder, const TakeInfo& info) {
  if (info.state != TakeState::recording) return false;
  try {
    const TakeLock nobody_has(folder);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace rotunda::capture
