#pragma once
// A hidden folder beside the takes in which one grows until it is whole; gone with all that is in it if it never gets
// so. What a killed one left there goes when the next begins.
#include <filesystem>
#include <memory>

namespace rotunda::capture {

class TakeLock;

class Workplace {
 public:
  // Throws InvalidInput if somebody works there already, std::system_error.
  explicit Workplace(std::filesystem::path folder);
  ~Workplace();
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  // `part`, the folder or one in it, becomes `take` in one step, brought to disk before and after.
  void keep_as(const std::filesystem::path& part, const std::filesystem::path& take);

 private:
  std::filesystem::path folder_;
  std::unique_ptr<TakeLock> lock_;
};

}  // namespace rotunda::capture
