#pragma once
// Makes frames ahead of whoever shows them, in one thread of its own: decoding, keying. Frames follow each other in a
// ring; `ahead` of them from the one wanted on are made and kept.
#include <pthread.h>

#include <condition_variable>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

namespace rotunda::playback {

template <class T>
class ReadAhead {
 public:
  using Item = std::shared_ptr<const T>;

  // `make` is called in the thread `name` alone. 1 <= ahead <= frames.
  ReadAhead(const char* name, int frames, int ahead, std::function<T(int frame)> make)
      : frames_(frames),
        ahead_(ahead),
        make_(std::move(make)),
        thread_([this](const std::stop_token& stop) { work(stop); }) {
    pthread_setname_np(thread_.native_handle(), name);
  }

  // Frame `frame` if it is made, else nothing; the thread goes on from there.
  Item ready(int frame) {
    const std::lock_guard lock(mutex_);
    want(frame);
    return found(frame);
  }
  // The same, and what is wanted stays as it was.
  Item kept(int frame) const {
    const std::lock_guard lock(mutex_);
    return found(frame);
  }
  // Waits for it. All three throw what `make` threw at that frame.
  Item wait_for(int frame) {
    std::unique_lock lock(mutex_);
    want(frame);
    changed_.wait(lock, [&] { return items_.count(frame) > 0 || errors_.count(frame) > 0; });
    return found(frame);
  }

 private:
  void want(int frame) {
    wanted_ = frame;
    changed_.notify_all();
  }

  Item found(int frame) const {
    if (const auto error = errors_.find(frame); error != errors_.end()) std::rethrow_exception(error->second);
    const auto item = items_.find(frame);
    return item != items_.end() ? item->second : nullptr;
  }

  int next_missing() const {  // -1: all that is wanted is there
    for (int i = 0; i < ahead_; ++i) {
      const int frame = (wanted_ + i) % frames_;
      if (items_.count(frame) == 0 && errors_.count(frame) == 0) return frame;
    }
    return -1;
  }

  void make_room() {
    for (auto item = items_.begin(); item != items_.end();)
      item = (item->first - wanted_ + frames_) % frames_ < ahead_ ? std::next(item) : items_.erase(item);
  }

  void work(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [&] { return next_missing() >= 0; })) {
      const int frame = next_missing();
      make_room();
      lock.unlock();
      Item item;
      std::exception_ptr error;
      try {
        item = std::make_shared<const T>(make_(frame));
      } catch (...) {
        error = std::current_exception();
      }
      lock.lock();
      if (error)
        errors_[frame] = error;
      else
        items_[frame] = std::move(item);
      changed_.notify_all();
      if (stop.stop_requested()) return;
    }
  }

  const int frames_, ahead_;
  const std::function<T(int)> make_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<int, Item> items_;
  std::map<int, std::exception_ptr> errors_;
  int wanted_ = 0;
  std::jthread thread_;  // last: the first to end
};

}  // namespace rotunda::playback
