#pragma once
// Records a take: makes its folder, appends frame sets to one file a camera, closes it. What write() has returned from
// survives the death of the process; a second thread ("take sync") brings it to disk once a second, so a power cut
// costs about that. One writer a folder (the folder is locked); use it from one thread.
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "capture/frame.h"
#include "capture/sync/sync_statistics.h"
#include "capture/take/take.h"
#include "capture/take/take_journal.h"

namespace rotunda::capture {

class CameraFileWriter;
class TakeLock;

struct TakeWriterOptions {
  std::filesystem::path folder;  // of the take itself: takes/<name>
  std::string slate;             // that of scene, shot and take number, else the folder's name, if empty
  std::string scene, shot;
  int take_number = 0;
  std::string note;
  std::string rig;                                       // the rig's name
  double fps = 25.0;                                     // frame sets a second
  std::vector<TakeCamera> cameras;                       // name, size and format, in the order of a FrameSet's slots
  std::filesystem::path rig_file;                        // copied, if given
  std::filesystem::path calibration_file;                // copied, if given
  std::filesystem::path background_folder;               // <camera>.png: the empty studio; the cameras' are copied
  std::uint64_t reserve_bytes = std::uint64_t{2} << 30;  // must be free on the disk at the start
};

class TakeWriter {
 public:
  // Throws InvalidInput (bad name, folder exists, cameras without name or size) or std::system_error (no room: ENOSPC
  // with folder, free and needed bytes). Then the folder is as it was before.
  explicit TakeWriter(const TakeWriterOptions& options);
  // Without finish() the take stays in state recording, all its frames readable.
  ~TakeWriter();
  TakeWriter(const TakeWriter&) = delete;
  TakeWriter& operator=(const TakeWriter&) = delete;

  // A hole is counted as missing, its reason kept in the take's journal. Throws InvalidInput if the slots are not the
  // cameras, std::system_error if the disk is full (1 MiB stays free for closing the take) or fails: what was written
  // before stays valid; call finish().
  void write(const FrameSet& set);

  // Kept with the trigger of the last set written.
  void mark(const std::string& text);
  void incident(const std::string& text);
  void set_note(const std::string& note) { info_.note = note; }  // into take.yaml by finish()
  void set_circled(bool circled) { info_.circled = circled; }

  // Closes the files, then says so in take.yaml. Throws std::system_error; the take then stays in state recording.
  TakeInfo finish(TakeState state = TakeState::complete);

  const TakeInfo& info() const { return info_; }  // counts so far

 private:
  void begin_folder();
  void fill_folder(const TakeWriterOptions& options);
  void require_writable(const FrameSet& set) const;
  void count_holes(const FrameSet& set);
  std::uint64_t last_trigger() const;
  void sync_every_second(const std::stop_token& stop);
  void throw_sync_failure();

  std::filesystem::path folder_;
  TakeInfo info_;
  std::unique_ptr<TakeLock> lock_;
  std::vector<CameraFileWriter> files_;
  std::optional<TakeJournalWriter> journal_;  // from fill_folder() on
  SyncStatistics sync_statistics_;
  std::mutex sync_mutex_;
  std::condition_variable_any sync_wakes_;
  std::exception_ptr sync_failure_;  // guarded by sync_mutex_
  std::jthread sync_thread_;         // last: joins before what it uses goes
};

}  // namespace rotunda::capture
