#include "capture/take/camera_file_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <system_error>

#include "capture/base/av_objects.h"
#include "capture/base/crc32c.h"
#include "capture/take/camera_stream.h"
#include "capture/take/ffv1_picture.h"
#include "config/errors.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr int kBufferSize = 4096;          // of the AVIOContext while indexing
constexpr int kSmallestSkipped = 1 << 16;  // a longer read is a frame's pixels
constexpr int kHeadOfSkipped = 4096;       // read even so: the block's header is in there
// A block's content starts with track number (one byte for track 1), time (two) and flags; lacing is never used.
constexpr int kBlockHeader = 4;

// Feeds libavformat's Matroska reader while indexing. It wants every frame's bytes; we only want to know where they
// are, so long reads get their first bytes and the rest of the buffer stays as it is.
class SkippingInput {
 public:
  explicit SkippingInput(const ReadableFile& file) : file_(file), size_(file.size()) {
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

  const ReadableFile& file_;
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

}  // namespace

CameraFileHeader read_camera_file_header(const fs::path& file) {
  const AvInput input = open_input(file);
  if (input->nb_streams < 1) throw CorruptData(file, 0, "has no video track");
  const AVStream& stream = *input->streams[0];
  const AVDictionaryEntry* tag = av_dict_get(stream.metadata, "PIXEL_FORMAT", nullptr, 0);
  const auto format = tag == nullptr ? std::nullopt : pixel_format_from(tag->value);
  if (!format) throw CorruptData(file, 0, "has no PIXEL_FORMAT tag that names a pixel format");
  return {.camera = {.name = file.stem().string(),
                     .width = pixels_across(*stream.codecpar, *format),
                     .height = stream.codecpar->height,
                     .format = *format,
                     .ycbcr = is_ycbcr(*format) ? coding_of(*stream.codecpar) : YcbcrCoding::bt601_limited},
          .fps = av_q2d(stream.avg_frame_rate)};
}

CameraFileReader::CameraFileReader(const fs::path& file, const TakeCamera& camera) : file_(file), camera_(camera) {
  try {
    input_.emplace(file);
    index();
  } catch (const std::runtime_error& error) {  // CorruptData and std::system_error: a value here, see the header
    problem_ = error.what();
  }
}

void CameraFileReader::index() {
  SkippingInput source(*input_);
  const AvInput input = open_matroska(source.context(), file_);
  if (input->nb_streams < 1) throw CorruptData(file_, 0, "has no video track");
  const AVStream& stream = *input->streams[0];
  require_coding(stream);
  const int width = pixels_across(*stream.codecpar, camera_.format);
  if (width != camera_.width || stream.codecpar->height != camera_.height)
    throw CorruptData(file_, 0,
                      fmt::format("is {} x {}, take.yaml says {} x {}", width, stream.codecpar->height, camera_.width,
                                  camera_.height));
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

// As it came, or FFV1 with its tag. Imported RGB is FFV1 with no need of one.
void CameraFileReader::require_coding(const AVStream& stream) {
  const AVCodecParameters& parameters = *stream.codecpar;
  if (is_as_it_came(parameters, camera_.format)) return;
  const AVDictionaryEntry* tag = av_dict_get(stream.metadata, kFfv1LayoutTag, nullptr, 0);
  const auto layout = ffv1_layout(camera_);
  const bool said = tag == nullptr ? layout == Ffv1Layout::rgb : tag->value == to_string(layout);
  if (parameters.codec_id != AV_CODEC_ID_FFV1 || layout == Ffv1Layout::none || !said)
    throw CorruptData(file_, 0, fmt::format("does not hold {} as take.yaml says", to_string(camera_.format)));
  ffv1_configuration_.assign(parameters.extradata, parameters.extradata + parameters.extradata_size);
  lossless_ = true;
}

std::optional<std::vector<std::uint8_t>> CameraFileReader::read_bytes(const StoredFrame& stored) const {
  if (!input_) return std::nullopt;
  std::vector<std::uint8_t> bytes(stored.size);
  if (input_->read(stored.offset, bytes) != bytes.size()) return std::nullopt;
  if (lossless_) return decode_ffv1(ffv1_configuration_, bytes, camera_);
  return bytes;
}

std::optional<Frame> CameraFileReader::read(const StoredFrame& stored) const {
  if (!stored.record) return std::nullopt;
  auto bytes = read_bytes(stored);
  if (!bytes) return std::nullopt;
  const bool sized = camera_.format != PixelFormat::mjpeg;
  if (sized && bytes->size() != image_bytes(camera_.width, camera_.height, camera_.format)) return std::nullopt;
  if (crc32c(*bytes) != stored.record->pixels_crc) return std::nullopt;
  return Frame{.camera = camera_.name,
               .trigger = stored.record->trigger,
               .exposure_start = stored.record->exposure_start,
               .exposure = stored.record->exposure,
               .image = make_image(camera_.width, camera_.height, camera_.format, std::move(*bytes), camera_.ycbcr)};
}

}  // namespace rotunda::capture
