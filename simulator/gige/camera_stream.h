#pragma once
// The frames one camera sends: kept for resending, packed and paced. Used by the sender thread alone.
// Pixels are never copied here: the kernel gathers each packet from its header and the lent picture.
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <unordered_map>
#include <vector>

#include "simulator/gige/faults.h"
#include "simulator/gige/gvcp.h"
#include "simulator/gige/gvsp.h"
#include "simulator/gige/udp_socket.h"

namespace rotunda::simulator {

struct StreamCounts {
  std::uint64_t frames_sent = 0;
  std::uint64_t packets_sent = 0;  // resent ones included
  std::uint64_t packets_lost = 0;  // by a fault; never left
  std::uint64_t packets_resent = 0;
  std::uint64_t packets_unavailable = 0;  // asked for when the frame was no longer kept
  std::uint64_t send_errors = 0;          // refused by the network, e.g. larger than its MTU
  FaultCounts faults;
};

class CameraStream {
 public:
  static constexpr std::size_t kKeptFrames = 8;
  enum class Link { up, silent, rebooting };

  // `socket` is lent. `bits_per_second` is the camera's link; 0 sends each frame in one go.
  CameraStream(std::size_t camera, int socket, double bits_per_second);

  // Sends `frame` from `not_before` on, after the frames before it, with what is wrong with it (and what was, when it
  // is sent again). Its pixels must stay valid until kKeptFrames further frames were added.
  void add(GvspFrame frame, Endpoint destination, std::chrono::nanoseconds packet_delay, capture::Timestamp not_before,
           const GigeFaults& faults = {});
  // Lets go of what would be forgotten by the next add(): call before the pixels of that frame are made.
  void make_room();
  void resend(const ResendCommand& request, Link link = Link::up);
  void send_test_packet(Endpoint destination, std::size_t bytes);

  std::optional<capture::Timestamp> next_burst() const;
  // Sends the next burst if its time has come; true if it did. Nothing arrives while the link is silent.
  bool send_due(capture::Timestamp now, Link link = Link::up);

  const StreamCounts& counts() const { return counts_; }

 private:
  struct KeptFrame {
    GvspFrame frame;
    Endpoint destination;
    std::chrono::nanoseconds packet_delay{};
    capture::Timestamp not_before;
    GigeFaults faults;
    std::uint32_t sent = 0;  // packets that had their turn
    struct HeldBack {
      std::uint32_t packet, until;  // leaves once packet number `until` had its turn
    };
    std::deque<HeldBack> held_back;
    std::unordered_map<std::uint32_t, std::uint32_t> attempts;  // of packets sent again
  };
  class Batch;

  void change_length(KeptFrame& kept);
  void send_first(KeptFrame& kept, std::uint32_t end, Link link);
  void send_stray(Batch& batch, const KeptFrame& kept, Link link);
  void send_again(KeptFrame& kept, std::uint32_t first, std::uint32_t end, Link link);
  void send(Batch& batch, KeptFrame& kept, const PacketSending& sending, Link link);
  bool is_withheld(const KeptFrame& kept, const PacketSending& sending, Link link);
  bool hold_back(KeptFrame& kept, const PacketSending& sending);
  GvspPacket packet_of(const KeptFrame& kept, const PacketSending& sending);
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
