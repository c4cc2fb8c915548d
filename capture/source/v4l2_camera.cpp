#include "capture/source/v4l2_camera.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <numeric>
#include <set>

#include "capture/source/v4l2_control.h"
#include "capture/source/v4l2_query.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kFewestBuffers = 2;                     // one to fill while another is read
constexpr std::uint32_t kMostBuffers = 32;                      // of the kernel (VIDEO_MAX_FRAME)
constexpr std::int64_t kLongestUptime = std::int64_t{1} << 32;  // seconds, 136 years; more overflows nanoseconds soon
constexpr double kRateTolerance = 1e-3;                         // NTSC's 29.97 for 30 is one

}  // namespace

V4l2Camera::V4l2Camera(V4l2System& system, const SourceSettings& settings)
    : system_(system), settings_(settings), path_(path_of_device()) {
  node_.emplace(system_, path_);
  if (!*node_) fail("opening it");
  require_capture_node();
}

V4l2Camera::~V4l2Camera() {
  stop();
  release_buffers();
}

void V4l2Camera::fail(const std::string& doing) const {
  const int error = errno;
  const auto told = [&](const std::string& cure) {
    throw DeviceError(settings_.camera, fmt::format("{}: {}: {}{}", path_, doing, std::strerror(error), cure));
  };
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      told("; is it plugged in? `rotunda cameras` lists those there are");
      break;
    case EACCES:
    case EPERM:
      told("; put the user who runs this into the group video");
      break;
    case EBUSY:
      told(fmt::format("; another program uses it: close that first (`fuser -v {}` names it)", path_));
      break;
    default:
      told("");
  }
  throw std::logic_error("unreachable");
}

std::string V4l2Camera::path_of_device() const {
  if (settings_.device.rfind('/', 0) == 0) return settings_.device;
  for (const auto& path : system_.nodes()) {
    const V4l2Node node(system_, path);
    v4l2_capability told{};
    if (!node || !node.ask(VIDIOC_QUERYCAP, told) || !captures(told)) continue;
    if (text(told.bus_info) == settings_.device || system_.serial_of(path) == settings_.device) return path;
  }
  throw DeviceError(settings_.camera,
                    fmt::format("no video device has the serial number or bus address \"{}\"; `rotunda cameras` "
                                "lists those there are, /dev/video0 and /dev/v4l/by-path/... name one too",
                                settings_.device));
}

void V4l2Camera::require_capture_node() {
  if (!node_->ask(VIDIOC_QUERYCAP, capability_)) {
    if (errno == ENOTTY || errno == EINVAL)
      throw DeviceError(settings_.camera, path_ + " is no video device; `rotunda cameras` lists those there are");
    fail("asking what it can do");
  }
  if (!captures(capability_))
    throw DeviceError(settings_.camera, fmt::format("{} ({}) captures no pictures: a camera may have several nodes, "
                                                    "`rotunda cameras` lists the right ones",
                                                    path_, text(capability_.card)));
  if ((capabilities_of(capability_) & V4L2_CAP_STREAMING) == 0)
    throw DeviceError(settings_.camera, path_ +
                                            ": its driver cannot stream into mapped memory, only read(); such "
                                            "cameras are not supported");
  type_ = capture_type(capability_);
}

std::string V4l2Camera::offered_formats() const {
  std::vector<std::string> names;
  for (const auto& told : formats_of(*node_, type_)) {
    const auto ours = pixel_format_of(told.pixelformat);
    names.push_back(ours ? std::string(to_string(*ours)) : fourcc_text(told.pixelformat) + " (not supported)");
  }
  return names.empty() ? "none it would tell" : fmt::format("{}", fmt::join(names, ", "));
}

