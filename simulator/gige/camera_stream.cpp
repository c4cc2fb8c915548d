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
constexpr std::uint64_t kBlocksAhead = 64;  // of a wrong leader: Aravis takes ids up to 99 below the last for late

}  // namespace

// One sendmmsg() in the making: heads are kept here, pixels stay where they are. Leaves when full and at its end.
class CameraStream::Batch {
 public:
  Batch(int socket, Endpoint destination, StreamCounts& counts) : socket_(socket), counts_(counts) {
    to_.sin_family = AF_INET;
    to_.sin_port = htons(destination.port);
    to_.sin_addr.s_addr = htonl(destination.address);
  }
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;
  ~Batch() { send(); }

  void add(const GvspPacket& packet) {
    packets_[size_] = packet;
    auto& kept = packets_[size_];
    auto& pieces = pieces_[size_];
    std::size_t count = 0;
    pieces[count++] = {kept.head.data(), kept.head_bytes};
    for (const auto part : {packet.pixels, packet.chunks})
      if (!part.empty()) pieces[count++] = {const_cast<std::uint8_t*>(part.data()), part.size()};
    messages_[size_] = {};
    auto& header = messages_[size_].msg_hdr;
    header.msg_name = &to_;
    header.msg_namelen = sizeof to_;
    header.msg_iov = pieces_[size_].data();
    header.msg_iovlen = count;
    if (++size_ == kBatch) send();
  }

 private:
  // A packet the network refuses is skipped, as a switch would drop it.
  void send() {
    for (std::uint32_t done = 0; done < size_;) {
      const int sent = sendmmsg(socket_, messages_.data() + done, size_ - done, 0);
      if (sent < 0 && errno == EINTR) continue;
      counts_.packets_sent += sent > 0 ? static_cast<std::uint64_t>(sent) : 0;
      counts_.send_errors += sent > 0 ? 0 : 1;
      done += sent > 0 ? static_cast<std::uint32_t>(sent) : 1;
    }
    size_ = 0;
  }

  int socket_;
  StreamCounts& counts_;
  sockaddr_in to_{};
  std::uint32_t size_ = 0;
  std::array<GvspPacket, kBatch> packets_;
  std::array<std::array<iovec, 3>, kBatch> pieces_;
  std::array<mmsghdr, kBatch> messages_;
};

CameraStream::CameraStream(std::size_t camera, int socket, double bits_per_second)
    : camera_(camera), socket_(socket), bits_per_second_(bits_per_second) {}

void CameraStream::make_room() {
  while (kept_.size() >= kKeptFrames) kept_.pop_front();
}

void CameraStream::add(GvspFrame frame, Endpoint destination, std::chrono::nanoseconds packet_delay,
                       capture::Timestamp not_before, const GigeFaults& faults) {
  make_room();
  counts_.faults[FaultKind::late_frames] += faults.late_frames.by.count() != 0;
  kept_.push_back({.frame = std::move(frame),
                   .destination = destination,
                   .packet_delay = packet_delay,
                   .not_before = not_before + faults.late_frames.by,
                   .faults = faults,
                   .sent = 0,
                   .held_back = {},
                   .attempts = {}});
  if (faults.wrong_payload_size.sent_change != 0) change_length(kept_.back());
}

