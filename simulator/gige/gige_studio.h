#pragma once
// N simulated GigE Vision cameras in one process, each on its own address of this machine (127.0.0.1, 127.0.0.2, ...),
// unprivileged. Owns their sockets and two threads: "gige-control" answers GVCP on port 3956, "gige-sender" streams.
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "capture/frame.h"
#include "simulator/gige/camera_options.h"
#include "simulator/gige/device_registers.h"
#include "simulator/gige/fault_schedule.h"

namespace rotunda::simulator {

// What a camera sees in an exposure that starts then: width x height pixels of the camera's format, as they lie in a
// Frame. Called on the sender thread when the exposure is over, once a frame, so it must be quick: look it up in a
// cache. The pixels must stay valid and unchanged until the eighth following call for the same camera (they are sent
// without a copy and kept for resending), or until the studio has stopped.
// The camera counts as giving no picture if the span has another size or the call throws: the frame is skipped.
using PictureAt = std::function<std::span<const std::uint8_t>(std::size_t camera, capture::Timestamp exposure_start)>;

// Makes of such a picture, of an exposure that starts then, what the camera gives with the settings a client has
// written; the same size. Called only while these are not the ones the camera was made with.
using ReExpose =
    std::function<std::vector<std::uint8_t>(std::size_t camera, capture::Timestamp exposure_start,
                                            const ImageSettings& settings, std::span<const std::uint8_t> picture)>;

// One exposure as it truly was, whatever the camera's clock says and whatever becomes of its packets.
struct Exposure {
  std::size_t camera = 0;
  std::uint64_t block = 0;  // as the stream numbers the frame
  capture::Timestamp start;
  std::chrono::nanoseconds duration{};
};
// Told on the sender thread of every exposure whose frame goes out, so it must be quick.
using OnExposure = std::function<void(const Exposure&)>;

struct GigeStats {
  std::uint64_t frames_sent = 0;
  std::uint64_t missing_pictures = 0;  // PictureAt gave none, so no frame was sent
  std::uint64_t packets_sent = 0, packets_lost = 0, packets_resent = 0, packets_unavailable = 0, send_errors = 0;
  std::uint64_t resend_requests = 0;
  std::uint64_t triggers = 0, ignored_triggers = 0, late_actions = 0;
  std::uint64_t denied = 0;            // commands of others than the controller
  std::uint64_t lost_controllers = 0;  // heartbeats that stopped
  std::uint64_t pending_acks = 0;      // commands told to take long
  bool has_controller = false, is_acquiring = false;
  FaultCounts faults;               // how often each kind fired
  std::vector<FaultKind> in_force;  // of those that were added
};

struct GigeStudioOptions {
  double link_bits_per_second = 1e9;  // of each camera, paces its packets; 0: each frame leaves in one burst
  OnExposure on_exposure;
  ReExpose re_expose;                             // nothing: pictures are as PictureAt gives them, whatever is written
  std::optional<std::uint16_t> trigger_box_port;  // listens there for trigger_box.h's edges of Line0; 0: any port
};

class GigeStudio {
 public:
  // Takes the cameras' addresses. Throws DeviceError if an address or its port 3956 is not to be had, InvalidInput if
  // two cameras share a name, serial, address or MAC or an option does not fit.
  GigeStudio(const std::vector<GigeCameraOptions>& cameras, PictureAt picture_at,
             const GigeStudioOptions& options = {});
  ~GigeStudio();  // stops
  GigeStudio(const GigeStudio&) = delete;
  GigeStudio& operator=(const GigeStudio&) = delete;

  void start();  // answers and streams from now on; once
  void stop();   // returns when both threads have ended; again does nothing

  // All of these may be called from any thread at any time.
  std::size_t size() const;
  std::vector<GigeStats> stats() const;
  // Faults; all throw InvalidInput for a camera that is not there.
  void set_faults(std::size_t camera, const GigeFaults& faults);  // from now on, beside those that were added
  void set_faults(const GigeFaults& faults);                      // of all cameras
  // Throws InvalidInput also if the camera has FaultSchedule::kMaxFaults of them.
  void add_fault(std::size_t camera, const Fault& fault, capture::Timestamp from);
  void clear_faults(std::size_t camera);
  void seed_faults(std::uint64_t seed);
  void line0_edge(capture::Timestamp at);  // a pulse on the trigger line all cameras hang on
  std::uint16_t trigger_box_port() const;  // of the loopback; 0: there is none

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rotunda::simulator