std::string V4l2Camera::offered_rates() const {
  std::vector<std::string> rates;
  for (std::uint32_t i = 0; i < kMostRows; ++i) {
    v4l2_frmivalenum told{};
    told.index = i;
    told.pixel_format = fourccs_of(layout_.format).front();
    told.width = static_cast<std::uint32_t>(layout_.width);
    told.height = static_cast<std::uint32_t>(layout_.height);
    if (!node_->ask(VIDIOC_ENUM_FRAMEINTERVALS, told)) break;
    if (told.type != V4L2_FRMIVAL_TYPE_DISCRETE)
      return fmt::format("{} to {} Hz", rate_text(told.stepwise.max), rate_text(told.stepwise.min));
    rates.push_back(rate_text(told.discrete));
  }
  return rates.empty() ? "no rates it would tell" : fmt::format("{} Hz", fmt::join(rates, ", "));
}

v4l2_format V4l2Camera::current_format() const {
  v4l2_format format{};
  format.type = type_;
  if (!node_->ask(VIDIOC_G_FMT, format)) fail("reading its image format");
  return format;
}

void V4l2Camera::choose_format() const {
  const auto fourccs = fourccs_of(settings_.format);
  v4l2_format format = current_format();
  const Agreed before = agreed_in(format);
  const auto width = settings_.width > 0 ? static_cast<std::uint32_t>(settings_.width) : before.width;
  const auto height = settings_.height > 0 ? static_cast<std::uint32_t>(settings_.height) : before.height;
  bool taken = false;
  for (std::size_t i = 0; i < fourccs.size() && !taken; ++i) {
    format = wanted_format(format, width, height, fourccs[i]);
    const bool answered = node_->ask(VIDIOC_S_FMT, format);
    if (!answered && errno == EBUSY) fail("setting its image format");
    taken = answered && agreed_in(format).fourcc == fourccs[i];
  }
  if (!taken)
    throw DeviceError(settings_.camera, fmt::format("{} does not send {}; set pixel_format to one of: {}", path_,
                                                    to_string(settings_.format), offered_formats()));
}

// Asked for once more when the controls are set: some change how colours are coded, or a mosaic's order (flips).
void V4l2Camera::adopt_format(SourceDescription& description) {
  const v4l2_format format = current_format();
  require_as_agreed(format);
  const Agreed now = agreed_in(format);
  layout_ = {static_cast<int>(now.width), static_cast<int>(now.height), settings_.format, now.row_bytes};
  if (layout_.row_bytes == 0) layout_.row_bytes = bytes_in_row(layout_.width, layout_.format);
  buffer_bytes_ = now.bytes;
  const auto colours = colorimetry_of(now.colorspace, now.ycbcr, now.quantization);
  if (is_ycbcr(settings_.format)) description.ycbcr = colours.coding;
  if (is_ycbcr(settings_.format) && !colours.exact)
    description.warnings.push_back(fmt::format("its colours are coded in a way that is not supported; {} stands for it",
                                               to_string(colours.coding)));
  if (auto warning = field_warning(now.field); !warning.empty()) description.warnings.push_back(std::move(warning));
}

void V4l2Camera::require_as_agreed(const v4l2_format& format) const {
  const Agreed now = agreed_in(format);
  const auto refuse = [&](const std::string& why) { throw DeviceError(settings_.camera, path_ + " " + why); };
  if (now.width > 65536 || now.height > 65536 || now.width == 0 || now.height == 0)
    refuse(fmt::format("says that its images are {} x {} pixels", now.width, now.height));
  const int width = static_cast<int>(now.width), height = static_cast<int>(now.height);
  if (pixel_format_of(now.fourcc) != settings_.format)
    refuse(fmt::format("came to send {} by one of its controls where {} was asked; set pixel_format so",
                       fourcc_text(now.fourcc), to_string(settings_.format)));
  if ((settings_.width > 0 && width != settings_.width) || (settings_.height > 0 && height != settings_.height))
    refuse(
        fmt::format("sends {} x {} where {} x {} was asked; set width and height so, or see `v4l2-ctl -d {} "
                    "--list-formats-ext`",
                    width, height, settings_.width, settings_.height, path_));
  const auto group = pixel_group(settings_.format);
  if (width % group.across != 0 || height % group.down != 0)
    refuse(fmt::format("sends {} x {}, which {} cannot be; set another width and height", width, height,
                       to_string(settings_.format)));
  if (now.planes != 1)
    refuse(fmt::format("puts an image into {} pieces of memory, which is not supported", now.planes));
  if (now.field == V4L2_FIELD_ALTERNATE || now.field == V4L2_FIELD_SEQ_TB || now.field == V4L2_FIELD_SEQ_BT)
    refuse("sends half frames one after the other, which is not supported; set it to a progressive mode");
  const BufferLayout layout{width, height, settings_.format, now.row_bytes};
  const bool fits = now.row_bytes == 0 || now.row_bytes >= bytes_in_row(width, settings_.format);
  if (settings_.format != PixelFormat::mjpeg && (!fits || (now.row_bytes > 0 && now.bytes < bytes_needed(layout))))
    refuse(fmt::format("says {} bytes a row and {} an image, too few for {} x {} {}", now.row_bytes, now.bytes, width,
                       height, to_string(settings_.format)));
}

