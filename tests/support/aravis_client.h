#pragma once
// Unmodified Aravis as the simulated cameras' client, and a sender of GigE Vision actions (which Aravis has not).
extern "C" {
#include <arv.h>
}
#include <arpa/inet.h>
#include <sys/socket.h>

#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "capture/frame.h"
#include "simulator/gige/big_endian.h"
#include "simulator/gige/gvcp.h"
#include "simulator/gige/udp_socket.h"

namespace rotunda::tests {

struct Unreference {
  void operator()(gpointer object) const noexcept { g_object_unref(object); }
};

// Throws what Aravis says.
class AravisError {
 public:
  AravisError() = default;
  AravisError(const AravisError&) = delete;
  AravisError& operator=(const AravisError&) = delete;
  ~AravisError() { g_clear_error(&error_); }
  operator GError**() { return &error_; }
  void check(const std::string& what) {
    if (error_ != nullptr) throw std::runtime_error(what + ": " + error_->message);
  }

 private:
  GError* error_ = nullptr;
};

struct ReceivedFrame {
  ArvBufferStatus status{};
  std::uint64_t block = 0;
  capture::Timestamp exposure_start;
  std::vector<std::uint8_t> pixels;
};

class AravisClient {
 public:
  // Opens the camera as it is.
  explicit AravisClient(const std::string& address) {
    AravisError error;
    camera_.reset(arv_camera_new(address.c_str(), error));
    error.check("open " + address);
  }
  // Opens it as its controller and says how to stream.
  AravisClient(const std::string& address, int packet_size) : AravisClient(address) {
    AravisError error;
    arv_camera_gv_set_packet_size_adjustment(camera(), ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
    arv_camera_gv_set_stream_options(camera(), ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
    arv_camera_gv_set_packet_size(camera(), packet_size, error);
    error.check("packet size");
  }
  ~AravisClient() {
    stream_.reset();
    camera_.reset();
  }

  bool is_controller() const { return arv_gv_device_is_controller(ARV_GV_DEVICE(device())); }

  ArvCamera* camera() const { return ARV_CAMERA(camera_.get()); }
  ArvDevice* device() const { return arv_camera_get_device(camera()); }
  ArvStream* stream() const { return ARV_STREAM(stream_.get()); }

  void set(const char* feature, const char* value) {
    AravisError error;
    arv_camera_set_string(camera(), feature, value, error);
    error.check(feature);
  }
  void set_float(const char* feature, double value) {
    AravisError error;
    arv_camera_set_float(camera(), feature, value, error);
    error.check(feature);
  }
  void set_integer(const char* feature, std::int64_t value) {
    AravisError error;
    arv_camera_set_integer(camera(), feature, value, error);
    error.check(feature);
  }
  std::string text(const char* feature) {
    AravisError error;
    const char* value = arv_camera_get_string(camera(), feature, error);
    error.check(feature);
    return value;
  }
  double real(const char* feature) {
    AravisError error;
    const double value = arv_camera_get_float(camera(), feature, error);
    error.check(feature);
    return value;
  }
  std::int64_t integer(const char* feature) {
    AravisError error;
    const auto value = arv_camera_get_integer(camera(), feature, error);
    error.check(feature);
    return value;
  }
  void execute(const char* command) {
    AravisError error;
    arv_camera_execute_command(camera(), command, error);
    error.check(command);
  }

  void trigger_by(const char* source) {
    set("TriggerSelector", "FrameStart");
    set("TriggerSource", source);
    set("TriggerMode", "On");
  }

  struct StreamOptions {
    std::chrono::microseconds frame_retention{200'000};  // Aravis gives a frame up after that
    int buffers = 10;
  };

  // The stream's socket may hold a few frames, the first included, so that a busy machine loses none.
  void start() { start(StreamOptions{}); }
  void start(const StreamOptions& options) {
    AravisError error;
    stream_.reset(arv_camera_create_stream(camera(), nullptr, nullptr, error));
    error.check("create stream");
    g_object_set(stream(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size", 4 << 20,
                 "frame-retention", static_cast<guint>(options.frame_retention.count()), nullptr);
    enlarge_socket_buffer();
    const auto bytes = arv_camera_get_payload(camera(), error);
    error.check("payload");
    for (int i = 0; i < options.buffers; ++i) arv_stream_push_buffer(stream(), arv_buffer_new(bytes, nullptr));
    arv_camera_start_acquisition(camera(), error);
    error.check("start");
  }
  void stop() {
    AravisError error;
    arv_camera_stop_acquisition(camera(), error);
    error.check("stop");
  }

  // Waits as long as a loaded machine may need; nothing if no frame comes.
  std::optional<ReceivedFrame> next_frame(std::chrono::microseconds patience = std::chrono::seconds{10}) {
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream(), static_cast<guint64>(patience.count()));
    if (buffer == nullptr) return std::nullopt;
    std::size_t size = 0;
    const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, &size));
    ReceivedFrame frame{
        .status = arv_buffer_get_status(buffer),
        .block = arv_buffer_get_frame_id(buffer),
        .exposure_start =
            capture::Timestamp{std::chrono::nanoseconds{static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer))}},
        .pixels = {data, data + size}};
    arv_stream_push_buffer(stream(), buffer);
    return frame;
  }

