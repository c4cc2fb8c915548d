#pragma once
// The daemon as its clients see it: one connection to the control API on a Unix socket.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "rig/finding.h"
#include "rig/live_packet.h"

namespace rotunda::rig {

struct TakeProgress {
  std::string name;
  std::filesystem::path folder;
  std::uint64_t frame_sets = 0;  // on disk so far
  std::uint64_t complete = 0;    // of these, with a frame of every camera
  std::uint64_t wanted = 0;      // 0: until stopped
  bool closed = false;
  std::string failure;  // why recording ended early
  std::string slate;    // "12 B 3"
  std::uint64_t marks = 0;
  bool circled = false;
  std::string note, scene, shot;
  std::vector<std::string> warnings;
};

struct CameraStatus {
  std::string name, device, state, model, serial, pixel_format, problem;
  std::uint32_t width = 0, height = 0, packet_size = 0, socket_buffer_bytes = 0;
  std::uint64_t frames = 0, incomplete = 0, dropped = 0, resend_requests = 0;
  double rate_hz = 0.0;                          // frames in the last second or so
  std::map<std::string, std::uint64_t> missing;  // holes of the running take (or live, or the last take) by cause
  std::optional<double> clipped;                 // share of pixels at their end, 0 .. 1; nothing: no pictures come
  std::optional<double> focus;                   // 0 .. 1: how much of the finest detail is there
  std::optional<std::string> clock;              // "ptp slave" or another state of its port, "model", "none"
  std::optional<double> clock_offset_us;         // from its PTP master, or of the last reading from its model
  std::optional<double> clock_error_us;          // how wrong its time stamps may be
  std::optional<double> temperature_c;           // of the device; nothing: it does not tell
  std::optional<double> offset_us, drift_ppm;    // of exposure starts from their triggers; nothing: no pictures come
  double silent_s = 0.0;  // no frame came for so long although triggers were given; 0 while none is expected
  std::string address;    // on the network; empty: it has none, or never answered
};

// Surfaces that are made while cameras run.
struct LiveSurfacesStatus {
  std::string state = "off";  // off | waiting | running
  double rate_hz = 0.0;       // in the last seconds
  double delay_ms = 0.0;      // from trigger to surface, median of these
  std::uint64_t made = 0, shed = 0, failed = 0;
  std::uint32_t triangles = 0, viewers = 0;
  std::string problem;  // why there are none, or worse ones than could be
};

struct RigStatus {
  std::string rig, state, trigger;
  double rate_hz = 0.0;
  std::filesystem::path takes_folder;
  std::uint64_t disk_free_bytes = 0;
  double seconds_left = 0.0;
  TakeProgress take;
  std::vector<CameraStatus> cameras;
  std::uint64_t late_triggers = 0, late_frames = 0, queued_frame_sets = 0;
  double spread_median_us = 0.0, spread_p99_us = 0.0;  // of the exposure starts of a set; 0: not measured
  std::vector<std::string> warnings;
  std::vector<Finding> preflight;
  LiveSurfacesStatus surfaces;
};

// One camera of a contact sheet, as `Identify` found it.
struct IdentifiedCamera {
  std::string name, serial, address, model, problem;
  bool pictured = false;
  bool blinked = false;  // it has an indicator light
};

struct IdentifyRequest {
  std::filesystem::path picture;  // PNG, made anew
  std::string camera;             // empty: all
  bool blink = true;
};

struct TakeRequest {
  std::string name;  // empty: the next free one
  std::uint64_t frame_sets = 0;
  double duration_s = 0.0;  // used when frame_sets is 0; both 0: until stopped
  std::string note;
  std::string scene, shot;  // the take number is counted up for each; it names the take if nothing else does
};

// What is said of the running take, or of the last one. Nothing: as it was.
struct TakeAnnotation {
  std::string mark;  // at the frame set of now; only while it records
  std::optional<std::string> note;
  std::optional<bool> circled;
};

// The empty studio as one camera saw it.
struct CameraPlate {
  std::string camera;
  std::filesystem::path file;  // PNG
  std::uint64_t pictures = 0;  // it is the mean of
  double noise = 0.0;          // a pixel's standard deviation in time, grey levels; the median
  double moving_share = 0.0;   // of the pixels, 0 .. 1: somebody was there
};

struct PlateReport {
  std::filesystem::path folder;
  std::vector<CameraPlate> cameras;
  std::vector<std::string> missing;  // cameras that sent no pictures
};

struct MotionFrame;  // motion_frame.h

// Where the daemon listens: `given`, else ROTUNDA_SOCKET, else $XDG_RUNTIME_DIR/rotunda.sock, else /run/rotunda.sock.
std::filesystem::path daemon_socket(const std::filesystem::path& given = {});

// Every call throws DeviceError if the daemon does not answer or refuses for its own reasons, InvalidInput if it
// refuses the request.
class RigClient {
 public:
  explicit RigClient(const std::filesystem::path& socket);
  ~RigClient();
  RigClient(RigClient&&) noexcept;

  RigStatus status();
  // Calls `on_progress` at every change until it returns false or the take is closed. A stop request stops the take
  // and still waits for it to be closed.
  TakeProgress start_take(const TakeRequest& request, const std::function<bool(const TakeProgress&)>& on_progress,
                          std::stop_token stop);
  TakeProgress stop_take();
  TakeProgress annotate_take(const TakeAnnotation& annotation);
  // Records the empty studio; returns when its pictures are kept for the takes to come.
  PlateReport record_plate(std::uint64_t frame_sets);
  // Has the cameras triggered and their pictures watched without a take, or no longer.
  RigStatus set_live(bool on);
  std::vector<IdentifiedCamera> identify(const IdentifyRequest& request);
  // Calls `on_packet` with each live surface, the newest after a slow call, until it returns false or `stop` is asked.
  // With pictures of up to four cameras, if asked.
  void watch_live(bool pictures, const std::function<bool(LivePacket&&)>& on_packet, std::stop_token stop);
  // Calls `on_frame` with what live motion capture finds, the newest after a slow call, until it returns false or
  // `stop` is asked. The person is followed while somebody watches.
  void watch_motion(const std::function<bool(MotionFrame&&)>& on_frame, std::stop_token stop);
  // Ends calls that wait for an answer, from another thread, and any made later: they throw DeviceError. What they
  // asked for happens all the same.
  void hang_up();

 private:
  struct Connection;
  class Call;
  std::unique_ptr<Connection> connection_;
};

}  // namespace rotunda::rig
