#pragma once
// The USB trigger box that pulses the cameras' Line0 (docs/trigger-box.md), through libusb. Its pulses are numbered by
// the box itself and have a time on the rig's clock, through a ClockModel that a thread of its own keeps fitted.
// Safe from several threads. A box that was unplugged stays lost: make a new one when it is back.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "capture/frame.h"
#include "capture/sync/clock_model.h"

namespace rotunda::capture {

struct PulseTrain {
  std::chrono::nanoseconds period = std::chrono::milliseconds(40);
  std::chrono::nanoseconds width = std::chrono::milliseconds(1);
  std::optional<std::uint64_t> count;            // exactly so many; nothing: until stopped
  std::vector<std::chrono::nanoseconds> delays;  // of each line after the pulse's moment; missing ones are 0
  std::uint32_t active_low = 0;                  // bit n: line n rests high
};

// A pulse the box has begun.
struct Pulse {
  std::uint64_t number = 0;         // from 0 since start()
  Timestamp time;                   // its moment on the rig's clock
  std::chrono::nanoseconds late{};  // by which its first edge left late, told by the box
};

struct TriggerBoxStatus {
  bool running = false;           // or scheduled
  bool lost = false;              // unplugged, or it stopped answering
  std::uint64_t pulses = 0;       // begun since start(), counted by the box
  std::uint64_t events_lost = 0;  // pulses of which only the counter told
  double drift_ppm = 0.0;         // how much faster its clock runs than the rig's
  std::chrono::nanoseconds clock_error{};
};

struct FoundTriggerBox {
  std::string serial;
  std::string port;  // "1-4": USB bus and port
};
// Boxes on this machine's USB. Throws DeviceError if USB cannot be used at all.
std::vector<FoundTriggerBox> find_trigger_boxes();

class TriggerBoxUsb;

class TriggerBox {
 public:
  using PulseSink = std::function<void(const Pulse&)>;  // on the box's thread; must only pass things on

  // Opens the box of this serial number, or the only one if it is empty; a train that ran is stopped. Throws
  // DeviceError: none, more than one, no permission, another protocol, no answer.
  explicit TriggerBox(const std::string& serial = {}, PulseSink sink = {});
  ~TriggerBox();  // stops the train
  TriggerBox(const TriggerBox&) = delete;
  TriggerBox& operator=(const TriggerBox&) = delete;

  int lines() const { return lines_; }
  const std::string& serial() const { return serial_; }

  // Each throws DeviceError when the box is lost, does not answer within a second, or says no and why.
  PulseTrain set(const PulseTrain& train);  // only while no train runs; returns what it really is, in the box's steps
  Timestamp start(Timestamp at);            // pulse 0's moment; returns what it really is
  std::uint64_t stop();                     // returns the pulses begun
  TriggerBoxStatus status() const;          // as last told, a quarter second ago at most; never waits
  bool lost() const { return lost_; }

  // Once ready (from the start): the fitted clock.
  ClockModel clock() const;

 private:
  struct Reply {
    std::uint8_t status = 0, state = 0;
    std::uint32_t value32 = 0;
    DeviceTime time{};
    std::uint64_t pulses = 0, value64 = 0;
  };
  struct Request {
    std::uint8_t opcode = 0;
    std::uint16_t line = 0;
    std::uint32_t value32 = 0;
    std::uint64_t value64 = 0;
  };

  Reply ask(const Request& request);      // whatever the box answers
  Reply command(const Request& request);  // throws unless it says yes
  void listen(std::stop_token stop);
  void read_clock();
  void take_message(const std::uint8_t* message, Timestamp arrived);
  void take_pulse(const Reply& event);
  void lose(const std::string& why);
  [[noreturn]] void refuse(const Request& request, const Reply& reply) const;

  std::unique_ptr<TriggerBoxUsb> usb_;
  std::string serial_;
  PulseSink sink_;
  int lines_ = 0;
  std::atomic<bool> lost_{false};

  std::mutex command_mutex_;  // one command at a time
  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable answered_;
  std::string why_lost_;
  std::uint8_t tag_ = 0;
  std::optional<Reply> reply_;
  std::optional<Timestamp> clock_asked_;
  ClockModel clock_;
  TriggerBoxStatus known_;
  std::jthread thread_;  // last: starts when everything else is there
};

}  // namespace rotunda::capture
