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

constexpr AVRational kMilliseconds{1, 1000};

std::string colours_in_words(PixelFormat format, YcbcrCoding coding) {
  return is_ycbcr(format) ? fmt::format(" ({})", to_string(coding)) : "";
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
  Muxer(const fs::path& file, const TakeCamera& camera, double fps, CameraFileCoding coding)
      : file_(file), camera_(camera), disk_(file), output_(make_matroska(disk_.context())) {
    add_stream(av_d2q(fps, 1'000'000), coding == CameraFileCoding::lossless || camera.format == PixelFormat::rgb8);
    if (coding == CameraFileCoding::lossless) output_->flags |= AVFMT_FLAG_BITEXACT;  // no random numbers in the file
    AVDictionary* options = nullptr;
    // Frames carry their own check sum, in hardware; libavformat's per cluster costs a tenth of a core at 100 MB/s.
    av_dict_set_int(&options, "write_crc32", 0, 0);
    const int result = avformat_write_header(output_.get(), &options);
    av_dict_free(&options);
    check(result, file_.string() + ": cannot write the header");
    avio_flush(output_->pb);
    check_written();
  }

  void write(const Image& image, const FrameRecord& record, std::chrono::nanoseconds in_take) {
    if (failed_ != 0) fail();
    require_shape(image);
    const AvPacket packet = encoder_ ? encoder_->encode(image) : borrowed(image);
    packet->flags |= AV_PKT_FLAG_KEY;
    packet->pts = packet->dts = next_time(in_take);
    packet->duration = 0;
    attach_record(*packet, record);
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
  void add_stream(AVRational rate, bool lossless) {
    AVStream* stream = avformat_new_stream(output_.get(), nullptr);
    if (stream == nullptr) throw std::bad_alloc();
    stream->time_base = kMilliseconds;
    stream->avg_frame_rate = rate;
    if (lossless) {
      encoder_.emplace(camera_, rate);
      encoder_->describe(*stream->codecpar);
      av_dict_set(&stream->metadata, kFfv1LayoutTag, std::string(to_string(ffv1_layout(camera_))).c_str(), 0);
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

  // Milliseconds, rising: Matroska and its readers expect that, and the exact time is in the record.
  std::int64_t next_time(std::chrono::nanoseconds in_take) {
    const auto rounded = std::chrono::round<std::chrono::milliseconds>(in_take).count();
    last_time_ = std::max<std::int64_t>(last_time_ + 1, rounded);
    return last_time_;
  }

  static void attach_record(AVPacket& packet, const FrameRecord& frame_record) {
    const auto record = encode(frame_record);
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
  std::optional<Ffv1Encoder> encoder_;
  std::int64_t last_time_ = -1;  // milliseconds
  std::int64_t whole_ = 0;       // bytes up to the end of the last whole frame
  int failed_ = 0;               // FFmpeg's error, once a write has failed
};

CameraFileWriter::CameraFileWriter(const fs::path& file, const TakeCamera& camera, double fps, CameraFileCoding coding)
    : muxer_(std::make_unique<Muxer>(file, camera, fps, coding)) {}
CameraFileWriter::~CameraFileWriter() = default;
CameraFileWriter::CameraFileWriter(CameraFileWriter&&) noexcept = default;
CameraFileWriter& CameraFileWriter::operator=(CameraFileWriter&&) noexcept = default;

void CameraFileWriter::write(const Frame& frame, const TriggerTime& time) {
  muxer_->require_shape(frame.image);
  muxer_->write(frame.image,
                {.trigger = frame.trigger,
                 .trigger_time = time.moment,
                 .exposure_start = frame.exposure_start,
                 .exposure = frame.exposure,
                 .pixels_crc = crc32c(frame.image.bytes())},
                time.in_take);
}
void CameraFileWriter::write(const Image& image, const FrameRecord& record, std::chrono::nanoseconds in_take) {
  muxer_->write(image, record, in_take);
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
