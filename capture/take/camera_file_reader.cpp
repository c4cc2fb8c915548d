#include "capture/take/camera_file_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <new>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "capture/base/av_objects.h"
#include "capture/base/crc32c.h"
#include "config/errors.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

namespace rotunda::capture {

namespace fs = std::filesystem;

class CameraFileReader::Descriptor {
 public:
  explicit Descriptor(const fs::path& file) : fd_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "cannot open " + file.string());
  }
  ~Descriptor() { ::close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  std::int64_t file_size() const {
    struct stat status {};
    return ::fstat(fd_, &status) == 0 ? status.st_size : 0;
  }

  // How many bytes there were: fewer than asked for at the file's end.
  std::size_t read(std::int64_t offset, std::span<std::uint8_t> bytes) const {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t got =
          ::pread(fd_, bytes.data() + done, bytes.size() - done, offset + static_cast<std::int64_t>(done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) throw std::system_error(errno, std::generic_category(), "cannot read from the take");
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    return done;
  }

 private:
  int fd_;
};

namespace {

constexpr int kBufferSize = 4096;          // of the AVIOContext while indexing
constexpr int kSmallestSkipped = 1 << 16;  // a longer read is a frame's pixels
constexpr int kHeadOfSkipped = 4096;       // read even so: the block's header is in there
// A block's content starts with track number (one byte for track 1), time (two) and flags; lacing is never used.
constexpr int kBlockHeader = 4;

// Feeds libavformat's Matroska reader while indexing. It wants every frame's bytes; we only want to know where they
// are, so long reads get their first bytes and the rest of the buffer stays as it is.
template <class Descriptor>
class SkippingInput {
 public:
  explicit SkippingInput(const Descriptor& file) : file_(file), size_(file.file_size()) {
    auto* buffer = static_cast<unsigned char*>(av_malloc(kBufferSize));
    if (buffer == nullptr) throw std::bad_alloc();
    context_ = avio_alloc_context(buffer, kBufferSize, 0, this, &SkippingInput::read, nullptr, &SkippingInput::seek);
    if (context_ == nullptr) {
      av_free(buffer);
      throw std::bad_alloc();
    }
  }
  ~SkippingInput() {
    av_freep(&context_->buffer);
    avio_context_free(&context_);
  }
  SkippingInput(const SkippingInput&) = delete;
  SkippingInput& operator=(const SkippingInput&) = delete;
  AVIOContext* context() { return context_; }

 private:
  static int read(void* self, std::uint8_t* buffer, int size) noexcept {
    auto& input = *static_cast<SkippingInput*>(self);
    const auto left = static_cast<int>(std::min<std::int64_t>(size, input.size_ - input.at_));
    if (left <= 0) return AVERROR_EOF;
    const int wanted = left >= kSmallestSkipped ? kHeadOfSkipped : left;
    try {
      input.file_.read(input.at_, {buffer, static_cast<std::size_t>(wanted)});
    } catch (const std::system_error& error) {
      return AVERROR(error.code().value());
    }
    input.at_ += left;
    return left;
  }

  static std::int64_t seek(void* self, std::int64_t offset, int whence) noexcept {
    auto& input = *static_cast<SkippingInput*>(self);
    if ((whence & AVSEEK_SIZE) != 0) return input.size_;
    if (whence == SEEK_CUR) offset += input.at_;
    if (whence == SEEK_END) offset += input.size_;
    if (offset < 0) return AVERROR(EINVAL);
    return input.at_ = offset;
  }

  const Descriptor& file_;
  std::int64_t size_;
  std::int64_t at_ = 0;
  AVIOContext* context_ = nullptr;
};

AvInput open_matroska(AVIOContext* io, const fs::path& file) {
  keep_av_quiet();
  AVFormatContext* input = avformat_alloc_context();
  if (input == nullptr) throw std::bad_alloc();
  input->pb = io;
  input->flags |= AVFMT_FLAG_NOPARSE;  // the pixels are not there to be looked at
  check(avformat_open_input(&input, nullptr, av_find_input_format("matroska"), nullptr), file.string());
  return AvInput(input);
}

std::optional<FrameRecord> record_of(const AVPacket& packet) {
  constexpr std::size_t block_add_id = 8;  // bytes before the data
  std::size_t size = 0;
  const std::uint8_t* data = av_packet_get_side_data(&packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, &size);
  if (data == nullptr || size < block_add_id) return std::nullopt;
  return decode_frame_record({data + block_add_id, size - block_add_id});
}

// Rows top to bottom without padding, as RGB; nothing if FFV1's own check finds damage.
std::optional<std::vector<std::uint8_t>> decode_ffv1(std::span<const std::uint8_t> configuration,
                                                     std::span<const std::uint8_t> bytes, const TakeCamera& camera) {
  const AvCodec codec = make_decoder("ffv1");
  codec->width = camera.width;
  codec->height = camera.height;
  codec->thread_count = 1;
  codec->err_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE;
  codec->extradata = static_cast<std::uint8_t*>(av_mallocz(configuration.size() + AV_INPUT_BUFFER_PADDING_SIZE));
  if (codec->extradata == nullptr) throw std::bad_alloc();
  codec->extradata_size = static_cast<int>(configuration.size());
  std::copy(configuration.begin(), configuration.end(), codec->extradata);
  const AvPacket packet = make_packet();
  if (avcodec_open2(codec.get(), nullptr, nullptr) < 0) return std::nullopt;
  check(av_new_packet(packet.get(), static_cast<int>(bytes.size())), "FFV1 packet");
  std::copy(bytes.begin(), bytes.end(), packet->data);
  const AvFrame picture = make_frame();
  if (avcodec_send_packet(codec.get(), packet.get()) < 0) return std::nullopt;
  if (avcodec_receive_frame(codec.get(), picture.get()) < 0) return std::nullopt;
  if (picture->format != AV_PIX_FMT_BGR0 || picture->width != camera.width || picture->height != camera.height)
    return std::nullopt;
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) *
                                   3);
  const cv::Mat bgr0(camera.height, camera.width, CV_8UC4, picture->data[0],
                     static_cast<std::size_t>(picture->linesize[0]));
  cv::Mat rgb(camera.height, camera.width, CV_8UC3, pixels.data());
  cv::cvtColor(bgr0, rgb, cv::COLOR_BGRA2RGB);
  return pixels;
}

}  // namespace