// A camera that is triggered from outside has no rate of its own.
void V4l2Camera::set_rate(std::vector<std::string>& warnings) {
  if (!settings_.frame_rate_hz || settings_.trigger != TriggerMode::freerun) return;
  const double wanted = *settings_.frame_rate_hz;
  v4l2_streamparm parameters{};
  parameters.type = type_;
  parameters.parm.capture.timeperframe = interval_of(wanted);
  if (!node_->ask(VIDIOC_S_PARM, parameters)) {
    if (errno == EBUSY || errno == ENODEV) fail("setting its frame rate");
    warnings.push_back(fmt::format("its driver sets no frame rate; see to it that it sends {} Hz", wanted));
    return;
  }
  const auto& interval = parameters.parm.capture.timeperframe;
  if (interval.numerator == 0 || interval.denominator == 0) {
    warnings.push_back(fmt::format("its driver does not tell its frame rate; see to it that it sends {} Hz", wanted));
    return;
  }
  const double rate = double{1} * interval.denominator / interval.numerator;
  if (std::abs(rate - wanted) > kRateTolerance * wanted)
    warnings.push_back(
        fmt::format("it sends {:g} Hz where trigger.rate_hz asks for {:g}, so frame sets will have "
                    "holes or frames be left over; it offers {}",
                    rate, wanted, offered_rates()));
}

SourceDescription V4l2Camera::configure() {
  SourceDescription description;
  choose_format();
  const auto differences = apply_controls(*node_, settings_);
  adopt_format(description);
  description.vendor = text(capability_.driver);
  description.model = text(capability_.card);
  description.serial = system_.serial_of(path_);
  description.address = path_;
  description.width = layout_.width;
  description.height = layout_.height;
  description.format = layout_.format;
  set_rate(description.warnings);
  description.exposure = apply_exposure(*node_, settings_, description.warnings).value_or(std::chrono::nanoseconds{});
  description.warnings.insert(description.warnings.end(), differences.begin(), differences.end());
  return description;
}

std::uint32_t V4l2Camera::request_buffers(std::uint32_t count) {
  v4l2_requestbuffers request{};
  request.count = count;
  request.type = type_;
  request.memory = V4L2_MEMORY_MMAP;
  return node_->ask(VIDIOC_REQBUFS, request) ? request.count : 0;
}

// Memory for frames may be short on small machines: fewer buffers do, down to two.
void V4l2Camera::map_buffers() {
  auto count = std::clamp(static_cast<std::uint32_t>(std::max(settings_.buffers, 0)), kFewestBuffers, kMostBuffers);
  std::uint32_t granted = request_buffers(count);
  for (; granted == 0 && errno == ENOMEM && count / 2 >= kFewestBuffers; granted = request_buffers(count)) count /= 2;
  if (granted == 0) fail("asking for frame buffers");
  if (granted < kFewestBuffers)
    throw DeviceError(settings_.camera, path_ + ": its driver has one frame buffer only, and needs two to stream");
  for (std::uint32_t i = 0; i < granted; ++i) map_one(i);
}

