#pragma once
// When which fault of one camera is in force. Pure: times and triggers in, GigeFaults out.
// Triggers are those the camera hears while it is armed for them, and the exposures of a free run; they count from 1
// from the start of serving, whatever becomes of them.
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "capture/frame.h"
#include "simulator/gige/faults.h"

namespace rotunda::simulator {

struct Fault {
  FaultEffect effect;
  // Begins `after` the moment it is added for, or after that trigger.
  std::optional<std::uint64_t> at_trigger;
  std::chrono::nanoseconds after{};
  // Ends that much later, or with the trigger so many triggers later; neither: it stays.
  std::optional<std::chrono::nanoseconds> lasts;
  std::optional<std::uint64_t> triggers;
};

struct FaultEdge {
  FaultKind kind;
  bool begins;  // or ends
  capture::Timestamp at;
};

class FaultSchedule {
 public:
  static constexpr std::size_t kMaxFaults = 1000;  // scheduled or in force at a time

  void set_seed(std::uint64_t seed) { seed_ = seed; }
  // What is wrong all the time, beside what is scheduled. Its seed holds from now on.
  void set_standing(const GigeFaults& faults);
  // Of two faults of one kind the one added last holds, only clock errors add up. False if there are too many already.
  bool add(const Fault& fault, capture::Timestamp from);
  void clear();  // the standing ones too; clocks are right again

  // Numbers a trigger at `at`. Faults that begin or end with it do so at its time.
  std::uint64_t note_trigger(capture::Timestamp at);

  GigeFaults in_force(capture::Timestamp at) const;
  std::vector<FaultKind> kinds_in_force(capture::Timestamp at) const;
  // Camera's clock minus true time.
  std::chrono::nanoseconds clock_error(capture::Timestamp at) const { return in_force(at).clock_error; }
  // The faults that began or ended up to `now` and were not told before, in order of time.
  std::vector<FaultEdge> take_edges(capture::Timestamp now);

 private:
  struct Entry {
    Fault fault;
    std::optional<capture::Timestamp> begin, end;
    std::optional<std::uint64_t> first_trigger;
    bool told_begin = false, told_end = false;

    void begin_at(capture::Timestamp at);
    bool holds(capture::Timestamp at) const { return begin && *begin <= at && (!end || at < *end); }
    bool is_over(capture::Timestamp at) const;
  };

  std::uint64_t seed_ = 1;
  GigeFaults standing_;
  std::vector<Entry> entries_;
  std::uint64_t triggers_ = 0;
};

}  // namespace rotunda::simulator
