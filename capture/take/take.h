#pragma once
// A take on disk: what take.yaml says, where takes lie, what they may be called. The folder's format is
// docs/take-format.md; frames are written by take_writer.h and read by take_reader.h.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "capture/frame.h"
#include "capture/sync/sync_statistics.h"

namespace rotunda::capture {

// recording: a writer has it open, or was killed while it had; recovered: was recording, counted anew afterwards.
enum class TakeState { recording, complete, recovered };

std::string_view to_string(TakeState state);

struct TakeCamera {
  CameraId name;
  int width = 0;   // pixels
  int height = 0;  // pixels
  PixelFormat format = PixelFormat::mono8;
  YcbcrCoding ycbcr = YcbcrCoding::bt601_limited;     // of formats that are Y'CbCr
  std::size_t frames = 0;                             // on disk
  std::size_t missing = 0;                            // frame sets without this camera's frame
  std::map<HoleReason, std::size_t> missing_because;  // of these, those the writer knew the reason of
};

struct TakeInfo {
  std::string name;  // of the folder
  TakeState state = TakeState::recording;
  double fps = 0.0;      // frame sets a second
  Timestamp start;       // moment of the first trigger
  std::string recorded;  // "2026-11-22T09:30:00Z": when the folder was made, for people
  std::string slate;     // what stands on the clapperboard
  std::string scene, shot;
  int take_number = 0;   // of the scene and shot, from 1; 0: none
  bool circled = false;  // the take to use
  std::string note;
  std::string rig;                  // name of the rig; empty for an import
  std::vector<TakeCamera> cameras;  // in the rig's order, which is the order of a FrameSet's slots
  std::uint64_t first_trigger = 0;  // frame set 0 is this trigger's
  std::size_t frame_sets = 0;       // triggers from the first to the last recorded, whole or not
  std::size_t complete_sets = 0;    // of these, with every camera's frame
  SyncSummary sync;                 // as measured while recording; no sets: it was not
};

// FOLDER/take.yaml. Reading throws ConfigError with every mistake, line and column, or InvalidInput if there is no
// such file; writing replaces the file in one step that survives a power cut and throws std::system_error.
TakeInfo read_take_info(const std::filesystem::path& folder);
void write_take_info(const std::filesystem::path& folder, const TakeInfo& info);

// A take's or a camera's name becomes a file name: nothing that leaves the folder (separators, "..", a leading dot),
// no control characters nor what other systems refuse (: * ? " < > |), at most 100 bytes.
bool valid_take_name(std::string_view name);

// The next take number of a scene and shot among the takes under `root`.
int next_take_number(const std::filesystem::path& root, std::string_view scene, std::string_view shot);

// The takes under `root`, by name. A folder whose take.yaml cannot be read is no take; why is added to `problems`,
// if given. A root that does not exist holds none.
std::vector<TakeInfo> list_takes(const std::filesystem::path& root, std::vector<std::string>* problems = nullptr);

// The folder of the take called `name_or_path`: root/name first, else the path itself. Throws InvalidInput that says
// where was looked and which takes there are.
std::filesystem::path resolve_take(const std::string& name_or_path, const std::filesystem::path& root);

// "12 B 3": as it stands on the clapperboard; empty without scene and shot.
std::string slate_text(std::string_view scene, std::string_view shot, int take_number);

// Where the parts of a take lie.
std::filesystem::path camera_file(const std::filesystem::path& folder, const CameraId& camera);
std::filesystem::path calibration_file(const std::filesystem::path& folder);
std::filesystem::path background_file(const std::filesystem::path& folder, const CameraId& camera);
std::filesystem::path matte_file(const std::filesystem::path& folder, const CameraId& camera, std::size_t frame);

// "frame000012.png": the name of a frame's picture wherever pictures are numbered.
std::string frame_file_name(std::size_t frame, std::string_view extension = "png");

}  // namespace rotunda::capture