v4l2_buffer V4l2Camera::buffer_for(std::uint32_t index, v4l2_plane& plane) const {
  v4l2_buffer buffer{};
  buffer.type = type_;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  if (multiplanar()) {
    buffer.m.planes = &plane;
    buffer.length = 1;
  }
  return buffer;
}

void V4l2Camera::map_one(std::uint32_t index) {
  v4l2_plane plane{};
  v4l2_buffer buffer = buffer_for(index, plane);
  if (!node_->ask(VIDIOC_QUERYBUF, buffer)) fail("asking for a frame buffer's place");
  const std::size_t bytes = multiplanar() ? plane.length : buffer.length;
  const std::uint32_t offset = multiplanar() ? plane.m.mem_offset : buffer.m.offset;
  if (bytes < bytes_needed(layout_))
    throw DeviceError(settings_.camera, fmt::format("{}: a frame buffer has {} bytes, an image needs {}", path_, bytes,
                                                    bytes_needed(layout_)));
  void* address = system_.map(node_->fd(), bytes, offset);
  if (address == nullptr) fail("mapping a frame buffer");
  mappings_.push_back({address, bytes});
}

void V4l2Camera::start() {
  refused_.clear();
  for (std::uint32_t i = 0; i < mappings_.size(); ++i)
    if (!queue(i)) fail("handing it a frame buffer");
  auto type = static_cast<int>(type_);
  if (!node_->ask(VIDIOC_STREAMON, type)) {
    const int error = errno;
    stop();  // takes the buffers back
    errno = error;
    fail("starting its stream");
  }
}

void V4l2Camera::stop() noexcept {
  auto type = static_cast<int>(type_);
  if (node_ && *node_ && !mappings_.empty()) node_->ask(VIDIOC_STREAMOFF, type);
}

void V4l2Camera::release_buffers() noexcept {
  if (mappings_.empty()) return;
  for (const auto& mapping : mappings_) system_.unmap(mapping.address, mapping.bytes);
  mappings_.clear();
  request_buffers(0);
}

bool V4l2Camera::wait(std::chrono::milliseconds timeout) const {
  return system_.poll(node_->fd(), timeout) != 0;
}

V4l2Answer V4l2Camera::next(V4l2Frame& frame) {
  v4l2_plane plane{};
  v4l2_buffer buffer = buffer_for(0, plane);
  if (!node_->ask(VIDIOC_DQBUF, buffer)) {
    if (errno == EAGAIN) return V4l2Answer::nothing;
    return errno == EIO ? V4l2Answer::error : V4l2Answer::gone;
  }
  if (buffer.index >= mappings_.size()) return V4l2Answer::gone;  // a driver that has lost its count
  const Mapping& mapping = mappings_[buffer.index];
  const std::size_t begin = multiplanar() ? std::min<std::size_t>(plane.data_offset, mapping.bytes) : 0;
  const std::size_t end = std::min<std::size_t>(multiplanar() ? plane.bytesused : buffer.bytesused, mapping.bytes);
  frame.buffer = buffer.index;
  frame.bytes = {static_cast<const std::uint8_t*>(mapping.address) + begin, end > begin ? end - begin : 0};
  frame.sequence = buffer.sequence;
  const auto seconds = buffer.timestamp.tv_sec;
  const bool possible = seconds >= 0 && seconds < kLongestUptime;
  frame.time = possible ? std::chrono::seconds(seconds) + std::chrono::microseconds(buffer.timestamp.tv_usec) : 0ns;
  frame.time_is_monotonic =
      possible && (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  frame.time_is_start = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  frame.damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
  return V4l2Answer::frame;
}

bool V4l2Camera::queue(std::uint32_t index) {
  v4l2_plane plane{};
  v4l2_buffer buffer = buffer_for(index, plane);
  return node_->ask(VIDIOC_QBUF, buffer);
}

bool V4l2Camera::give_back(std::uint32_t buffer) {
  refused_.push_back(buffer);
  std::erase_if(refused_, [this](std::uint32_t index) { return queue(index); });
  return refused_.size() < mappings_.size();
}

}  // namespace rotunda::capture