 private:
  // Aravis sets the buffer's size when the first packet is there, too late for the rest of the first frame.
  void enlarge_socket_buffer() {
    const auto port = arv_gv_stream_get_port(ARV_GV_STREAM(stream()));
    for (int fd = 3; fd < 1024; ++fd) {
      sockaddr_in local{};
      socklen_t size = sizeof local;
      if (getsockname(fd, reinterpret_cast<sockaddr*>(&local), &size) != 0 || ntohs(local.sin_port) != port) continue;
      const int bytes = 4 << 20;
      setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
    }
  }

  std::unique_ptr<void, Unreference> camera_, stream_;
};

// What a shell command prints.
inline std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::array<char, 512> buffer{};
  while (fgets(buffer.data(), buffer.size(), pipe) != nullptr) output += buffer.data();
  pclose(pipe);
  return output;
}

// Broadcasts ACTION_CMD on the loopback with the cameras' power-up keys and collects the acknowledgements.
class ActionSender {
 public:
  ActionSender() : socket_({.address = INADDR_LOOPBACK, .port = 0}) {
    const int on = 1;
    setsockopt(socket_.fd(), SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
  }

  // The status of each acknowledgement. Without a time: at once. Waits for `expected` of them, at most ten seconds.
  std::vector<std::uint16_t> send(std::optional<capture::Timestamp> at, std::size_t expected = 10,
                                  std::uint32_t device_key = 0, std::uint32_t group_mask = 1) {
    using simulator::store_be;
    std::vector<std::uint8_t> payload(at ? 20 : 12);
    const std::span<std::uint8_t> fields{payload};
    store_be(fields, 0, device_key);
    store_be(fields, 8, group_mask);
    if (at) store_be(fields, 12, static_cast<std::uint64_t>(at->time_since_epoch().count()));
    const auto flags = static_cast<std::uint8_t>(simulator::kAckWanted | (at ? simulator::kScheduledAction : 0));
    socket_.send(simulator::gvcp_command(simulator::GvcpOpcode::action, flags, ++id_, payload),
                 {.address = INADDR_BROADCAST, .port = simulator::kGvcpPort});
    return acknowledgements(expected);
  }

 private:
  std::vector<std::uint16_t> acknowledgements(std::size_t expected) {
    std::vector<std::uint16_t> all;
    std::array<std::uint8_t, 64> buffer{};
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{10};
    while (all.size() < expected && std::chrono::steady_clock::now() < deadline) {
      if (const auto received = socket_.receive(buffer))
        all.push_back(simulator::load_be<std::uint16_t>(std::span<const std::uint8_t>{buffer}, 0));
      else
        std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
    return all;
  }

  simulator::UdpSocket socket_;
  std::uint16_t id_ = 0;
};

}  // namespace rotunda::tests
