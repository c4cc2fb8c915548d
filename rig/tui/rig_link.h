#pragma once
// The page's two threads towards the daemon, so that a daemon that does not answer never holds up the screen:
// `page poll` asks for the status four times a second, `page desk` does one request after the other.
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "rig/tui/page_state.h"

namespace rotunda::rig {

class RigLink {
 public:
  explicit RigLink(const std::filesystem::path& socket);
  ~RigLink();  // hangs up: a take that records goes on

  struct News {
    std::optional<RigStatus> status;  // the newest, if one came
    std::chrono::steady_clock::time_point answered;
    std::string trouble;  // why none comes now
  };
  News news() const;

  // `takes` is where the list is read from. Returns at once.
  void ask(const PageRequest& request, const std::filesystem::path& takes);

  struct Answers {
    std::vector<std::string> messages;
    std::optional<std::vector<ListedTake>> takes;  // if they were listed
  };
  Answers take_answers();  // that came since the last call

 private:
  void poll(std::stop_token stop);
  void serve(std::stop_token stop);
  void do_and_tell(const PageRequest& request, const std::filesystem::path& takes);
  std::string done(const PageRequest& request);

  RigClient poll_client_, desk_client_;
  mutable std::mutex mutex_;
  std::condition_variable_any wake_;
  News news_;
  Answers answers_;
  std::deque<std::pair<PageRequest, std::filesystem::path>> requests_;
  std::jthread poll_, desk_;  // last
};

// The takes in storage, newest first, as the page lists them.
std::vector<ListedTake> listed_takes(const std::filesystem::path& takes);

}  // namespace rotunda::rig
