#include "capture/take/camera_file_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <new>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "capture/base/av_objects.h"
#include "capture/base/crc32c.h"
#include "capture/take/frame_record.h"
#include "config/errors.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr AVRational kMilliseconds{1, 1000};

// 8-bit RGB enters FFV1 as blue, green, red, nothing: the one 8-bit RGB layout it codes.
constexpr AVPixelFormat kFfv1Rgb = AV_PIX_FMT_BGR0;

AvCodec open_ffv1(const TakeCamera& camera, AVRational rate) {
  AvCodec codec = make_encoder("ffv1");
  codec->width = camera.width;
  codec->height = camera.height;
  codec->pix_fmt = kFfv1Rgb;
  codec->time_base = av_inv_q(rate);
  codec->level = 3;
  codec->gop_size = 1;
  codec->slices = 4;
  codec->thread_count = 1;
  av_opt_set_int(codec->priv_data, "slicecrc", 1, 0);
  check(avcodec_open2(codec.get(), nullptr, nullptr), camera.name + ": FFV1 encoder");
  return codec;
}

// Y'CbCr goes in under the name that players know it by, so that they show its colours.
struct YcbcrStream {
  PixelFormat format;
  std::uint32_t tag;
  AVPixelFormat av_format;
};
constexpr std::array kYcbcrStreams{
    YcbcrStream{PixelFormat::yuyv, MKTAG('Y', 'U', 'Y', '2'), AV_PIX_FMT_YUYV422},
    YcbcrStream{PixelFormat::uyvy, MKTAG('U', 'Y', 'V', 'Y'), AV_PIX_FMT_UYVY422},
    YcbcrStream{PixelFormat::nv12, MKTAG('N', 'V', '1', '2'), AV_PIX_FMT_NV12},
};

void describe_colours(AVCodecParameters& parameters, YcbcrCoding coding) {
  const bool bt709 = coding == YcbcrCoding::bt709_limited || coding == YcbcrCoding::bt709_full;
  const bool full = coding == YcbcrCoding::bt601_full || coding == YcbcrCoding::bt709_full;
  parameters.color_space = bt709 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
  parameters.color_range = full ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
}

void describe_ycbcr(AVCodecParameters& parameters, const TakeCamera& camera) {
  const auto stream = std::find_if(kYcbcrStreams.begin(), kYcbcrStreams.end(),
                                   [&](const auto& row) { return row.format == camera.format; });
  parameters.codec_id = AV_CODEC_ID_RAWVIDEO;
  parameters.codec_tag = stream->tag;
  parameters.format = stream->av_format;
  parameters.width = camera.width;
  describe_colours(parameters, camera.ycbcr);
}

void describe_jpeg(AVCodecParameters& parameters, const TakeCamera& camera) {
  parameters.codec_id = AV_CODEC_ID_MJPEG;
  parameters.format = AV_PIX_FMT_YUVJ422P;
  parameters.width = camera.width;
  describe_colours(parameters, YcbcrCoding::bt601_full);
}

// Samples as grey, as wide as a row has bytes: packed and 16-bit pixels are not bytes.
void describe_samples(AVCodecParameters& parameters, const TakeCamera& camera) {
  parameters.codec_id = AV_CODEC_ID_RAWVIDEO;
  parameters.codec_tag = MKTAG('Y', '8', '0', '0');
  parameters.format = AV_PIX_FMT_GRAY8;
  const auto rows = static_cast<std::size_t>(camera.height);
  parameters.width = static_cast<int>((image_bytes(camera.width, camera.height, camera.format) + rows - 1) / rows);
}

void describe_as_it_came(AVCodecParameters& parameters, const TakeCamera& camera) {
  parameters.codec_type = AVMEDIA_TYPE_VIDEO;
  parameters.height = camera.height;
  if (camera.format == PixelFormat::mjpeg)
    describe_jpeg(parameters, camera);
  else if (is_ycbcr(camera.format))
    describe_ycbcr(parameters, camera);
  else
    describe_samples(parameters, camera);
}

std::string colours_in_words(PixelFormat format, YcbcrCoding coding) {
  return is_ycbcr(format) ? fmt::format(" ({})", to_string(coding)) : "";
}

AvFrame wrap_for_ffv1(const Image& image) {
  AvFrame picture = make_frame();
  picture->format = kFfv1Rgb;
  picture->width = image.width;
  picture->height = image.height;
  check(av_frame_get_buffer(picture.get(), 0), "picture buffer");
  const cv::Mat rgb(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.get()));
  cv::Mat bgr0(image.height, image.width, CV_8UC4, picture->data[0], static_cast<std::size_t>(picture->linesize[0]));
  cv::cvtColor(rgb, bgr0, cv::COLOR_RGB2BGRA);
  return picture;
}

