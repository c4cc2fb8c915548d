#pragma once
// One simulated camera's state machine and the datagrams of its clients, for tests without sockets or clocks.
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

#include "simulator/gige/big_endian.h"
#include "simulator/gige/gige_device.h"

namespace rotunda::simulator {

using Bytes = std::vector<std::uint8_t>;
using capture::Timestamp;

inline constexpr Endpoint kOurs{0x7F000001, 40000}, kTheirs{0x7F000001, 40001};
inline constexpr Timestamp kNow{std::chrono::seconds{1'000'000}};

inline Bytes words(std::initializer_list<std::uint32_t> values) {
  Bytes bytes(values.size() * 4);
  std::size_t at = 0;
  for (const auto value : values) store_be(std::span{bytes}, std::exchange(at, at + 4), value);
  return bytes;
}

inline Bytes scheduled(Timestamp at, std::uint32_t device_key = 0, std::uint32_t mask = 1) {
  const auto time = static_cast<std::uint64_t>(at.time_since_epoch().count());
  return words({device_key, 0, mask, static_cast<std::uint32_t>(time >> 32), static_cast<std::uint32_t>(time)});
}

// A camera and the datagrams of its clients.
struct Bench {
  GigeDevice device{GigeCameraOptions{}, PtpStatus::slave, 50000};
  std::uint16_t id = 0;
  Timestamp now = kNow;

  std::optional<Bytes> send(GvcpOpcode opcode, const Bytes& payload, Endpoint from = kOurs,
                            std::uint8_t flags = kAckWanted) {
    return device.handle(gvcp_command(opcode, flags, ++id, payload), from, now);
  }
  std::uint16_t status(const std::optional<Bytes>& acknowledgement) const {
    return acknowledgement ? load_be<std::uint16_t>(*acknowledgement, 0) : 0xFFFF;
  }
  std::uint16_t write(std::uint32_t address, std::uint32_t value, Endpoint from = kOurs) {
    return status(send(GvcpOpcode::write_register, words({address, value}), from));
  }
  std::uint32_t read(std::uint32_t address) {
    const auto acknowledgement = send(GvcpOpcode::read_register, words({address}));
    return load_be<std::uint32_t>(*acknowledgement, kGvcpHeaderBytes);
  }
  std::uint16_t act(const Bytes& payload) {
    return status(send(GvcpOpcode::action, payload, kOurs, kAckWanted | kScheduledAction));
  }
  void arm(TriggerSource source) {
    write(reg::kControlPrivilege, 2);
    write(reg::kDestination, kOurs.address);
    write(reg::kHostPort, 6000);
    write(reg::kTriggerMode, 1);
    write(reg::kTriggerSource, static_cast<std::uint32_t>(source));
    write(reg::kAcquisitionStart, 1);
  }
  std::vector<Timestamp> starts_until(Timestamp end) {
    std::vector<Timestamp> starts;
    while (const auto frame = device.take_due(end)) starts.push_back(frame->exposure_start);
    return starts;
  }
};

}  // namespace rotunda::simulator
