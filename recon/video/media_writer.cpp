#include <fmt/format.h>

#include <cstring>

#include "capture/base/av_objects.h"
#include "config/errors.h"
#include "recon/video/media_file.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libavutil/pixdesc.h>
}

namespace rotunda::recon {
namespace {

using capture::check;

struct StreamOutput {
  capture::AvCodec encoder;
  AVStream* stream = nullptr;  // owned by the muxer
  std::int64_t frames = 0;
};

AVPixelFormat pixel_format_of(const VideoStream& stream) {
  const AVPixelFormat format = av_get_pix_fmt(stream.pixel_format.c_str());
  if (format == AV_PIX_FMT_NONE) throw InvalidInput("unknown pixel format " + stream.pixel_format);
  return format;
}

AVDictionary* dictionary_of(const std::vector<std::pair<std::string, std::string>>& options) {
  AVDictionary* dictionary = nullptr;
  for (const auto& [key, value] : options) av_dict_set(&dictionary, key.c_str(), value.c_str(), 0);
  return dictionary;
}

capture::AvCodec open_encoder(const VideoStream& stream, AVRational rate, bool global_header, const std::string& file) {
  capture::AvCodec encoder = capture::make_encoder(stream.codec.c_str());
  encoder->width = stream.width;
  encoder->height = stream.height;
  encoder->pix_fmt = pixel_format_of(stream);
  encoder->time_base = av_inv_q(rate);
  encoder->framerate = rate;
  if (stream.pixel_format == "yuv420p" || stream.pixel_format == "yuv444p") {  // OpenCV's conversions are BT.601's ...
    encoder->colorspace = AVCOL_SPC_SMPTE170M;
    encoder->color_range =
        stream.pixel_format == "yuv420p" ? AVCOL_RANGE_MPEG : AVCOL_RANGE_JPEG;  // ... 16 to 235 here
  }
  if (global_header) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  AVDictionary* options = dictionary_of(stream.codec_options);
  const int opened = avcodec_open2(encoder.get(), nullptr, &options);
  av_dict_free(&options);
  check(opened, file + ": opening the " + stream.codec + " encoder");
  return encoder;
}

void attach(AVFormatContext* muxer, const Attachment& attachment) {
  AVStream* stream = avformat_new_stream(muxer, nullptr);
  auto* content = static_cast<std::uint8_t*>(av_mallocz(attachment.content.size() + AV_INPUT_BUFFER_PADDING_SIZE));
  if (!stream || !content) throw std::bad_alloc();
  std::memcpy(content, attachment.content.data(), attachment.content.size());
  stream->codecpar->codec_type = AVMEDIA_TYPE_ATTACHMENT;
  stream->codecpar->extradata = content;
  stream->codecpar->extradata_size = static_cast<int>(attachment.content.size());
  av_dict_set(&stream->metadata, "filename", attachment.name.c_str(), 0);
  av_dict_set(&stream->metadata, "mimetype", attachment.mime_type.c_str(), 0);
}

// The frame's planes take the cv::Mats' rows; the encoder may keep a reference, so the buffers are its own.
capture::AvFrame frame_of(const AVCodecContext& encoder, std::span<const cv::Mat> planes) {
  capture::AvFrame frame = capture::make_frame();
  frame->format = encoder.pix_fmt;
  frame->width = encoder.width;
  frame->height = encoder.height;
  check(av_frame_get_buffer(frame.get(), 0), "a picture's memory");
  if (static_cast<int>(planes.size()) != av_pix_fmt_count_planes(encoder.pix_fmt))
    throw InvalidInput("a picture has another number of planes than its stream");
  for (std::size_t p = 0; p < planes.size(); ++p) {
    const std::size_t row_bytes =
        static_cast<std::size_t>(av_image_get_linesize(encoder.pix_fmt, encoder.width, static_cast<int>(p)));
    const bool subsampled = (p == 1 || p == 2) && av_pix_fmt_desc_get(encoder.pix_fmt)->log2_chroma_h > 0;
    const int rows = subsampled ? (encoder.height + 1) / 2 : encoder.height;
    if (planes[p].rows != rows || static_cast<std::size_t>(planes[p].cols) * planes[p].elemSize() != row_bytes)
      throw InvalidInput("a picture has another size than its stream");
    for (int y = 0; y < rows; ++y)
      std::memcpy(frame->data[p] + static_cast<std::ptrdiff_t>(y) * frame->linesize[p], planes[p].ptr(y), row_bytes);
  }
  return frame;
}

}  // namespace

struct MediaWriter::Output {
  std::filesystem::path target, written;
  std::vector<StreamOutput> streams;
  capture::AvPacket packet = capture::make_packet();
  capture::AvOutput muxer;

