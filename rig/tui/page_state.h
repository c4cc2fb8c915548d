#pragma once
// What the operator's page shows and what has been typed into it; changed by news of the daemon and by keys.
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rig/client.h"

namespace rotunda::rig {

enum class View { rig, takes, help };
enum class Prompt { none, note, scene, shot };  // the line that is being typed

struct ListedTake {
  std::string name, state, slate, note;
  std::filesystem::path folder;
  std::uint64_t frame_sets = 0, complete = 0;
  double seconds = 0.0;
  bool circled = false;
  bool reconstructed = false;    // can be played
  bool at_live_quality = false;  // can be played so: the daemon's look at it after the take
};

struct PageState {
  std::optional<RigStatus> status;     // the newest; nothing: the daemon never answered
  double status_age_s = 0.0;           // since it came
  std::string trouble;                 // why the daemon does not answer; empty if it does
  std::map<std::string, double> peak;  // of each camera's focus since it was last forgotten, 0 .. 1
  View view = View::rig;
  Prompt prompt = Prompt::none;
  std::string input;              // typed so far
  std::string scene, shot;        // of the next take
  bool slate_known = false;       // scene and shot were typed, or taken over from the daemon's last take
  std::string message;            // the answer to the last key
  std::vector<ListedTake> takes;  // newest first
  std::size_t selected = 0;       // of these
  bool quit = false;
};

// Something for the daemon, the storage or a player to do.
struct PageRequest {
  enum class Kind { arm, disarm, record, stop, mark, note, circle, list_takes, note_take, circle_take, play };
  Kind kind = Kind::arm;
  std::string text;  // note
  std::string scene, shot;
  bool on = true;   // circle
  ListedTake take;  // of the list
};

// News of the daemon: status, peaks, the slate to go on with.
void take_status(PageState& state, const RigStatus& status);

// How a camera does, for its row's colour.
enum class Health { good, warn, lost };
// lost: it does not stream, or no frame came for two periods (a third of a second at least) although it should.
Health health_of(const CameraStatus& camera, double rate_hz);

// A take is being recorded as far as the newest status tells.
bool recording(const PageState& state);

}  // namespace rotunda::rig
