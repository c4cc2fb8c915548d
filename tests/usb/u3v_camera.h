#pragma once
// A USB3 Vision camera without its USB: descriptors, control protocol (GenCP), registers with their GenICam
// description, and the stream packets of its frames, which count from 0 since the acquisition started. USB3
// Vision 1.0.1 and GenCP 1.1; all numbers little-endian but the camera's own registers, which its description declares
// big-endian. Safe from several threads.
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace rotunda::tests {

using Bytes = std::vector<std::uint8_t>;

struct U3vCameraOptions {
  std::string serial = "U3V0001";
  int width = 64, height = 48;  // until a client asks for less
};

class U3vCamera {
 public:
  static constexpr std::uint8_t kControlOut = 0x01, kControlIn = 0x81, kStreamIn = 0x82;  // endpoints
  static constexpr std::uint16_t kVendor = 0x1209, kProduct = 0x7475;

  explicit U3vCamera(const U3vCameraOptions& options = {});

  void power_up();  // anew, with nothing left of what was before

  Bytes device_descriptor() const;
  Bytes configuration(std::uint16_t packet_bytes) const;  // with its interfaces, class descriptors and endpoints
  Bytes string_descriptor(unsigned number) const;         // empty: there is none

  // The acknowledge of a command; empty for what is no command.
  Bytes answer(std::span<const std::uint8_t> command);

  // The next frame's transfers (leader, payload in the sizes the host asked for, trailer) once it is due; nothing if it
  // is not, or the host has not asked for any.
  std::vector<Bytes> next_frame();
  bool stream_enabled() const;  // if not, what was not fetched is thrown away

  // What a frame shows.
  static std::uint8_t pixel(std::uint64_t frame_id, int x, int y) {
    return static_cast<std::uint8_t>(7 * frame_id + static_cast<unsigned>(x) + 3U * static_cast<unsigned>(y));
  }

 private:
  struct Answer {
    std::uint16_t status = 0;
    Bytes data;
  };
  Answer obey(std::uint16_t opcode, std::span<const std::uint8_t> operands);
  Answer read(std::uint64_t address, std::size_t bytes) const;
  Answer write(std::uint64_t address, std::span<const std::uint8_t> bytes);
  void put(std::uint64_t address, std::uint64_t value, std::size_t bytes);
  std::uint64_t get(std::uint64_t address, std::size_t bytes) const;
  void put_text(std::uint64_t address, const std::string& text);
  std::uint32_t camera_register(std::uint32_t address) const;
  void set_camera_register(std::uint32_t address, std::uint32_t value);
  void describe_itself();
  bool fits(std::uint64_t address, std::size_t bytes) const;
  void written(std::uint64_t address);
  bool due();
  Bytes leader() const;
  Bytes trailer(std::size_t payload) const;

  U3vCameraOptions options_;
  mutable std::mutex mutex_;  // guards what follows
  Bytes memory_;
  bool acquiring_ = false;
  bool triggered_ = false;
  std::uint64_t frames_ = 0;  // sent since the acquisition started
  std::chrono::steady_clock::time_point next_;
};

}  // namespace rotunda::tests
