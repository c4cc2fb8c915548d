#include "capture/take/workplace.h"

#include <utility>

#include "capture/take/atomic_file.h"
#include "capture/take/take_lock.h"

namespace rotunda::capture {

namespace fs = std::filesystem;

Workplace::Workplace(fs::path folder) : folder_(std::move(folder)) {
  fs::create_directories(folder_);
  lock_ = std::make_unique<TakeLock>(folder_);
  for (const auto& left_over : fs::directory_iterator(folder_)) fs::remove_all(left_over.path());
}

Workplace::~Workplace() {
  std::error_code best_effort;
  if (lock_) fs::remove_all(folder_, best_effort);
}

void Workplace::keep_as(const fs::path& part, const fs::path& take) {
  sync_filesystem(part);
  fs::rename(part, take);
  if (part == folder_) lock_.reset();
  sync_folder(take.parent_path());
}

}  // namespace rotunda::capture
