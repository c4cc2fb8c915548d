#pragma once
// The files of a take on their way into an archive and back.
#include <filesystem>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "capture/take/camera_file_rest.h"
#include "capture/take/take_verify.h"

namespace rotunda::capture {

// Progress and stop of work that several threads share.
class SharedProgress {
 public:
  SharedProgress(const Progress& progress, std::stop_token stop, std::string what);
  void expect(std::size_t total) { total_ = total; }  // before the first step
  void step();                                        // also throws as below
  void throw_if_stopped() const;                      // std::system_error operation_canceled

 private:
  const Progress& progress_;
  std::stop_token stop_;
  std::string what_;
  std::mutex mutex_;  // guards done_ and progress_
  std::size_t done_ = 0, total_ = 0;
};

// The name of a take that is to be made at `folder`. Throws InvalidInput if it cannot be one, or something is there.
std::string new_take_name(const std::filesystem::path& folder);

// All files of the take's folder but what is derived (recon/) and the archive's own, sorted, by their path in it.
// Throws InvalidInput for what is neither file nor folder, or has a name that no list of sums can hold.
std::vector<std::string> files_of_take(const std::filesystem::path& folder);
// Of these and the archive's own.
std::uint64_t bytes_of_take(const std::filesystem::path& folder);

// Makes a new file of what `write` gives, and its folder. Returns the SHA-256.
std::string write_hashed(const std::filesystem::path& file, const std::function<void(const ByteSink&)>& write);
std::string copy_file_hashed(const std::filesystem::path& from, const std::filesystem::path& to);

// The camera's file as it was recorded; `step` is called after each frame. Throws CorruptData.
void put_camera_file_together(const std::filesystem::path& archive, const TakeCamera& camera, const ByteSink& all,
                              const std::function<void()>& step);

}  // namespace rotunda::capture
