#include "simulator/gige/camera_stream.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <vector>

namespace rotunda::simulator {
namespace {

constexpr std::uint32_t kBurstBytes = 64 * 1024;  // what leaves between two looks at the clock
constexpr std::uint32_t kBatch = 64;              // packets a system call

// One sendmmsg() in the making: heads are kept here, pixels stay where they are.
class Batch {
 public:
  explicit Batch(Endpoint destination) {
    to_.sin_family = AF_INET;
    to_.sin_port = htons(destination.port);
    to_.sin_addr.s_addr = htonl(destination.address);
  }

  bool is_full() const { return size_ == kBatch; }

  void add(const GvspPacket& packet) {
    packets_[size_] = packet;
    auto& kept = packets_[size_];
    pieces_[size_] = {iovec{kept.head.data(), kept.head_bytes},
                      iovec{const_cast<std::uint8_t*>(packet.pixels.data()), packet.pixels.size()}};
    messages_[size_] = {};
    auto& header = messages_[size_].msg_hdr;
    header.msg_name = &to_;
    header.msg_namelen = sizeof to_;
    header.msg_iov = pieces_[size_].data();
    header.msg_iovlen = packet.pixels.empty() ? 1 : 2;
    ++size_;
  }

  // A packet the network refuses is skipped, as a switch would drop it.
  void send(int socket, StreamCounts& counts) {
    for (std::uint32_t done = 0; done < size_;) {
      const int sent = sendmmsg(socket, messages_.data() + done, size_ - done, 0);
      if (sent < 0 && errno == EINTR) continue;
      counts.packets_sent += sent > 0 ? static_cast<std::uint64_t>(sent) : 0;
      counts.send_errors += sent > 0 ? 0 : 1;
      done += sent > 0 ? static_cast<std::uint32_t>(sent) : 1;
    }
    size_ = 0;
  }

 private:
  sockaddr_in to_{};
  std::uint32_t size_ = 0;
  std::array<GvspPacket, kBatch> packets_;
  std::array<std::array<iovec, 2>, kBatch> pieces_;
  std::array<mmsghdr, kBatch> messages_;
};

}  // namespace

CameraStream::CameraStream(std::size_t camera, int socket, double bits_per_second)
    : camera_(camera), socket_(socket), bits_per_second_(bits_per_second) {}

void CameraStream::make_room() {
  while (kept_.size() >= kKeptFrames) kept_.pop_front();
}

void CameraStream::add(const GvspFrame& frame, Endpoint destination, std::chrono::nanoseconds packet_delay,
                       capture::Timestamp not_before) {
  make_room();
  kept_.push_back({frame, destination, packet_delay, not_before});
}

CameraStream::KeptFrame* CameraStream::unsent() {
  const auto next = std::find_if(kept_.begin(), kept_.end(),
                                 [](const KeptFrame& kept) { return kept.sent < packet_count(kept.frame); });
  return next == kept_.end() ? nullptr : &*next;
}

std::optional<capture::Timestamp> CameraStream::next_burst() const {
  const auto* kept = const_cast<CameraStream*>(this)->unsent();
  if (kept == nullptr) return std::nullopt;
  return std::max(kept->not_before, next_send_);
}

std::uint32_t CameraStream::burst_packets(const KeptFrame& kept) const {
  const std::uint32_t left = packet_count(kept.frame) - kept.sent;
  if (bits_per_second_ <= 0.0 && kept.packet_delay.count() == 0) return left;
  return std::min(left, std::max(1U, kBurstBytes / kept.frame.packet_size));
}

std::chrono::nanoseconds CameraStream::duration(const KeptFrame& kept, std::uint32_t packets) const {
  const double bits = 8.0 * packets * kept.frame.packet_size;
  const double on_the_link = bits_per_second_ > 0.0 ? 1e9 * bits / bits_per_second_ : 0.0;
  return std::chrono::nanoseconds{static_cast<std::int64_t>(on_the_link)} + packets * kept.packet_delay;
}

bool CameraStream::send_due(capture::Timestamp now, const GigeFaults& faults) {
  const auto when = next_burst();
  if (!when || *when > now) return false;
  KeptFrame& kept = *unsent();
  const std::uint32_t packets = burst_packets(kept);
  send_packets(kept, kept.sent, kept.sent + packets, Attempt::first, faults);
  kept.sent += packets;
  next_send_ = *when + duration(kept, packets);
  if (kept.sent == packet_count(kept.frame) && !faults.silent) ++counts_.frames_sent;
  return true;
}

void CameraStream::send_packets(KeptFrame& kept, std::uint32_t first, std::uint32_t end, Attempt attempt,
                                const GigeFaults& faults) {
  Batch batch(kept.destination);
  const bool again = attempt == Attempt::again;
  for (std::uint32_t packet = first; packet < end; ++packet) {
    const std::uint64_t try_number = again ? ++kept.resent : 0;
    if (faults.silent || is_lost(faults, camera_, kept.frame.block, packet, try_number)) {
      ++counts_.packets_lost;
      continue;
    }
    batch.add(gvsp_packet(kept.frame, packet, again ? GvspStatus::resent : GvspStatus::ok));
    if (again) ++counts_.packets_resent;
    if (batch.is_full()) batch.send(socket_, counts_);
  }
  batch.send(socket_, counts_);
}

void CameraStream::resend(const ResendCommand& request, const GigeFaults& faults) {
  const auto kept = std::find_if(kept_.rbegin(), kept_.rend(),
                                 [&](const KeptFrame& each) { return each.frame.block == request.block; });
  if (kept != kept_.rend()) {
    // What had no turn yet comes anyhow.
    const std::uint32_t end = std::min(kept->sent, request.last == 0xFFFFFF ? kept->sent : request.last + 1);
    if (request.first < end) send_packets(*kept, request.first, end, Attempt::again, faults);
    return;
  }
  ++counts_.packets_unavailable;
  if (kept_.empty() || faults.silent) return;
  Batch batch(kept_.back().destination);
  batch.add(gvsp_unavailable(request.block, request.first));
  batch.send(socket_, counts_);
}

void CameraStream::send_test_packet(Endpoint destination, std::size_t bytes) {
  const std::vector<std::uint8_t> filler(bytes);
  const GvspPacket packet{.head = {}, .head_bytes = 0, .pixels = filler};
  Batch batch(destination);
  batch.add(packet);
  batch.send(socket_, counts_);
}

}  // namespace rotunda::simulator