namespace {

// Pixels in a row of the stream, whose width counts bytes where the samples went in as grey.
int pixels_across(int stream_width, PixelFormat format) {
  if (format == PixelFormat::rgb8 || format == PixelFormat::mjpeg || is_ycbcr(format)) return stream_width;
  return stream_width * 8 / layout_of(format).stored_bits;
}

AVCodecID codec_of(PixelFormat format) {
  if (format == PixelFormat::mjpeg) return AV_CODEC_ID_MJPEG;
  return format == PixelFormat::rgb8 ? AV_CODEC_ID_FFV1 : AV_CODEC_ID_RAWVIDEO;
}

YcbcrCoding coding_of(const AVCodecParameters& parameters) {
  const bool full = parameters.color_range == AVCOL_RANGE_JPEG;
  if (parameters.color_space == AVCOL_SPC_BT709) return full ? YcbcrCoding::bt709_full : YcbcrCoding::bt709_limited;
  return full ? YcbcrCoding::bt601_full : YcbcrCoding::bt601_limited;
}

}  // namespace

CameraFileHeader read_camera_file_header(const fs::path& file) {
  const AvInput input = open_input(file);
  if (input->nb_streams < 1) throw CorruptData(file, 0, "has no video track");
  const AVStream& stream = *input->streams[0];
  const AVDictionaryEntry* tag = av_dict_get(stream.metadata, "PIXEL_FORMAT", nullptr, 0);
  const auto format = tag == nullptr ? std::nullopt : pixel_format_from(tag->value);
  if (!format) throw CorruptData(file, 0, "has no PIXEL_FORMAT tag that names a pixel format");
  return {.camera = {.name = file.stem().string(),
                     .width = pixels_across(stream.codecpar->width, *format),
                     .height = stream.codecpar->height,
                     .format = *format,
                     .ycbcr = is_ycbcr(*format) ? coding_of(*stream.codecpar) : YcbcrCoding::bt601_limited},
          .fps = av_q2d(stream.avg_frame_rate)};
}

CameraFileReader::CameraFileReader(const fs::path& file, const TakeCamera& camera) : file_(file), camera_(camera) {
  try {
    descriptor_ = std::make_unique<Descriptor>(file);
    index();
  } catch (const std::runtime_error& error) {  // CorruptData and std::system_error: a value here, see the header
    problem_ = error.what();
  }
}

CameraFileReader::~CameraFileReader() = default;
CameraFileReader::CameraFileReader(CameraFileReader&&) noexcept = default;
CameraFileReader& CameraFileReader::operator=(CameraFileReader&&) noexcept = default;

void CameraFileReader::index() {
  SkippingInput<Descriptor> source(*descriptor_);
  const AvInput input = open_matroska(source.context(), file_);
  if (input->nb_streams < 1) throw CorruptData(file_, 0, "has no video track");
  const AVCodecParameters& parameters = *input->streams[0]->codecpar;
  if (parameters.codec_id != codec_of(camera_.format))
    throw CorruptData(file_, 0, fmt::format("does not hold {} as take.yaml says", to_string(camera_.format)));
  const int width = pixels_across(parameters.width, camera_.format);
  if (width != camera_.width || parameters.height != camera_.height)
    throw CorruptData(
        file_, 0,
        fmt::format("is {} x {}, take.yaml says {} x {}", width, parameters.height, camera_.width, camera_.height));
  if (camera_.format == PixelFormat::rgb8)
    ffv1_configuration_.assign(parameters.extradata, parameters.extradata + parameters.extradata_size);
  const AvPacket packet = make_packet();
  int result = 0;
  while ((result = av_read_frame(input.get(), packet.get())) >= 0) {
    if (packet->stream_index == 0 && packet->pos >= 0)
      frames_.push_back({.record = record_of(*packet),
                         .offset = packet->pos + kBlockHeader,
                         .size = static_cast<std::size_t>(packet->size)});
    av_packet_unref(packet.get());
  }
  if (result != AVERROR_EOF) problem_ = file_.string() + ": " + av_error_text(result);
}

std::optional<Frame> CameraFileReader::read(const StoredFrame& stored) const {
  if (!stored.record || !descriptor_) return std::nullopt;
  std::vector<std::uint8_t> bytes(stored.size);
  if (descriptor_->read(stored.offset, bytes) != bytes.size()) return std::nullopt;
  if (!ffv1_configuration_.empty()) {
    auto pixels = decode_ffv1(ffv1_configuration_, bytes, camera_);
    if (!pixels) return std::nullopt;
    bytes = std::move(*pixels);
  }
  const bool sized = camera_.format != PixelFormat::mjpeg;
  if (sized && bytes.size() != image_bytes(camera_.width, camera_.height, camera_.format)) return std::nullopt;
  if (crc32c(bytes) != stored.record->pixels_crc) return std::nullopt;
  return Frame{.camera = camera_.name,
               .trigger = stored.record->trigger,
               .exposure_start = stored.record->exposure_start,
               .exposure = stored.record->exposure,
               .image = make_image(camera_.width, camera_.height, camera_.format, std::move(bytes), camera_.ycbcr)};
}

}  // namespace rotunda::capture
