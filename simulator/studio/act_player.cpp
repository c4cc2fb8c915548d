#include "simulator/studio/act_player.h"

#include <spdlog/spdlog.h>
#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "config/errors.h"
#include "simulator/people/performance.h"

namespace rotunda::simulator {
namespace {

using namespace std::chrono_literals;

class HeldAct : public ActPlayer {
 public:
  explicit HeldAct(std::vector<PictureSet> frames) : frames_(std::move(frames)) {
    if (frames_.empty()) throw InvalidInput("an act to play needs frames");
  }
  std::span<const std::uint8_t> picture_at(std::size_t camera, capture::Timestamp exposure_start) override {
    const int frame = act_frame_at(exposure_start, static_cast<int>(frames_.size()));
    return frames_[static_cast<std::size_t>(frame)].at(camera);
  }
  int frames() const override { return static_cast<int>(frames_.size()); }
  PlayerCounts counts() const override { return {}; }

 private:
  std::vector<PictureSet> frames_;
};

constexpr std::size_t kLent = 9;  // pictures a camera may still be sending: eight, and the one asked for
constexpr std::size_t kFewestAhead = 8, kMostAhead = 64;  // pictures read before they are asked for
constexpr std::uint64_t kMemory = 240'000'000;            // bytes of all slots, if that is enough for the fewest
constexpr std::size_t kAnnounced = 12;                    // frames beyond, for the kernel to fetch meanwhile
constexpr auto kTellEvery = 1s;

// As far as memory goes: a disk that stalls is forgiven for so many periods.
std::size_t ahead_for(const EntryShape& shape) {
  std::uint64_t set = 1;
  for (const auto bytes : shape.picture_bytes) set += bytes;
  const std::size_t slots = kMemory / set;
  return std::clamp(slots, kLent + 2 + kFewestAhead, kLent + 2 + kMostAhead) - kLent - 2;
}

struct Slot {
  std::vector<std::uint8_t> pixels;
  int frame = -1;           // -1: nothing of use
  bool is_loading = false;  // somebody writes it outside the mutex
  int lent = 0;             // how often it is among the camera's lent ones
};

class StreamedCamera {
 public:
  StreamedCamera(std::uint64_t picture_bytes, int frames, std::size_t ahead)
      : frames_(frames), ahead_(ahead), slots_(kLent + ahead + 2) {
    for (auto& slot : slots_) slot.pixels.reserve(picture_bytes);  // touched when first read into
    picture_bytes_ = picture_bytes;
  }

  // Notes that `frame` is wanted now; true if that was foreseen.
  bool expect_from(int frame) {
    const bool foreseen = last_ >= 0 && frame == (last_ + stride_) % frames_;
    if (last_ >= 0 && frame != last_) stride_ = (frame - last_ + frames_) % frames_;
    last_ = frame;
    return foreseen;
  }

  Slot* find(int frame) {
    const auto slot = std::find_if(slots_.begin(), slots_.end(), [&](const Slot& s) { return s.frame == frame; });
    return slot == slots_.end() ? nullptr : &*slot;
  }

  // Which frame comes `steps` after the last.
  int foreseen(std::size_t steps) const {
    return static_cast<int>((last_ + static_cast<std::int64_t>(steps) * stride_) % frames_);
  }
  bool is_asked_for() const { return last_ >= 0; }

  // A slot to load into: not lent, not being loaded, not what comes next. There are enough of them.
  Slot& free_slot() {
    const auto is_free = [&](const Slot& slot) {
      if (slot.lent > 0 || slot.is_loading) return false;
      for (std::size_t k = 0; k <= ahead_ && slot.frame >= 0; ++k)
        if (slot.frame == foreseen(k)) return false;
      return true;
    };
    Slot& slot = *std::find_if(slots_.begin(), slots_.end(), is_free);
    slot.pixels.resize(picture_bytes_);
    return slot;
  }

  void lend(Slot& slot) {
    ++slot.lent;
    lent_.push_back(&slot);
    if (lent_.size() <= kLent) return;
    --lent_.front()->lent;
    lent_.pop_front();
  }

 private:
  int frames_;
  std::uint64_t picture_bytes_ = 0;
  std::size_t ahead_;
  std::vector<Slot> slots_;
  std::deque<Slot*> lent_;  // oldest first
  int last_ = -1, stride_ = 1;
};

class StreamedAct : public ActPlayer {
 public:
  explicit StreamedAct(CacheEntry entry) : entry_(std::move(entry)), ahead_(ahead_for(entry_.shape())) {
    if (entry_.shape().frames <= 0) throw InvalidInput("an act to play needs frames");
    for (const auto bytes : entry_.shape().picture_bytes) cameras_.emplace_back(bytes, entry_.shape().frames, ahead_);
    prefetch_ = std::jthread([this](const std::stop_token& stop) { prefetch_loop(stop); });
  }