// The file under the muxer. libavformat's own file protocol copies through a buffer of 256 kB; this one passes the
// cluster on as it is (AVIOContext::direct).
class OutputFile {
 public:
  explicit OutputFile(const fs::path& file) : fd_(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)) {
    if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "cannot write " + file.string());
    constexpr int size = 4096;
    auto* buffer = static_cast<unsigned char*>(av_malloc(size));
    context_ = avio_alloc_context(buffer, size, 1, this, nullptr, &OutputFile::write, &OutputFile::seek);
    if (context_ == nullptr) throw std::bad_alloc();
    context_->direct = 1;
  }
  ~OutputFile() {
    av_freep(&context_->buffer);
    avio_context_free(&context_);
    ::close(fd_);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  AVIOContext* context() { return context_; }
  int fd() const { return fd_; }

 private:
  static int write(void* self, std::uint8_t* bytes, int size) noexcept {
    const int fd = static_cast<OutputFile*>(self)->fd_;
    for (int done = 0; done < size;) {
      const ssize_t written = ::write(fd, bytes + done, static_cast<std::size_t>(size - done));
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return AVERROR(errno);
      done += static_cast<int>(written);
    }
    return size;
  }

  static std::int64_t seek(void* self, std::int64_t offset, int whence) noexcept {
    if ((whence & AVSEEK_SIZE) != 0) return AVERROR(ENOSYS);
    const off_t place = ::lseek(static_cast<OutputFile*>(self)->fd_, offset, whence & ~AVSEEK_FORCE);
    return place < 0 ? AVERROR(errno) : place;
  }

  int fd_;
  AVIOContext* context_ = nullptr;
};

AvOutput make_matroska(AVIOContext* io) {
  keep_av_quiet();
  AVFormatContext* context = nullptr;
  check(avformat_alloc_output_context2(&context, nullptr, "matroska", nullptr), "Matroska muxer");
  AvOutput output(context);
  output->pb = io;
  output->flags |= AVFMT_FLAG_CUSTOM_IO;
  return output;
}

}  // namespace

class CameraFileWriter::Muxer {
 public:
  Muxer(const fs::path& file, const TakeCamera& camera, double fps)
      : file_(file), camera_(camera), disk_(file), output_(make_matroska(disk_.context())) {
    const AVRational rate = av_d2q(fps, 1'000'000);
    add_stream(rate);
    AVDictionary* options = nullptr;
    // Frames carry their own check sum, in hardware; libavformat's per cluster costs a tenth of a core at 100 MB/s.
    av_dict_set_int(&options, "write_crc32", 0, 0);
    const int result = avformat_write_header(output_.get(), &options);
    av_dict_free(&options);
    check(result, file_.string() + ": cannot write the header");
    avio_flush(output_->pb);
    check_written();
  }

  void write(const Frame& frame, const TriggerTime& time) {
    if (failed_ != 0) fail();
    require_shape(frame.image);
    const AvPacket packet = encoder_ ? compressed(frame.image) : borrowed(frame.image);
    packet->flags |= AV_PKT_FLAG_KEY;
    packet->pts = packet->dts = next_time(time.in_take);
    packet->duration = 0;
    attach_record(*packet, frame, time.moment);
    failed_ = std::min(av_write_frame(output_.get(), packet.get()), 0);
    if (failed_ == 0) failed_ = std::min(av_write_frame(output_.get(), nullptr), 0);  // ends the cluster
    check_written();
  }

  void close() {
    if (failed_ == 0) {
      failed_ = std::min(av_write_trailer(output_.get()), 0);
      check_written();
    }
    sync();
  }

  void sync() const {
    if (::fdatasync(disk_.fd()) != 0)
      throw std::system_error(errno, std::generic_category(), file_.string() + ": cannot be brought to disk");
    // What is on disk need not stay in memory: the next second's frames then go into pages that are warm already, and
    // a long take does not push everything else out of the cache.
    ::posix_fadvise(disk_.fd(), 0, 0, POSIX_FADV_DONTNEED);
  }

  void require_shape(const Image& image) const {
    const bool colours = !is_ycbcr(image.format) || image.ycbcr == camera_.ycbcr;
    if (image.width == camera_.width && image.height == camera_.height && image.format == camera_.format && colours)
      return;
    throw InvalidInput(fmt::format("{}: the frame is {} x {} {}{}, the take was begun with {} x {} {}{}", camera_.name,
                                   image.width, image.height, to_string(image.format),
                                   colours_in_words(image.format, image.ycbcr), camera_.width, camera_.height,
                                   to_string(camera_.format), colours_in_words(camera_.format, camera_.ycbcr)));
  }

