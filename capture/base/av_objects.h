#pragma once
// Move-only owners of FFmpeg's objects (libavformat, libavcodec, libswscale) and the one way its error numbers
// become exceptions. Declares FFmpeg's types only; include its headers where you call them, inside extern "C".
#include <filesystem>
#include <memory>
#include <string>

struct AVCodecContext;
struct AVFormatContext;
struct AVFrame;
struct AVPacket;
struct SwsContext;

namespace rotunda::capture {

struct AvInputClose {
  void operator()(AVFormatContext* input) const noexcept;
};
// Closes the file too unless its AVIOContext is the caller's (AVFMT_FLAG_CUSTOM_IO). Writes no trailer: what a
// destructor cannot report must be done before, with av_write_trailer.
struct AvOutputClose {
  void operator()(AVFormatContext* output) const noexcept;
};
struct AvCodecFree {
  void operator()(AVCodecContext* codec) const noexcept;
};
struct AvFrameFree {
  void operator()(AVFrame* frame) const noexcept;
};
struct AvPacketFree {
  void operator()(AVPacket* packet) const noexcept;
};
struct SwsFree {
  void operator()(SwsContext* scaler) const noexcept;
};

using AvInput = std::unique_ptr<AVFormatContext, AvInputClose>;
using AvOutput = std::unique_ptr<AVFormatContext, AvOutputClose>;
using AvCodec = std::unique_ptr<AVCodecContext, AvCodecFree>;
using AvFrame = std::unique_ptr<AVFrame, AvFrameFree>;
using AvPacket = std::unique_ptr<AVPacket, AvPacketFree>;
using AvScaler = std::unique_ptr<SwsContext, SwsFree>;

// From now on FFmpeg prints nothing to stderr but its last words: what it says there, exceptions say here, with the
// file's name. open_input, open_output and make_encoder/_decoder do this themselves.
void keep_av_quiet();

// Opens a media file and reads its header (not its streams: avformat_find_stream_info is the caller's choice).
// Throws std::system_error (cannot open) or CorruptData (not a media file), both with the file's name.
AvInput open_input(const std::filesystem::path& file);

// A muxer of the given short name ("matroska", "avi") writing to `file`, which is opened and emptied; no header yet.
// Throws std::system_error with the file's name.
AvOutput open_output(const std::filesystem::path& file, const char* muxer);

// Throw std::bad_alloc. The codec is named as FFmpeg names it ("ffv1"); throws std::system_error if this FFmpeg lacks
// it.
AvFrame make_frame();
AvPacket make_packet();
AvCodec make_encoder(const char* name);
AvCodec make_decoder(const char* name);

// Passes `result` through if it is not negative. AVERROR(errno) becomes std::system_error with that errno, anything
// else FFmpeg tells (invalid data, end of file) CorruptData. `what` says which step on which file: "take.mkv: header".
int check(int result, const std::string& what);

std::string av_error_text(int result);  // "Invalid data found when processing input"

}  // namespace rotunda::capture
