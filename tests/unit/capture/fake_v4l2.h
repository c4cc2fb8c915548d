#pragma once
// V4L2 devices that exist in memory only: the system calls as the kernel's documentation has them, odd drivers on
// demand, a clock that stands until it is set. A test fills frames; poll() wakes as the kernel's does.
#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "capture/source/v4l2_system.h"

namespace rotunda::capture::test {

struct FakeControl {
  std::uint32_t id = 0;
  std::string name;
  std::uint32_t type = V4L2_CTRL_TYPE_INTEGER;
  std::int32_t minimum = 0, maximum = 255, value = 0;
  std::vector<std::string> menu;  // by index; empty: no such row
  bool read_only = false;
};

struct FakeFrame {
  std::vector<std::uint8_t> bytes;
  std::uint32_t sequence = 0;
  std::chrono::nanoseconds time{};
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
};

// What one driver is like.
struct FakeDriver {
  std::string card = "Fake Camera", bus = "usb-0000:00:14.0-1", serial;
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<std::uint32_t> formats{V4L2_PIX_FMT_YUYV};
  std::uint32_t width = 16, height = 8;  // the only size
  std::uint32_t padding = 0;             // bytes after each row
  std::uint32_t stored_bits = 16;        // of a pixel
  std::uint32_t field = V4L2_FIELD_NONE;
  std::uint32_t colorspace = V4L2_COLORSPACE_SRGB, ycbcr = 0, quantization = 0;
  std::vector<std::uint32_t> rates{25, 30};  // empty: ENOTTY
  std::uint32_t most_buffers = 32;           // more are ENOMEM
  std::vector<FakeControl> controls;
  bool old_control_calls = false;         // ENOTTY for the extended ones
  std::map<unsigned long, int> refusals;  // request -> errno, as long as it stands here
  int open_error = 0;
};

class FakeV4l2 final : public V4l2System {
 public:
  explicit FakeV4l2(std::vector<FakeDriver> drivers) {
    for (auto& driver : drivers) devices_.push_back({std::move(driver)});
  }

  // What the test does.
  FakeDriver& driver(std::size_t device = 0) { return devices_[device].driver; }
  void refuse(unsigned long request, int error) {
    const std::lock_guard lock(mutex_);
    if (error == 0)
      devices_[0].driver.refusals.erase(request);
    else
      devices_[0].driver.refusals[request] = error;
    changed_.notify_all();
  }
  // False: no buffer was queued, the frame is lost as it would be.
  bool send(FakeFrame frame, std::size_t index = 0) {
    const std::lock_guard lock(mutex_);
    auto& device = devices_[index];
    if (!device.streaming || device.queued.empty()) return false;
    const auto buffer = device.queued.front();
    device.queued.pop_front();
    std::copy(frame.bytes.begin(), frame.bytes.end(), device.memory[buffer].begin());
    device.done.emplace_back(buffer, std::move(frame));
    changed_.notify_all();
    return true;
  }
  void unplug() {
    const std::lock_guard lock(mutex_);
    devices_[0].unplugged = true;
    changed_.notify_all();
  }
  void plug_in() {
    const std::lock_guard lock(mutex_);
    devices_[0].unplugged = false;
  }
  void set_time(std::chrono::nanoseconds monotonic, Timestamp rig) {
    const std::lock_guard lock(mutex_);
    monotonic_ = monotonic;
    rig_ = rig;
  }
  int open_nodes() const {
    const std::lock_guard lock(mutex_);
    return open_;
  }
  int mapped() const {
    const std::lock_guard lock(mutex_);
    return mapped_;
  }
  std::int32_t control(const std::string& name) {
    const std::lock_guard lock(mutex_);
    for (const auto& control : devices_[0].driver.controls)
      if (control.name == name) return control.value;
    return -1;
  }

