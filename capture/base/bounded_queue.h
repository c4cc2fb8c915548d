#pragma once
// A queue between threads that never grows past its capacity. The caller says what happens when it is full:
//   try_push            refuses the new item (recording: the caller counts and tells it),
//   push                waits for room,
//   push_drop_oldest    drops the oldest item and counts it (live views).
// After close() nothing more goes in; what is in can still be taken out. Safe from any number of threads.
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

#include "config/errors.h"

namespace rotunda::capture {

template <class T>
class BoundedQueue {
 public:
  // Throws InvalidInput for a capacity of none.
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {
    if (capacity == 0) throw InvalidInput("a bounded queue needs room for one item at least");
  }

  // False, and the item is left as it was, when the queue is full or closed.
  bool try_push(T&& item) {
    {
      const std::lock_guard lock(mutex_);
      if (closed_ || items_.size() >= capacity_) return false;
      items_.push_back(std::move(item));
    }
    not_empty_.notify_one();
    return true;
  }
  bool try_push(const T& item) { return try_push(T(item)); }

  // Waits for room; false when closed or asked to stop.
  bool push(T item, std::stop_token stop = {}) {
    {
      std::unique_lock lock(mutex_);
      not_full_.wait(lock, stop, [this] { return closed_ || items_.size() < capacity_; });
      if (closed_ || items_.size() >= capacity_) return false;
      items_.push_back(std::move(item));
    }
    not_empty_.notify_one();
    return true;
  }

  // Never waits; the oldest item makes room and is counted in dropped(). False when closed.
  bool push_drop_oldest(T item) {
    std::optional<T> oldest;  // destroyed outside the lock
    {
      const std::lock_guard lock(mutex_);
      if (closed_) return false;
      if (items_.size() >= capacity_) {
        oldest.emplace(std::move(items_.front()));
        items_.pop_front();
        ++dropped_;
      }
      items_.push_back(std::move(item));
    }
    not_empty_.notify_one();
    return true;
  }

  // Waits for an item; nothing when asked to stop, or closed and drained.
  std::optional<T> pop(std::stop_token stop = {}) {
    std::unique_lock lock(mutex_);
    not_empty_.wait(lock, stop, [this] { return closed_ || !items_.empty(); });
    return take(lock);
  }

  // As pop, for so long at most.
  std::optional<T> wait_pop(std::chrono::nanoseconds timeout, std::stop_token stop = {}) {
    std::unique_lock lock(mutex_);
    not_empty_.wait_for(lock, stop, timeout, [this] { return closed_ || !items_.empty(); });
    return take(lock);
  }

  void close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    not_empty_.notify_all();
    not_full_.notify_all();
  }

  std::size_t capacity() const { return capacity_; }
  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return items_.size();
  }
  std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }
  bool closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
  }

 private:
  std::optional<T> take(std::unique_lock<std::mutex>& lock) {
    if (items_.empty()) return std::nullopt;
    std::optional<T> item(std::move(items_.front()));
    items_.pop_front();
    lock.unlock();
    not_full_.notify_one();
    return item;
  }

  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable_any not_empty_;
  std::condition_variable_any not_full_;
  std::deque<T> items_;
  std::uint64_t dropped_ = 0;
  bool closed_ = false;
};

}  // namespace rotunda::capture
