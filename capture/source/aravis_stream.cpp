#include "capture/source/aravis_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "capture/source/stream_socket.h"

namespace rotunda::capture {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t ignored_frames = 3;  // in packets, with no frame coming out: something is wrong
constexpr double requests_a_packet = 1.0;  // of a frame, at most: bursts may take half of it

std::uint64_t told(ArvStream* stream, const char* name) {
  return arv_stream_get_info_uint64_by_name(stream, name);
}

}  // namespace

void tune_stream(ArvStream* stream, std::optional<double> frame_rate_hz) {
  arv_stream_set_emit_signals(stream, FALSE);
  if (!ARV_IS_GV_STREAM(stream)) return;
  // Size 0: Aravis shall not touch the socket's buffer; the source sets it.
  g_object_set(stream, "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size", 0, nullptr);
  g_object_set(stream, "packet-request-ratio", requests_a_packet, nullptr);
  if (!frame_rate_hz) return;
  const double period_us = 1e6 / *frame_rate_hz;
  const auto retention_us = static_cast<guint>(std::min(0.875 * period_us, 1e6));
  const auto retry_us = static_cast<guint>(std::clamp(0.125 * period_us, 1e3, 20e3));
  g_object_set(stream, "frame-retention", retention_us, "packet-timeout", retry_us, nullptr);
}

ArvBuffer* pop_done(ArvStream* stream, const ArvBuffer* done, BufferPool& pool) {
  ArvBuffer* buffer = arv_stream_try_pop_buffer(stream);
  for (; buffer && buffer != done; buffer = arv_stream_try_pop_buffer(stream)) pool.give_back(buffer);
  return buffer;
}

bool began_clean(ArvStream* stream, bool packet_socket) {
  if (!packet_socket || !ARV_IS_GV_STREAM(stream)) return true;
  constexpr auto kPatience = 500ms, kLook = 1ms;
  constexpr auto kUntilRead = 10ms;  // what came before the filter waits in the ring for half as long
  const auto port = arv_gv_stream_get_port(ARV_GV_STREAM(stream));
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!packet_socket_listens_for(port)) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(kLook);
  }
  std::this_thread::sleep_for(kUntilRead);
  return told(stream, "n_received_packets") == 0;
}

void read_counters(ArvStream* stream, SourceStats& stats) {
  stats.underruns = told(stream, "n_underruns");
  if (!ARV_IS_GV_STREAM(stream)) return;
  stats.resend_requests = told(stream, "n_resend_requests");
  stats.missing_packets = told(stream, "n_missing_packets");
}

bool StreamDeafness::look(ArvStream* stream, std::uint64_t finished, std::size_t packets_a_frame) {
  if (!ARV_IS_GV_STREAM(stream)) return false;
  const std::uint64_t underruns = told(stream, "n_underruns");
  const std::uint64_t ignored = told(stream, "n_ignored_packets") - underruns;
  if (finished != finished_seen_) ignored_seen_ = ignored;
  finished_seen_ = finished;
  return ignored - ignored_seen_ >= ignored_frames * packets_a_frame;
}

std::string resends_told(double share, bool within_budget, double budget) {
  std::string text = fmt::format("{:.1f} % of its packets were lost on the way and asked for again", 100 * share);
  if (!within_budget)
    text += fmt::format(", more than its budget of {:g} % (resend_budget_percent): that is paused, and frames are lost",
                        100 * budget);
  return text + "; see to cable, switch, MTU and what else its link carries";
}

}  // namespace rotunda::capture