  void drain(StreamOutput& out) {
    for (;;) {
      const int result = avcodec_receive_packet(out.encoder.get(), packet.get());
      if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
      check(result, written.string() + ": encoding");
      packet->stream_index = out.stream->index;
      if (packet->duration == 0) packet->duration = 1;
      av_packet_rescale_ts(packet.get(), out.encoder->time_base, out.stream->time_base);
      check(av_interleaved_write_frame(muxer.get(), packet.get()), written.string() + ": writing");
    }
  }
};

VideoStream lossless_stream(std::string title, std::string pixel_format, int side) {
  return {.title = std::move(title),
          .codec = "ffv1",
          .pixel_format = std::move(pixel_format),
          .width = side,
          .height = side,
          .codec_options = {{"level", "3"}, {"slices", "4"}, {"slicecrc", "1"}, {"g", "1"}}};
}

VideoStream quick_lossless_stream(std::string title, int side) {
  return {.title = std::move(title),
          .codec = "utvideo",
          .pixel_format = "gbrp",
          .width = side,
          .height = side,
          .codec_options = {{"pred", "median"}}};
}

VideoStream hevc_stream(std::string title, std::string pixel_format, int side, const std::string& quality) {
  return {.title = std::move(title),
          .codec = "libx265",
          .pixel_format = std::move(pixel_format),
          .width = side,
          .height = side,
          .codec_options = {
              {"preset", "medium"},
              {"x265-params", quality + ":bframes=0:keyint=25:min-keyint=25:scenecut=0:hash=1:log-level=error"}}};
}

MediaWriter::MediaWriter(const std::filesystem::path& file, const MediaFileOptions& options)
    : output_(std::make_unique<Output>()) {
  output_->target = file;
  output_->written = file.string() + ".part";
  const std::string name = output_->written.string();
  output_->muxer = capture::open_output(output_->written, options.container.c_str());
  AVFormatContext* muxer = output_->muxer.get();
  const AVRational rate = av_d2q(options.fps, 1'000'000);
  for (const VideoStream& wanted : options.streams) {
    AVStream* stream = avformat_new_stream(muxer, nullptr);
    if (!stream) throw std::bad_alloc();
    auto encoder = open_encoder(wanted, rate, (muxer->oformat->flags & AVFMT_GLOBALHEADER) != 0, name);
    check(avcodec_parameters_from_context(stream->codecpar, encoder.get()), name + ": stream parameters");
    stream->time_base = encoder->time_base;
    stream->avg_frame_rate = rate;
    av_dict_set(&stream->metadata, "title", wanted.title.c_str(), 0);
    output_->streams.push_back({std::move(encoder), stream});
  }
  for (const Attachment& attachment : options.attachments) attach(muxer, attachment);
  AVDictionary* container_options = dictionary_of(options.container_options);
  const int begun = avformat_write_header(muxer, &container_options);
  av_dict_free(&container_options);
  check(begun, name + ": header");
}

MediaWriter::~MediaWriter() {
  if (!output_->muxer) return;
  output_->muxer.reset();
  std::error_code ignored;  // a destructor cannot report; the name tells what the file is
  std::filesystem::remove(output_->written, ignored);
}

void MediaWriter::write(std::size_t stream, std::span<const cv::Mat> planes) {
  StreamOutput& out = output_->streams.at(stream);
  const capture::AvFrame frame = frame_of(*out.encoder, planes);
  frame->pts = out.frames++;
  check(avcodec_send_frame(out.encoder.get(), frame.get()), output_->written.string() + ": encoding");
  output_->drain(out);
}

void MediaWriter::finish() {
  for (StreamOutput& out : output_->streams) {
    check(avcodec_send_frame(out.encoder.get(), nullptr), output_->written.string() + ": encoding");
    output_->drain(out);
  }
  check(av_write_trailer(output_->muxer.get()), output_->written.string() + ": trailer");
  avio_flush(output_->muxer->pb);
  check(output_->muxer->pb->error, output_->written.string() + ": writing");
  output_->muxer.reset();
  std::filesystem::rename(output_->written, output_->target);
}

}  // namespace rotunda::recon