void CameraStream::change_length(KeptFrame& kept) {
  auto& pixels = kept.frame.pixels;
  const auto size = static_cast<std::int64_t>(pixels.size()) + kept.faults.wrong_payload_size.sent_change;
  ++counts_.faults[FaultKind::wrong_payload_size];
  if (size <= static_cast<std::int64_t>(pixels.size())) {
    pixels = pixels.first(static_cast<std::size_t>(std::max<std::int64_t>(0, size)));
    return;
  }
  std::vector<std::uint8_t> longer(pixels.begin(), pixels.end());
  longer.resize(static_cast<std::size_t>(size));
  kept.frame.own_pixels = std::move(longer);
  pixels = kept.frame.own_pixels;
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

bool CameraStream::send_due(capture::Timestamp now, Link link) {
  const auto when = next_burst();
  if (!when || *when > now) return false;
  KeptFrame& kept = *unsent();
  const std::uint32_t packets = burst_packets(kept);
  send_first(kept, kept.sent + packets, link);
  next_send_ = *when + duration(kept, packets);
  if (kept.sent == packet_count(kept.frame) && link == Link::up) ++counts_.frames_sent;
  return true;
}

void CameraStream::send_first(KeptFrame& kept, std::uint32_t end, Link link) {
  Batch batch(socket_, kept.destination, counts_);
  const auto release = [&](bool all) {
    while (!kept.held_back.empty() && (all || kept.held_back.front().until < kept.sent)) {
      send(batch, kept, {camera_, kept.frame.block, kept.held_back.front().packet, 0}, link);
      kept.held_back.pop_front();
    }
  };
  if (kept.sent == 0) send_stray(batch, kept, link);
  while (kept.sent < end) {
    const PacketSending sending{camera_, kept.frame.block, kept.sent++, 0};
    if (!hold_back(kept, sending)) send(batch, kept, sending, link);
    release(false);
  }
  release(kept.sent == packet_count(kept.frame));
}

void CameraStream::send_stray(Batch& batch, const KeptFrame& kept, Link link) {
  const PacketSending before_all{camera_, kept.frame.block, 0, 0};
  if (link != Link::up ||
      !strikes(kept.faults.stray_packet.rate, kept.faults.seed, FaultKind::stray_packet, before_all))
    return;
  batch.add(gvsp_stray(kept.frame));
  ++counts_.faults[FaultKind::stray_packet];
}

void CameraStream::send_again(KeptFrame& kept, std::uint32_t first, std::uint32_t end, Link link) {
  Batch batch(socket_, kept.destination, counts_);
  for (std::uint32_t packet = first; packet < end; ++packet)
    send(batch, kept, {camera_, kept.frame.block, packet, ++kept.attempts[packet]}, link);
}

void CameraStream::send(Batch& batch, KeptFrame& kept, const PacketSending& sending, Link link) {
  if (is_withheld(kept, sending, link)) return;
  const GvspPacket packet = packet_of(kept, sending);
  batch.add(packet);
  counts_.packets_resent += sending.attempt > 0;
  if (!strikes(kept.faults.duplicate.rate, kept.faults.seed, FaultKind::duplicate, sending)) return;
  batch.add(packet);
  ++counts_.faults[FaultKind::duplicate];
}

// Counts what it keeps from leaving.
bool CameraStream::is_withheld(const KeptFrame& kept, const PacketSending& sending, Link link) {
  const auto& wrong = kept.faults;
  const auto struck = [&](double rate, FaultKind kind) { return strikes(rate, wrong.seed, kind, sending); };
  if (struck(wrong.network_error.rate, FaultKind::network_error)) {
    ++counts_.send_errors;
    ++counts_.faults[FaultKind::network_error];
    return true;
  }
  const bool is_trailer = sending.packet + 1 == packet_count(kept.frame);
  const bool lost = is_lost(wrong, sending);
  const bool no_trailer = is_trailer && struck(wrong.missing_trailer.rate, FaultKind::missing_trailer);
  counts_.faults[FaultKind::silence] += link == Link::silent;
  if (link == Link::up) {
    counts_.faults[FaultKind::packet_loss] += lost;
    counts_.faults[FaultKind::missing_trailer] += no_trailer && !lost;
  }
  if (link == Link::up && !lost && !no_trailer) return false;
  ++counts_.packets_lost;
  return true;
}

bool CameraStream::hold_back(KeptFrame& kept, const PacketSending& sending) {
  const auto& reorder = kept.faults.reorder;
  if (!strikes(reorder.rate, kept.faults.seed, FaultKind::reorder, sending)) return false;
  kept.held_back.push_back({sending.packet, sending.packet + reorder.by});
  ++counts_.faults[FaultKind::reorder];
  return true;
}

GvspPacket CameraStream::packet_of(const KeptFrame& kept, const PacketSending& sending) {
  constexpr std::size_t kLeaderBytes = 36;  // after its packet header
  const auto status = sending.attempt > 0 ? GvspStatus::resent : GvspStatus::ok;
  const auto& [flaw, rate] = kept.faults.corrupted_leader;
  if (sending.packet != 0 || !strikes(rate, kept.faults.seed, FaultKind::corrupted_leader, sending))
    return gvsp_packet(kept.frame, sending.packet, status);
  ++counts_.faults[FaultKind::corrupted_leader];
  GvspFrame wrong = kept.frame;
  if (flaw == LeaderFlaw::width) wrong.width *= 2;
  if (flaw == LeaderFlaw::height) wrong.height *= 2;
  if (flaw == LeaderFlaw::pixel_format) wrong.pixel_code = 0x0108FFFF;  // 8 bits a pixel, of no known kind
  if (flaw == LeaderFlaw::block_id) wrong.block = (wrong.block + kBlocksAhead - 1) % 65535 + 1;
  GvspPacket leader = gvsp_packet(wrong, 0, status);
  if (flaw == LeaderFlaw::random)
    randomise_leader(std::span{leader.head}.first(leader.head_bytes).last(kLeaderBytes), kept.faults.seed, sending);
  return leader;
}

void CameraStream::resend(const ResendCommand& request, Link link) {
  const auto kept = std::find_if(kept_.rbegin(), kept_.rend(),
                                 [&](const KeptFrame& each) { return each.frame.block == request.block; });
  if (kept != kept_.rend()) {
    // What had no turn yet comes anyhow.
    const std::uint32_t end = std::min(kept->sent, request.to_the_end() ? kept->sent : request.last + 1);
    if (request.first < end) send_again(*kept, request.first, end, link);
    return;
  }
  ++counts_.packets_unavailable;
  if (kept_.empty() || link != Link::up) return;
  Batch(socket_, kept_.back().destination, counts_).add(gvsp_unavailable(request));
}

void CameraStream::send_test_packet(Endpoint destination, std::size_t bytes) {
  const std::vector<std::uint8_t> filler(bytes);
  Batch(socket_, destination, counts_).add({.head = {}, .head_bytes = 0, .pixels = filler});
}

}  // namespace rotunda::simulator
