#pragma once
// The frames one camera sends: kept for resending, packed and paced. Used by the sender thread alone.
// Pixels are never copied here: the kernel gathers each packet from its header and the lent picture.
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "simulator/gige/faults.h"
#include "simulator/gige/gvcp.h"
#include "simulator/gige/gvsp.h"
#include "simulator/gige/udp_socket.h"

namespace rotunda::simulator {

struct StreamCounts {
  std::uint64_t frames_sent = 0;
  std::uint64_t packets_sent = 0;  // resent ones included
  std::uint64_t packets_lost = 0;  // by the fault; never left
  std::uint64_t packets_resent = 0;
  std::uint64_t packets_unavailable = 0;  // asked for when the frame was no longer kept
  std::uint64_t send_errors = 0;          // refused by the network, e.g. larger than its MTU
};

class CameraStream {
 public:
  static constexpr std::size_t kKeptFrames = 8;

  // `socket` is lent. `bits_per_second` is the camera's link; 0 sends each frame in one go.
  CameraStream(std::size_t camera, int socket, double bits_per_second);

  // Sends `frame` from `not_before` on, after the frames before it. Its pixels must stay valid until kKeptFrames
  // further frames were added.
  void add(const GvspFrame& frame, Endpoint destination, std::chrono::nanoseconds packet_delay,
           capture::Timestamp not_before);
  // Lets go of what would be forgotten by the next add(): call before the pixels of that frame are made.
  void make_room();
  void resend(const ResendCommand& request, const GigeFaults& faults);
  void send_test_packet(Endpoint destination, std::size_t bytes);

  std::optional<capture::Timestamp> next_burst() const;
  // Sends the next burst if its time has come; true if it did.
  bool send_due(capture::Timestamp now, const GigeFaults& faults);

  const StreamCounts& counts() const { return counts_; }

 private:
  struct KeptFrame {
    GvspFrame frame;
    Endpoint destination;
    std::chrono::nanoseconds packet_delay{};
    capture::Timestamp not_before;
    std::uint32_t sent = 0;    // packets that had their turn
    std::uint64_t resent = 0;  // numbers the attempts, so that each is lost or not by itself
  };
  enum class Attempt { first, again };

  void send_packets(KeptFrame& kept, std::uint32_t first, std::uint32_t end, Attempt attempt, const GigeFaults& faults);
  std::uint32_t burst_packets(const KeptFrame& kept) const;
  std::chrono::nanoseconds duration(const KeptFrame& kept, std::uint32_t packets) const;
  KeptFrame* unsent();

  std::size_t camera_;
  int socket_;
  double bits_per_second_;
  std::deque<KeptFrame> kept_;  // oldest first
  capture::Timestamp next_send_;
  StreamCounts counts_;
};

}  // namespace rotunda::simulator
