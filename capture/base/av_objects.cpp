#include "capture/base/av_objects.h"

#include <array>
#include <new>
#include <system_error>

#include "config/errors.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

namespace rotunda::capture {
namespace {

// FFmpeg's own errors are four-letter tags, far below the range of negated errno values.
constexpr int kLargestErrno = 4095;

template <class Owner>
Owner owned(typename Owner::pointer object) {
  if (object == nullptr) throw std::bad_alloc();
  return Owner(object);
}

AvCodec make_codec(const AVCodec* codec, const char* name, const char* kind) {
  if (codec == nullptr)
    throw std::system_error(std::make_error_code(std::errc::not_supported),
                            std::string("this FFmpeg has no ") + name + ' ' + kind);
  return owned<AvCodec>(avcodec_alloc_context3(codec));
}

}  // namespace

void AvInputClose::operator()(AVFormatContext* input) const noexcept {
  avformat_close_input(&input);
}

void AvOutputClose::operator()(AVFormatContext* output) const noexcept {
  const bool file_is_ours = (output->flags & AVFMT_FLAG_CUSTOM_IO) == 0 && (output->oformat->flags & AVFMT_NOFILE) == 0;
  if (file_is_ours) avio_closep(&output->pb);
  avformat_free_context(output);
}

void AvCodecFree::operator()(AVCodecContext* codec) const noexcept {
  avcodec_free_context(&codec);
}
void AvFrameFree::operator()(AVFrame* frame) const noexcept {
  av_frame_free(&frame);
}
void AvPacketFree::operator()(AVPacket* packet) const noexcept {
  av_packet_free(&packet);
}
void SwsFree::operator()(SwsContext* scaler) const noexcept {
  sws_freeContext(scaler);
}

void keep_av_quiet() {
  av_log_set_level(AV_LOG_FATAL);
}

AvInput open_input(const std::filesystem::path& file) {
  keep_av_quiet();
  AVFormatContext* input = nullptr;
  // "file:" keeps a colon in the name from being taken for a protocol.
  check(avformat_open_input(&input, ("file:" + file.string()).c_str(), nullptr, nullptr), file.string());
  return AvInput(input);
}

AvOutput open_output(const std::filesystem::path& file, const char* muxer) {
  keep_av_quiet();
  AVFormatContext* context = nullptr;
  const std::string url = "file:" + file.string();
  check(avformat_alloc_output_context2(&context, nullptr, muxer, url.c_str()), file.string());
  AvOutput output(context);
  check(avio_open(&output->pb, url.c_str(), AVIO_FLAG_WRITE), "cannot write " + file.string());
  return output;
}

AvFrame make_frame() {
  return owned<AvFrame>(av_frame_alloc());
}
AvPacket make_packet() {
  return owned<AvPacket>(av_packet_alloc());
}

AvCodec make_encoder(const char* name) {
  keep_av_quiet();
  return make_codec(avcodec_find_encoder_by_name(name), name, "encoder");
}

AvCodec make_decoder(const char* name) {
  keep_av_quiet();
  return make_codec(avcodec_find_decoder_by_name(name), name, "decoder");
}

int check(int result, const std::string& what) {
  if (result >= 0) return result;
  if (-result <= kLargestErrno) throw std::system_error(AVUNERROR(result), std::generic_category(), what);
  throw CorruptData(what + ": " + av_error_text(result));
}

std::string av_error_text(int result) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(result, text.data(), text.size());
  return text.data();
}

}  // namespace rotunda::capture