  std::span<const std::uint8_t> picture_at(std::size_t number, capture::Timestamp exposure_start) override {
    const int frame = act_frame_at(exposure_start, entry_.shape().frames);
    std::unique_lock lock(mutex_);
    auto& camera = cameras_.at(number);
    const bool foreseen = camera.expect_from(frame);
    loaded_.wait(lock, [&] {  // rather than read it twice
      const Slot* slot = camera.find(frame);
      return slot == nullptr || !slot->is_loading;
    });
    Slot* slot = camera.find(frame);
    if (slot == nullptr) {
      ++(foreseen ? counts_.late : counts_.unexpected);
      slot = &camera.free_slot();
      if (!load(*slot, frame, number, lock)) {
        ++counts_.damaged;
        return {};
      }
    }
    camera.lend(*slot);
    has_errand_ = true;
    lock.unlock();
    wake_.notify_one();
    return slot->pixels;
  }

  int frames() const override { return entry_.shape().frames; }
  PlayerCounts counts() const override {
    const std::scoped_lock lock(mutex_);
    return counts_;
  }

 private:
  // Reads outside the mutex; false if the picture is not to be had.
  bool load(Slot& slot, int frame, std::size_t camera, std::unique_lock<std::mutex>& lock) {
    slot.frame = frame;
    slot.is_loading = true;
    lock.unlock();
    bool is_read = false;
    try {
      is_read = entry_.read(frame, camera, slot.pixels);
    } catch (const std::exception& error) {
      spdlog::error("frame cache: {}", error.what());
    }
    lock.lock();
    slot.is_loading = false;
    if (!is_read) slot.frame = -1;
    loaded_.notify_all();
    return is_read;
  }

  void prefetch_loop(const std::stop_token& stop) {
    prctl(PR_SET_NAME, "prefetch");
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      wake_.wait(lock, stop, [this] { return has_errand_; });
      has_errand_ = false;
      announce(lock);
      for (std::size_t steps = 1; steps <= ahead_ && !stop.stop_requested(); ++steps)  // what is due first, first
        for (std::size_t camera = 0; camera < cameras_.size(); ++camera) read_ahead(camera, steps, lock);
      tell(lock);
    }
  }

  // All cameras of a frame lie in one file, and cameras of one trigger go through the act alike.
  void announce(std::unique_lock<std::mutex>& lock) {
    const auto camera = std::find_if(cameras_.begin(), cameras_.end(), [](const auto& c) { return c.is_asked_for(); });
    if (camera == cameras_.end()) return;
    std::vector<int> coming;
    for (std::size_t steps = 1; steps <= ahead_ + kAnnounced; ++steps) {
      const int frame = camera->foreseen(steps);
      if (std::find(announced_.begin(), announced_.end(), frame) == announced_.end()) coming.push_back(frame);
    }
    lock.unlock();
    for (const int frame : coming) entry_.announce(frame);
    lock.lock();
    announced_.insert(announced_.end(), coming.begin(), coming.end());
    while (announced_.size() > ahead_ + 2 * kAnnounced) announced_.pop_front();
  }

  void read_ahead(std::size_t number, std::size_t steps, std::unique_lock<std::mutex>& lock) {
    auto& camera = cameras_[number];
    if (!camera.is_asked_for()) return;
    const int frame = camera.foreseen(steps);
    if (camera.find(frame) != nullptr) return;
    if (load(camera.free_slot(), frame, number, lock)) ++counts_.from_disk;
  }

  void tell(std::unique_lock<std::mutex>& lock) {
    const auto now = std::chrono::steady_clock::now();
    if (counts_.late == told_late_ || now - told_at_ < kTellEvery) return;
    const auto late = counts_.late - told_late_;
    told_late_ = counts_.late;
    told_at_ = now;
    lock.unlock();
    spdlog::warn("{} pictures came late from disk; hold the act in memory, or the cache on a faster disk", late);
    lock.lock();
  }

  CacheEntry entry_;
  mutable std::mutex mutex_;
  std::condition_variable loaded_;
  std::condition_variable_any wake_;
  std::size_t ahead_;
  std::deque<StreamedCamera> cameras_;
  std::deque<int> announced_;  // frames the kernel was asked for last; the prefetch thread's own
  PlayerCounts counts_;
  std::uint64_t told_late_ = 0;
  std::chrono::steady_clock::time_point told_at_{};
  bool has_errand_ = false;
  std::jthread prefetch_;
};

}  // namespace

std::unique_ptr<ActPlayer> hold_in_memory(std::vector<PictureSet> frames) {
  return std::make_unique<HeldAct>(std::move(frames));
}

std::unique_ptr<ActPlayer> stream_from_disk(CacheEntry entry) {
  return std::make_unique<StreamedAct>(std::move(entry));
}

}  // namespace rotunda::simulator