 private:
  void add_stream(AVRational rate) {
    AVStream* stream = avformat_new_stream(output_.get(), nullptr);
    if (stream == nullptr) throw std::bad_alloc();
    stream->time_base = kMilliseconds;
    stream->avg_frame_rate = rate;
    if (camera_.format == PixelFormat::rgb8) {
      encoder_ = open_ffv1(camera_, rate);
      check(avcodec_parameters_from_context(stream->codecpar, encoder_.get()), file_.string());
    } else {
      describe_as_it_came(*stream->codecpar, camera_);
    }
    av_dict_set(&stream->metadata, "PIXEL_FORMAT", std::string(to_string(camera_.format)).c_str(), 0);
    av_dict_set(&stream->metadata, "title", camera_.name.c_str(), 0);
  }

  // The muxer reads the pixels where they lie: no copy, no owner, the packet ends before the frame.
  static AvPacket borrowed(const Image& image) {
    AvPacket packet = make_packet();
    packet->data = const_cast<std::uint8_t*>(image.pixels.get());
    packet->size = static_cast<int>(image.size_bytes());
    return packet;
  }

  AvPacket compressed(const Image& image) {
    AvFrame picture = wrap_for_ffv1(image);
    picture->pts = encoded_++;
    check(avcodec_send_frame(encoder_.get(), picture.get()), file_.string());
    AvPacket packet = make_packet();
    check(avcodec_receive_packet(encoder_.get(), packet.get()), file_.string());
    return packet;
  }

  // Milliseconds, rising: Matroska and its readers expect that, and the exact time is in the record.
  std::int64_t next_time(std::chrono::nanoseconds in_take) {
    const auto rounded = std::chrono::round<std::chrono::milliseconds>(in_take).count();
    last_time_ = std::max<std::int64_t>(last_time_ + 1, rounded);
    return last_time_;
  }

  static void attach_record(AVPacket& packet, const Frame& frame, Timestamp trigger_time) {
    const auto record = encode({.trigger = frame.trigger,
                                .trigger_time = trigger_time,
                                .exposure_start = frame.exposure_start,
                                .exposure = frame.exposure,
                                .pixels_crc = crc32c(frame.image.bytes())});
    constexpr std::array<std::uint8_t, 8> block_add_id{0, 0, 0, 0, 0, 0, 0, 1};
    std::uint8_t* data =
        av_packet_new_side_data(&packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, block_add_id.size() + record.size());
    if (data == nullptr) throw std::bad_alloc();
    std::copy(record.begin(), record.end(), std::copy(block_add_id.begin(), block_add_id.end(), data));
  }

  // Notes how far the file is whole, or cuts it back to there.
  void check_written() {
    if (failed_ == 0) failed_ = std::min(output_->pb->error, 0);
    if (failed_ == 0) {
      whole_ = avio_tell(output_->pb);
      return;
    }
    // If even this fails the reader finds the part of a frame and leaves it out.
    static_cast<void>(::ftruncate(disk_.fd(), whole_));
    fail();
  }

  [[noreturn]] void fail() const {
    check(failed_, "cannot write " + file_.string());
    throw std::logic_error(file_.string() + ": no failure to report");
  }

  fs::path file_;
  TakeCamera camera_;
  OutputFile disk_;
  AvOutput output_;
  AvCodec encoder_;              // only for RGB
  std::int64_t encoded_ = 0;     // frames
  std::int64_t last_time_ = -1;  // milliseconds
  std::int64_t whole_ = 0;       // bytes up to the end of the last whole frame
  int failed_ = 0;               // FFmpeg's error, once a write has failed
};

CameraFileWriter::CameraFileWriter(const fs::path& file, const TakeCamera& camera, double fps)
    : muxer_(std::make_unique<Muxer>(file, camera, fps)) {}
CameraFileWriter::~CameraFileWriter() = default;
CameraFileWriter::CameraFileWriter(CameraFileWriter&&) noexcept = default;
CameraFileWriter& CameraFileWriter::operator=(CameraFileWriter&&) noexcept = default;

void CameraFileWriter::write(const Frame& frame, const TriggerTime& time) {
  muxer_->write(frame, time);
}
void CameraFileWriter::require_shape(const Image& image) const {
  muxer_->require_shape(image);
}
void CameraFileWriter::close() {
  muxer_->close();
}
void CameraFileWriter::sync() const {
  muxer_->sync();
}

}  // namespace rotunda::capture
