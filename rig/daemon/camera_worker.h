#pragma once
// One camera and the thread that looks after it: opens it, keeps it armed and streaming, opens it again when it is
// lost. Nothing else calls the camera, so a camera that does not answer holds up only its own thread.
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "capture/source/source.h"
#include "rig/client.h"
#include "rig/daemon/camera_status.h"

namespace rotunda::rig {

class CameraWorker {
 public:
  // The sinks get every frame, whole or not, on the camera's stream thread.
  CameraWorker(capture::SourceSettings settings, capture::FrameSink sink, capture::IncompleteSink incomplete_sink);
  ~CameraWorker();  // stops and closes the camera

  const capture::SourceSettings& settings() const { return settings_; }
  CameraStatus status() const;
  // When a frame last came, to a tenth of a second; the clock's epoch if none ever did.
  std::chrono::steady_clock::time_point last_frame() const;
  bool streaming() const;
  // True once the first attempt to open the camera has succeeded or failed.
  bool tried() const;
  // The camera's picture as it answered; 0 x 0 before it was first opened.
  capture::SourceDescription description() const;
  capture::ClockState clock() const;
  // What it puts on which link; nothing while it does not stream.
  std::optional<capture::LinkLoad> load() const;
  // How its packets follow each other from now on; returns at once, and paced() once it streams so.
  void set_pacing(const capture::StreamPacing& pacing);
  bool paced() const;
  // No frames come of it though it is triggered, or they do again: its status says so at once, and the worker asks the
  // camera whether it is there.
  void tell_silence(bool silent);
  // Nothing triggers it any more. One that was silent stays lost until it has answered a question.
  void end_silence();
  // It does not stream, or has left a question unanswered for longer than a busy camera would.
  bool gone() const;
  // Asks the thread to stop; returns at once.
  void request_stop() { thread_.request_stop(); }
  // Asks the worker to fire the camera; returns at once. Only in trigger mode `software`.
  void request_software_trigger();
  // Blinks its indicator light for so long; returns at once.
  void blink(std::chrono::milliseconds time);
  bool has_light() const;  // it blinked, the last time it was asked
  // The mode it is armed in; a camera that knows no actions is armed for software triggers instead.
  capture::TriggerMode trigger_mode() const;
  // Arms the camera anew in another trigger mode; returns at once, and it streams again a little later.
  void set_trigger_mode(capture::TriggerMode mode);

 private:
  void run(std::stop_token stop);
  void bring_up(const std::stop_token& stop);
  void wait_for_clock(const std::stop_token& stop);
  void look();
  void pace();
  void open_and_arm();
  void serve(std::stop_token stop);
  void heal();
  void refresh_status();
  void switch_light();
  void ask(const std::function<void()>& question);
  void take_down(const std::string& problem);

  capture::SourceSettings settings_;
  capture::FrameSink sink_;
  capture::IncompleteSink incomplete_sink_;
  std::unique_ptr<capture::Source> source_;  // touched by the worker's thread only

  mutable std::mutex mutex_;
  std::condition_variable_any wake_;
  CameraStatus status_;
  capture::SourceDescription description_;
  capture::SourceHealth health_;
  std::string ailment_;  // what heal() cured, until the camera is opened anew
  FrameRate rate_;
  std::uint64_t software_triggers_ = 0;              // asked for, not yet sent
  std::chrono::steady_clock::time_point next_look_;  // touched by the worker's thread only
  bool streams_ = false;                             // as the source says
  bool silent_ = false;
  bool silence_ends_ = false;                                      // with the camera's next answer
  bool probe_wanted_ = false;                                      // silence began
  std::optional<std::chrono::steady_clock::time_point> asked_at_;  // a question the camera has not answered yet
  capture::StreamPacing wanted_pacing_, pacing_;
  std::chrono::steady_clock::time_point last_frame_;
  capture::TriggerMode wanted_mode_, armed_mode_;
  bool tried_ = false;
  std::chrono::steady_clock::time_point blink_until_;
  bool has_light_ = false;
  bool lit_ = false;     // the worker's thread only
  std::jthread thread_;  // last: starts when everything else is there
};

}  // namespace rotunda::rig
