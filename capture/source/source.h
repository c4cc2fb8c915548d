#pragma once
// One camera, real or simulated, as the daemon sees it: opened, armed, streaming, lost. Kinds of source are rows of one
// table in source.cpp. Frames come with their exposure's start by the camera's clock, moved to the rig's where that is
// not the same (capture/sync/clock_watch.h), and leave Frame::trigger to the FrameSetAssembler.
// Device calls (open, arm, look, start, stop, close, software_trigger) block up to seconds when a camera does not
// answer: call them from one thread per camera, never from a control loop. state(), stats() and description() never
// block and may be called from any thread.
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/frame.h"
#include "capture/sync/bandwidth_plan.h"
#include "capture/sync/clock_watch.h"

namespace rotunda::capture {

enum class SourceState { closed, open, armed, streaming, lost };
std::string_view to_string(SourceState state);

// closed -open-> open -arm-> armed -start-> streaming -stop-> armed; close from anywhere; lost from any but closed.
bool may_follow(SourceState from, SourceState to);
// Returns `to`; throws InvalidInput naming camera and states if it may not follow.
SourceState checked_transition(SourceState from, SourceState to, const CameraId& camera);

enum class TriggerMode { freerun, software, action, line };  // line: pulses on Line0
std::string_view to_string(TriggerMode mode);

// A camera's own control or feature, by the name its maker or driver gave it.
struct CameraControl {
  std::string name;   // "white_balance_automatic"
  std::string value;  // a number, true or false, or the word of a menu's row
};

struct WhiteBalance {
  bool auto_once = false;        // the camera finds its ratios itself, once
  double red = 1.0, blue = 1.0;  // gain of these against green's
};

struct SourceSettings {
  CameraId camera;
  std::string kind = "aravis";
  std::string device;  // aravis: IP address, serial number, user name or MAC; v4l2: path, serial number or bus address
  int width = 0;       // pixels; 0: as the camera has it
  int height = 0;
  PixelFormat format = PixelFormat::bayer_rg8;
  std::optional<int> offset_x, offset_y;  // of the region on the sensor, pixels
  std::optional<double> exposure_us;      // nothing: as the camera has it
  std::optional<double> gain_db;
  std::vector<CameraControl> controls;  // written in this order, then exposure_us; v4l2 only
  std::optional<WhiteBalance> white_balance;
  std::string user_set;                 // the camera's stored settings to start from; empty: as it is
  std::vector<CameraControl> features;  // written last, in this order; aravis only
  std::optional<double> frame_rate_hz;  // of the camera in freerun, else of the triggers
  ClockWatchOptions clock;
  std::chrono::milliseconds clock_patience{12000};  // a PTP clock is waited for so long before the camera streams
  int packet_size = 0;                              // bytes with IP and UDP headers; 0: fits the link's MTU
  TriggerMode trigger = TriggerMode::freerun;
  std::uint32_t device_key = 0;  // for TriggerMode::action
  std::uint32_t group_key = 0;
  std::uint32_t group_mask = 0;
  double resend_budget = 0.25;  // share of its packets a camera may be asked for again
  int buffers = 16;             // ready for the camera at any time
  int buffers_at_most = 64;  // with those that readers hold on to; beyond it frames are lost and counted as underruns
};

struct SourceStats {
  std::uint64_t frames = 0;      // handed on
  std::uint64_t incomplete = 0;  // came with packets missing, or not as agreed
  std::uint64_t dropped = 0;     // never came: gaps in the driver's count of frames
  std::uint64_t resend_requests = 0;
  std::uint64_t missing_packets = 0;  // of incomplete frames, from the first gap on: an upper bound
  std::uint64_t underruns = 0;        // packets, or frames, that found no buffer
  int socket_buffer_bytes = 0;        // granted; 0 until armed
  int packet_size = 0;
  bool packet_socket = false;
};

// What the camera answered when asked after arming.
struct SourceDescription {
  std::string vendor;
  std::string model;
  std::string serial;
  std::string address;
  int width = 0;
  int height = 0;
  PixelFormat format = PixelFormat::mono8;
  YcbcrCoding ycbcr = YcbcrCoding::bt601_limited;  // of frames that are Y'CbCr
  std::string link;                                // the network interface its packets come in by; empty: none
  double link_bits_per_second = 0.0;               // 0: no limit is known
  std::chrono::nanoseconds exposure{};             // 0: the camera does not tell
  std::vector<std::string> warnings;               // what works, but not as well as it should, and the cure
};

// What a camera says of itself while it works.
struct SourceHealth {
  ClockState clock;
  std::optional<double> temperature_c;  // of the device
  double asked_again = 0.0;             // share of the packets since the last look
  std::string problem;                  // of the link: what is wrong and what to do
};

// A frame that came, but not whole.
struct IncompleteFrame {
  CameraId camera;
  std::optional<Timestamp> exposure_start;  // when its first packet came
  HoleReason because = HoleReason::packets_lost;
  std::string flaw;  // what was wrong, where more is known: "cut short: 100 of 256 bytes"
};

// Both are called on the camera's stream thread, and must only pass things on. Neither may call the source.
using FrameSink = std::function<void(Frame&&)>;
using IncompleteSink = std::function<void(const IncompleteFrame&)>;

class Source {
 public:
  virtual ~Source() = default;

  // Each throws InvalidInput when called in the wrong state, DeviceError when the camera does not play along.
  virtual void open() = 0;
  virtual void arm() = 0;  // writes the settings, reads them back, makes the buffers ready
  // How the packets follow each other, for kinds of source whose link is shared. Armed.
  virtual void pace(const StreamPacing&) {}
  virtual void start(FrameSink frames, IncompleteSink incomplete = {}) = 0;
  virtual void stop() = 0;              // no sink is called after it returns
  virtual void software_trigger() = 0;  // while streaming, TriggerMode::software
  // Asks how the camera is, and follows its clock: once a second will do. Armed or streaming. A camera that does not
  // answer is lost. Kinds of source that have nothing to tell tell nothing.
  virtual SourceHealth look() { return {}; }
  // Switches its indicator light, for people who look which camera it is; false if it has none. While open.
  virtual bool show_light(bool) { return false; }
  virtual void close() noexcept = 0;  // frames that readers hold stay good
  // While streaming, every now and then: if the camera sends and yet no frame comes of it any more, receives it anew
  // and returns what was wrong. Nothing if all is well. Blocks like the calls above.
  virtual std::optional<std::string> heal() { return std::nullopt; }

  virtual SourceState state() const = 0;  // lost: the camera went away; close it, then open it anew
  virtual SourceStats stats() const = 0;
  virtual SourceDescription description() const = 0;
};

// Throws InvalidInput for a kind there is no row for, naming those there are.
std::unique_ptr<Source> make_source(const SourceSettings& settings);
std::vector<std::string> source_kinds();

struct DiscoveredCamera {
  std::string kind;
  std::string address;
  std::string serial;
  std::string user_name;
  std::string vendor;
  std::string model;
  std::string mac;
  std::string pixel_format;  // one that it sends, where the kind of source tells
};

// Every camera that answers, of every kind, sorted by kind and address. Takes a second or so.
std::vector<DiscoveredCamera> discover_cameras();

}  // namespace rotunda::capture
