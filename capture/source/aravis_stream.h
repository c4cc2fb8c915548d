#pragma once
// A stream of Aravis: how it is set up for a rig's camera, and what its counters tell.
#include <cstdint>
#include <optional>
#include <string>

#include "capture/source/aravis_handle.h"
#include "capture/source/buffer_pool.h"
#include "capture/source/source.h"

namespace rotunda::capture {

// Resend of lost packets is on where the camera can. A frame still short of packets is given up before the next one is
// due (by `frame_rate_hz`), or it would hold up those behind it.
void tune_stream(ArvStream* stream, std::optional<double> frame_rate_hz);

// `done` out of the stream's output, where it may not come first: a packet of no known kind has Aravis 0.8.26 put a
// buffer there that nothing was written to, without a word. Left there, it would make each later frame come one behind.
// Those go back to `pool`. Nothing if it is not there.
ArvBuffer* pop_done(ArvStream* stream, const ArvBuffer* done, BufferPool& pool);

// Aravis' packet socket hears all that its link carries until it has a filter; what it takes in by then may be taken
// for frames of this camera, and their block ids for its last. Whether a stream that has no buffers yet, nor a camera
// that sends, has its filter and has heard nothing. True for a stream without a packet socket.
bool began_clean(ArvStream* stream, bool packet_socket);

void read_counters(ArvStream* stream, SourceStats& stats);

// Aravis 0.8.26 takes packets for late ones whose block id is up to 99 below the last: one leader with an id a little
// ahead, or a camera that counts from 1 again, and it ignores whole frames until they catch up. Late packets of resends
// are ignored too, but never frames' worth without a frame; those that find no buffer count as both.
class StreamDeafness {
 public:
  // `finished`: frames so far, whole or not. True if several frames' worth of packets came since the last of them, and
  // none of these came out.
  bool look(ArvStream* stream, std::uint64_t finished, std::size_t packets_a_frame);

 private:
  std::uint64_t finished_seen_ = 0, ignored_seen_ = 0;
};

// For the operator. `share` and `budget`: of the packets, 0 to 1.
std::string resends_told(double share, bool within_budget, double budget);

}  // namespace rotunda::capture
