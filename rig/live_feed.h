#pragma once
// The daemon's live surfaces as a viewer gets them, received and unpacked in a thread of its own ("live feed"), which
// comes back to a daemon that was gone. Safe from any thread.
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "playback/live_stage.h"

namespace rotunda::rig {

class LiveFeed {
 public:
  LiveFeed(const std::filesystem::path& socket, bool with_pictures);

  // The newest view that was not taken yet; nothing if there is none.
  std::optional<playback::LiveView> take();
  // As take(), waiting for one so long at most, or until `stop`.
  std::optional<playback::LiveView> wait(std::chrono::milliseconds patience, std::stop_token stop = {});
  std::string problem() const;  // why nothing comes; empty while it is connected

 private:
  void receive(const std::stop_token& stop);

  const std::filesystem::path socket_;
  const bool with_pictures_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<playback::LiveView> newest_;
  std::string problem_;
  std::jthread thread_;  // last
};

}  // namespace rotunda::rig