  // What the source sees. A device's descriptor is its number.
  int open(const std::string& path) override {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < devices_.size(); ++i) {
      if (path != node(i)) continue;
      if (devices_[i].unplugged) return fail(ENODEV);
      if (devices_[i].driver.open_error != 0) return fail(devices_[i].driver.open_error);
      ++open_;
      return static_cast<int>(i);
    }
    return fail(ENOENT);
  }
  void close(int fd) override {
    const std::lock_guard lock(mutex_);
    --open_;
    devices_[static_cast<std::size_t>(fd)].streaming = false;
  }
  int ioctl(int fd, unsigned long request, void* argument) override {
    const std::lock_guard lock(mutex_);
    auto& device = devices_[static_cast<std::size_t>(fd)];
    if (device.unplugged) return fail(ENODEV);
    if (const auto refusal = device.driver.refusals.find(request); refusal != device.driver.refusals.end())
      return fail(refusal->second);
    return answer(device, request, argument);
  }
  void* map(int fd, std::size_t bytes, std::int64_t offset) override {
    const std::lock_guard lock(mutex_);
    auto& memory = devices_[static_cast<std::size_t>(fd)].memory;
    const auto index = static_cast<std::size_t>(offset / kOffset);
    if (index >= memory.size() || bytes > memory[index].size()) return errno = EINVAL, nullptr;
    ++mapped_;
    return memory[index].data();
  }
  void unmap(void*, std::size_t) override {
    const std::lock_guard lock(mutex_);
    --mapped_;
  }
  int poll(int fd, std::chrono::milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    auto& device = devices_[static_cast<std::size_t>(fd)];
    const auto trouble = [&] {
      return device.unplugged || !device.streaming || device.driver.refusals.count(VIDIOC_DQBUF);
    };
    changed_.wait_for(lock, timeout, [&] { return trouble() || !device.done.empty(); });
    if (device.unplugged) return POLLERR | POLLHUP;
    if (trouble()) return POLLERR;
    return device.done.empty() ? 0 : POLLIN;
  }
  std::chrono::nanoseconds monotonic_now() override {
    const std::lock_guard lock(mutex_);
    return monotonic_;
  }
  Timestamp rig_now() override {
    const std::lock_guard lock(mutex_);
    return rig_;
  }
  std::vector<std::string> nodes() override {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < devices_.size(); ++i) names.push_back(node(i));
    return names;
  }
  std::string serial_of(const std::string& path) override {
    for (std::size_t i = 0; i < devices_.size(); ++i)
      if (path == node(i)) return devices_[i].driver.serial;
    return "";
  }

 private:
  static constexpr std::int64_t kOffset = 4096;

  struct Device {
    FakeDriver driver;
    std::uint32_t fourcc = 0;
    bool streaming = false, unplugged = false;
    std::vector<std::vector<std::uint8_t>> memory;
    std::deque<std::uint32_t> queued;
    std::deque<std::pair<std::uint32_t, FakeFrame>> done;
  };

  static std::string node(std::size_t i) { return "/dev/video" + std::to_string(i); }
  static int fail(int error) { return errno = error, -1; }
  static std::uint32_t row_bytes(const FakeDriver& d) {
    return (d.formats.front() == V4L2_PIX_FMT_NV12 ? d.width : d.width * d.stored_bits / 8) + d.padding;
  }
  static std::uint32_t image_size(const FakeDriver& d) {
    return row_bytes(d) * (d.formats.front() == V4L2_PIX_FMT_NV12 ? d.height * 3 / 2 : d.height);
  }

  int answer(Device& device, unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCAP:
        return tell_capability(device, *static_cast<v4l2_capability*>(argument));
      case VIDIOC_ENUM_FMT:
        return enumerate_format(device, *static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_G_FMT:
      case VIDIOC_S_FMT:
        return agree_format(device, *static_cast<v4l2_format*>(argument), request == VIDIOC_S_FMT);
      case VIDIOC_S_PARM:
        return set_rate(device, *static_cast<v4l2_streamparm*>(argument));
      case VIDIOC_ENUM_FRAMEINTERVALS:
        return enumerate_rate(device, *static_cast<v4l2_frmivalenum*>(argument));
      case VIDIOC_REQBUFS:
        return request_buffers(device, *static_cast<v4l2_requestbuffers*>(argument));
      case VIDIOC_QUERYBUF:
        return query_buffer(device, *static_cast<v4l2_buffer*>(argument));
      case VIDIOC_QBUF:
        return queue(device, *static_cast<v4l2_buffer*>(argument));
      case VIDIOC_DQBUF:
        return dequeue(device, *static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        return device.streaming = true, 0;
      case VIDIOC_STREAMOFF:
        device.streaming = false;
        device.queued.clear();
        device.done.clear();
        changed_.notify_all();
        return 0;
      default:
        return answer_control(device.driver, request, argument);
    }
  }

  static int tell_capability(const Device& device, v4l2_capability& told) {
    std::strncpy(reinterpret_cast<char*>(told.driver), "fake", sizeof told.driver);
    std::strncpy(reinterpret_cast<char*>(told.card), device.driver.card.c_str(), sizeof told.card - 1);
    std::strncpy(reinterpret_cast<char*>(told.bus_info), device.driver.bus.c_str(), sizeof told.bus_info - 1);
    told.device_caps = device.driver.capabilities;
    told.capabilities = told.device_caps | V4L2_CAP_DEVICE_CAPS;
    return 0;
  }
  static int enumerate_format(const Device& device, v4l2_fmtdesc& told) {
    if (told.index >= device.driver.formats.size()) return fail(EINVAL);
    told.pixelformat = device.driver.formats[told.index];
    return 0;
  }
  static int agree_format(Device& device, v4l2_format& format, bool set) {
    const auto& d = device.driver;
    const auto has = [&](std::uint32_t fourcc) {
      return std::find(d.formats.begin(), d.formats.end(), fourcc) != d.formats.end();
    };
    if (set || device.fourcc == 0)
      device.fourcc = has(format.fmt.pix.pixelformat) ? format.fmt.pix.pixelformat : d.formats.front();
    auto& pix = format.fmt.pix;
    pix = {};
    pix.width = d.width;
    pix.height = d.height;
    pix.pixelformat = device.fourcc;
    pix.field = d.field;
    pix.bytesperline = device.fourcc == V4L2_PIX_FMT_MJPEG ? 0 : row_bytes(d);
    pix.sizeimage = image_size(d);
    pix.colorspace = d.colorspace;
    pix.ycbcr_enc = d.ycbcr;
    pix.quantization = d.quantization;
    return 0;
  }
  static int set_rate(const Device& device, v4l2_streamparm& parameters) {
    const auto& rates = device.driver.rates;
    if (rates.empty()) return fail(ENOTTY);
    auto& interval = parameters.parm.capture.timeperframe;
    const double wanted = double{1} * interval.denominator / interval.numerator;
    const auto nearest = std::min_element(rates.begin(), rates.end(),
                                          [&](auto a, auto b) { return std::abs(a - wanted) < std::abs(b - wanted); });
    interval = {1, *nearest};
    return 0;
  }
  static int enumerate_rate(const Device& device, v4l2_frmivalenum& told) {
    if (told.index >= device.driver.rates.size()) return fail(EINVAL);
    told.type = V4L2_FRMIVAL_TYPE_DISCRETE;
    told.discrete = {1, device.driver.rates[told.index]};
    return 0;
  }
  static int request_buffers(Device& device, v4l2_requestbuffers& request) {
    if (request.count > device.driver.most_buffers) return fail(ENOMEM);
    device.memory.assign(request.count, std::vector<std::uint8_t>(image_size(device.driver)));
    device.queued.clear();
    device.done.clear();
    return 0;
  }
  static int query_buffer(const Device& device, v4l2_buffer& buffer) {
    if (buffer.index >= device.memory.size()) return fail(EINVAL);
    buffer.length = static_cast<std::uint32_t>(device.memory[buffer.index].size());
    buffer.m.offset = static_cast<std::uint32_t>(buffer.index * kOffset);
    return 0;
  }
  static int queue(Device& device, const v4l2_buffer& buffer) {
    if (std::find(device.queued.begin(), device.queued.end(), buffer.index) != device.queued.end()) return fail(EINVAL);
    device.queued.push_back(buffer.index);
    return 0;
  }
  static int dequeue(Device& device, v4l2_buffer& buffer) {
    if (!device.streaming) return fail(EINVAL);
    if (device.done.empty()) return fail(EAGAIN);
    const auto [index, frame] = std::move(device.done.front());
    device.done.pop_front();
    buffer.index = index;
    buffer.bytesused = static_cast<std::uint32_t>(frame.bytes.size());
    buffer.sequence = frame.sequence;
    buffer.flags = frame.flags;
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(frame.time).count();
    buffer.timestamp.tv_sec = us / 1'000'000;
    buffer.timestamp.tv_usec = us % 1'000'000;
    return 0;
  }

  static FakeControl* find(FakeDriver& driver, std::uint32_t id) {
    for (auto& control : driver.controls)
      if (control.id == id) return &control;
    return nullptr;
  }
  // The wanted one, or the first above it where the next is asked for.
  static FakeControl* asked_for(FakeDriver& driver, std::uint32_t id) {
    if ((id & V4L2_CTRL_FLAG_NEXT_CTRL) == 0) return find(driver, id);
    FakeControl* next = nullptr;
    for (auto& control : driver.controls)
      if (control.id > (id & V4L2_CTRL_ID_MASK) && (next == nullptr || control.id < next->id)) next = &control;
    return next;
  }
  template <class Query>
  static int tell_control(FakeDriver& driver, Query& told) {
    const FakeControl* control = asked_for(driver, told.id);
    if (control == nullptr) return fail(EINVAL);
    told = {};
    told.id = control->id;
    told.type = control->type;
    std::memcpy(told.name, control->name.c_str(), std::min(control->name.size(), sizeof told.name - 1));
    told.minimum = control->minimum;
    told.maximum = control->maximum;
    return 0;
  }
  static int write(FakeDriver& driver, std::uint32_t id, std::int32_t value) {
    FakeControl* control = find(driver, id);
    if (control == nullptr) return fail(EINVAL);
    if (control->read_only) return fail(EACCES);
    control->value = std::clamp(value, control->minimum, control->maximum);  // as the kernel's framework does
    return 0;
  }
  static int answer_control(FakeDriver& driver, unsigned long request, void* argument) {
    const bool extended =
        request == VIDIOC_QUERY_EXT_CTRL || request == VIDIOC_G_EXT_CTRLS || request == VIDIOC_S_EXT_CTRLS;
    if (extended && driver.old_control_calls) return fail(ENOTTY);
    if (request == VIDIOC_QUERY_EXT_CTRL) return tell_control(driver, *static_cast<v4l2_query_ext_ctrl*>(argument));
    if (request == VIDIOC_QUERYCTRL) return tell_control(driver, *static_cast<v4l2_queryctrl*>(argument));
    if (request == VIDIOC_QUERYMENU) {
      auto& item = *static_cast<v4l2_querymenu*>(argument);
      const FakeControl* control = find(driver, item.id);
      if (control == nullptr || item.index >= control->menu.size() || control->menu[item.index].empty())
        return fail(EINVAL);
      std::strncpy(reinterpret_cast<char*>(item.name), control->menu[item.index].c_str(), sizeof item.name - 1);
      return 0;
    }
    if (extended) {
      auto& value = *static_cast<v4l2_ext_controls*>(argument)->controls;
      if (request == VIDIOC_S_EXT_CTRLS) return write(driver, value.id, value.value);
      const FakeControl* control = find(driver, value.id);
      return control == nullptr ? fail(EINVAL) : (value.value = control->value, 0);
    }
    if (request == VIDIOC_G_CTRL || request == VIDIOC_S_CTRL) {
      auto& value = *static_cast<v4l2_control*>(argument);
      if (request == VIDIOC_S_CTRL) return write(driver, value.id, value.value);
      const FakeControl* control = find(driver, value.id);
      return control == nullptr ? fail(EINVAL) : (value.value = control->value, 0);
    }
    return fail(ENOTTY);
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Device> devices_;
  std::chrono::nanoseconds monotonic_ = std::chrono::seconds(1000);
  Timestamp rig_{std::chrono::seconds(1'763'000'000)};
  int open_ = 0;
  int mapped_ = 0;
};

}  // namespace rotunda::capture::test
