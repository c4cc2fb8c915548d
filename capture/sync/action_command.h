#pragma once
// GigE Vision ACTION_CMD: one datagram that fires every camera whose action keys match, at once or at a time on the
// rig's clock (scheduled action; GigE Vision 2.x, 14.3 and 16.x). All fields are big-endian. Aravis has none.
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/base/unique_fd.h"
#include "capture/frame.h"

namespace rotunda::capture {

inline constexpr std::uint16_t gvcp_port = 3956;

// A camera fires when the device and group keys are its own and group_mask & its mask is not 0.
struct ActionCommand {
  std::uint32_t device_key = 0;
  std::uint32_t group_key = 0;
  std::uint32_t group_mask = 0;
  std::optional<Timestamp> at;  // nothing: when it arrives
};

// 20 bytes, or 28 with a time. Asks for an acknowledgement.
std::vector<std::uint8_t> build_action_command(const ActionCommand& command, std::uint16_t request_id);

enum class ActionStatus : std::uint16_t {
  success = 0x0000,
  not_implemented = 0x8001,
  busy = 0x8007,
  no_reference_time = 0x8013,
  overflow = 0x8015,  // the camera's queue of scheduled actions is full
  late = 0x8016,      // its time had passed when it came
};

struct ActionAck {
  ActionStatus status{};  // any value the camera sent
  std::uint16_t request_id = 0;
};

// Nothing if the datagram is no ACTION_ACK.
std::optional<ActionAck> parse_action_ack(std::span<const std::uint8_t> datagram);

// What one camera has answered, by its address.
struct ActionAckCounts {
  std::uint64_t accepted = 0;
  std::uint64_t late = 0;
  std::uint64_t overflow = 0;
  std::uint64_t no_reference_time = 0;
  std::uint64_t other_errors = 0;
};

struct ActionSenderOptions {
  std::string interface_address;  // IPv4 of the network interface the cameras hang on; "127.0.0.1" for the simulator
  std::string destination = "255.255.255.255";  // broadcast on that interface, or one camera
};

// Sends action commands and counts what the cameras answer. Safe from several threads.
class ActionCommandSender {
 public:
  // Throws InvalidInput if an address is none, std::system_error if the interface address is not of this machine.
  explicit ActionCommandSender(const ActionSenderOptions& options);

  // Counts the answers that have come meanwhile, then sends. Throws std::system_error. Returns the request id.
  std::uint16_t send(const ActionCommand& command);

  // Counts answers until `timeout` has passed or `expected` have come to the last command.
  void collect_acks(std::chrono::milliseconds timeout, std::size_t expected);

  std::uint64_t sent() const;
  std::map<std::string, ActionAckCounts> acks() const;  // by camera address

 private:
  void drain();

  mutable std::mutex mutex_;
  UniqueFd socket_;
  std::string destination_;
  std::uint16_t request_id_ = 0;
  std::uint64_t sent_ = 0;
  std::size_t acks_to_last_ = 0;
  std::map<std::string, ActionAckCounts> acks_;
};

}  // namespace rotunda::capture
