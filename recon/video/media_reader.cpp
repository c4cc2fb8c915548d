#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <system_error>

#include "capture/base/av_objects.h"
#include "config/errors.h"
#include "recon/video/media_file.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/crc.h>
#include <libavutil/imgutils.h>
#include <libavutil/intreadwrite.h>
#include <libavutil/pixdesc.h>
}

namespace rotunda::recon {
namespace {

// FFV1 level 3 ends every slice with its size (3 bytes), a status byte and the CRC of the whole slice, so that the
// CRC over all of it is 0. FFmpeg hides a damaged slice behind the frame before; a master must not.
bool slices_are_whole(const AVPacket& packet) {
  constexpr int kTrailer = 8;
  const AVCRC* table = av_crc_get_table(AV_CRC_32_IEEE);
  int end = packet.size;
  while (end > kTrailer) {
    const int size = static_cast<int>(AV_RB24(packet.data + end - kTrailer)) + kTrailer;
    if (size > end || av_crc(table, 0, packet.data + end - size, static_cast<std::size_t>(size)) != 0) return false;
    end -= size;
  }
  return end == 0;
}

std::vector<cv::Mat> planes_of(const AVFrame& frame) {
  const auto format = static_cast<AVPixelFormat>(frame.format);
  const int planes = av_pix_fmt_count_planes(format);
  const int depth = av_pix_fmt_desc_get(format)->comp[0].depth > 8 ? CV_16U : CV_8U;
  const int channels = planes > 1 ? 1 : av_pix_fmt_desc_get(format)->comp[0].step / (depth == CV_16U ? 2 : 1);
  std::vector<cv::Mat> copies;
  for (int p = 0; p < planes; ++p) {
    cv::Mat plane(frame.height, frame.width, CV_MAKETYPE(depth, channels));
    const std::size_t row_bytes = static_cast<std::size_t>(plane.cols) * plane.elemSize();
    for (int y = 0; y < plane.rows; ++y)
      std::memcpy(plane.ptr(y), frame.data[p] + static_cast<std::ptrdiff_t>(y) * frame.linesize[p], row_bytes);
    copies.push_back(std::move(plane));
  }
  return copies;
}

// What an encoder makes: "libx265" makes "hevc".
std::string codec_name(const std::string& encoder) {
  const AVCodec* codec = avcodec_find_encoder_by_name(encoder.c_str());
  return codec ? avcodec_get_name(codec->id) : encoder;
}

bool stands_alone(const VideoStream& stream) {
  return stream.codec == "ffv1" || stream.codec == "utvideo" || stream.codec == "rawvideo";
}

capture::AvCodec open_decoder(const AVStream& stream, const std::string& file) {
  capture::AvCodec decoder = capture::make_decoder(avcodec_get_name(stream.codecpar->codec_id));
  capture::check(avcodec_parameters_to_context(decoder.get(), stream.codecpar), file + ": stream parameters");
  decoder->pkt_timebase = stream.time_base;
  decoder->thread_count = 1;                // frames come out as soon as they went in
  constexpr std::int64_t kAlignment = 128;  // the decoder pads its pictures
  decoder->max_pixels = (stream.codecpar->width + kAlignment) * (stream.codecpar->height + kAlignment);
  decoder->err_recognition = AV_EF_EXPLODE;  // FFV1's checksums are checked before
  if (stream.codecpar->codec_id != AV_CODEC_ID_FFV1) decoder->err_recognition |= AV_EF_CRCCHECK;
  capture::check(avcodec_open2(decoder.get(), nullptr, nullptr), file + ": opening the decoder");
  return decoder;
}

struct StreamInput {
  capture::AvCodec decoder;
  AVStream* stream = nullptr;  // owned by the demuxer
  VideoStream expected;
};

}  // namespace

struct MediaReader::Input {
  std::filesystem::path file;
  capture::AvInput demuxer;
  std::vector<StreamInput> streams;
  double fps = 25.0;
  std::int64_t next = 0;                     // the frame a sequential read finds without a seek
  std::size_t without = MediaReader::kNone;  // the stream that was left out so far
  capture::AvPacket packet = capture::make_packet();
  capture::AvFrame frame = capture::make_frame();

  [[noreturn]] void corrupt(const std::string& what) const {
    const std::int64_t offset = packet->pos >= 0 ? packet->pos : avio_tell(demuxer->pb);
    throw CorruptData(file, static_cast<std::uint64_t>(std::max<std::int64_t>(offset, 0)), what);
  }

  std::int64_t frame_index(const StreamInput& in) const {
    const std::int64_t time = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
    if (time == AV_NOPTS_VALUE) corrupt("a frame has no time");
    return std::llround(static_cast<double>(time) * av_q2d(in.stream->time_base) * fps);
  }

