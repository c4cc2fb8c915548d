#pragma once
// A trigger box as a USB device of the virtual machine: the firmware's own state machine (firmware/trigger_box) behind
// usb_gadget, its lines written down instead of wired.
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "firmware/trigger_box/trigger_box.h"
#include "tests/vm/usb_gadget.h"

namespace rotunda::vm {

struct LineEdge {
  unsigned line = 0;
  bool high = false;
  std::uint64_t at = 0;  // the edge's moment, ns of the box's clock
};

class TriggerBoxGadget {
 public:
  explicit TriggerBoxGadget(const std::string& serial, unsigned lines = 2);  // plugged in
  ~TriggerBoxGadget();
  TriggerBoxGadget(const TriggerBoxGadget&) = delete;
  TriggerBoxGadget& operator=(const TriggerBoxGadget&) = delete;

  void unplug();
  void plug_in();
  bool configured() const { return gadget_.enabled(); }
  std::vector<LineEdge> edges() const;  // since the train began
  std::uint64_t pulses() const;         // the box's own counter
  bool pulsing() const;

 private:
  static void set_line(void* self, unsigned line, bool high, std::uint64_t at);
  std::uint64_t now() const;
  void obey(const std::stop_token& stop);
  void answer(const std::stop_token& stop);
  void keep_time(const std::stop_token& stop);

  mutable std::mutex mutex_;  // guards box_ and what follows
  std::condition_variable_any changed_;
  trigger_box box_{};
  std::vector<LineEdge> edges_;
  std::deque<std::vector<std::uint8_t>> replies_;
  UsbGadget gadget_;
  std::jthread obey_, answer_, keep_time_;
};

}  // namespace rotunda::vm