  void seek(std::int64_t index) {
    const AVStream& first = *streams.front().stream;
    const auto time = static_cast<std::int64_t>(std::floor(static_cast<double>(index) / fps / av_q2d(first.time_base)));
    if (av_seek_frame(demuxer.get(), first.index, time, AVSEEK_FLAG_BACKWARD) < 0)
      corrupt(fmt::format("frame {} cannot be found; the file is cut short", index));
    for (StreamInput& in : streams) avcodec_flush_buffers(in.decoder.get());
  }

  // The next packet of one of our streams; false at the end of the file.
  StreamInput* next_packet() {
    for (;;) {
      av_packet_unref(packet.get());
      const int result = av_read_frame(demuxer.get(), packet.get());
      if (result == AVERROR_EOF) return nullptr;
      if (result < 0) corrupt("the file breaks off: " + capture::av_error_text(result));
      for (StreamInput& in : streams)
        if (in.stream->index == packet->stream_index) return &in;
    }
  }

  std::vector<cv::Mat> decode(StreamInput& in, std::int64_t index) {
    const std::string where = fmt::format("frame {}, stream {}", index, in.expected.title);
    if (in.expected.codec == "ffv1" && !slices_are_whole(*packet)) corrupt(where + " is damaged (checksum)");
    int result = avcodec_send_packet(in.decoder.get(), packet.get());
    if (result >= 0) result = avcodec_receive_frame(in.decoder.get(), frame.get());
    if (result < 0) corrupt(where + " does not decode: " + capture::av_error_text(result));
    if (frame->width != in.expected.width || frame->height != in.expected.height ||
        frame->format != av_get_pix_fmt(in.expected.pixel_format.c_str()))
      corrupt(where + " has another size or pixel format than the header says");
    return planes_of(*frame);
  }
};

MediaReader::MediaReader(const std::filesystem::path& file) : input_(std::make_unique<Input>()) {
  input_->file = file;
  try {
    input_->demuxer = capture::open_input(file);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::io_error) throw;  // what FFmpeg says when a file ends within its header
    throw CorruptData(file, 0, "the file is cut short within its header");
  }
}

MediaReader::~MediaReader() = default;

std::string MediaReader::attachment(const std::string& mime_type) const {
  for (unsigned i = 0; i < input_->demuxer->nb_streams; ++i) {
    const AVStream& stream = *input_->demuxer->streams[i];
    const AVDictionaryEntry* type = av_dict_get(stream.metadata, "mimetype", nullptr, 0);
    if (stream.codecpar->codec_type != AVMEDIA_TYPE_ATTACHMENT || !type || mime_type != type->value) continue;
    return {reinterpret_cast<const char*>(stream.codecpar->extradata),
            static_cast<std::size_t>(stream.codecpar->extradata_size)};
  }
  return {};
}

void MediaReader::expect(std::span<const VideoStream> streams, double fps) {
  input_->fps = fps;
  std::size_t found = 0;
  for (unsigned i = 0; i < input_->demuxer->nb_streams && found < streams.size(); ++i) {
    AVStream* stream = input_->demuxer->streams[i];
    if (stream->codecpar->codec_type != AVMEDIA_TYPE_VIDEO) continue;
    const VideoStream& wanted = streams[found++];
    const std::string codec = avcodec_get_name(stream->codecpar->codec_id);
    if (codec != codec_name(wanted.codec) || stream->codecpar->width != wanted.width ||
        stream->codecpar->height != wanted.height)
      input_->corrupt(fmt::format("stream {} is {} {} x {}, expected {} {} x {}", wanted.title, codec,
                                  stream->codecpar->width, stream->codecpar->height, codec_name(wanted.codec),
                                  wanted.width, wanted.height));
    input_->streams.push_back({open_decoder(*stream, input_->file.string()), stream, wanted});
  }
  if (found < streams.size()) input_->corrupt("stream " + streams[found].title + " is missing");
}

std::vector<std::vector<cv::Mat>> MediaReader::read(std::int64_t index, std::size_t without) {
  Input& in = *input_;
  if (index != in.next || without != in.without) in.seek(index);  // what was left out may stand on what went before
  in.next = -1;                                                   // until the read has succeeded
  in.without = without;
  std::vector<std::vector<cv::Mat>> pictures(in.streams.size());
  for (std::size_t missing = pictures.size() - (without < pictures.size() ? 1 : 0); missing > 0;) {
    StreamInput* stream = in.next_packet();
    if (!stream) in.corrupt(fmt::format("frame {} is missing; the file is cut short", index));
    const auto number = static_cast<std::size_t>(stream - in.streams.data());
    if (number == without) continue;
    const std::int64_t found = in.frame_index(*stream);
    if (found < index) {
      if (!stands_alone(stream->expected)) in.decode(*stream, found);  // what comes after needs it
      continue;
    }
    auto& picture = pictures[number];
    if (found > index || !picture.empty()) in.corrupt(fmt::format("frame {} is missing", index));
    picture = in.decode(*stream, index);
    --missing;
  }
  in.next = index + 1;
  return pictures;
}

}  // namespace rotunda::recon
