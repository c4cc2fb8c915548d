#include "capture/source/buffer_pool.h"

namespace rotunda::capture {

BufferPool::BufferPool(ArvStream* stream, std::size_t payload_bytes, int ready, int at_most)
    : stream_(stream), payload_bytes_(payload_bytes), ready_(ready), at_most_(at_most) {}

// Aravis leaves the time of the buffer's last frame in it: a frame without its leader must not be taken for that one.
void BufferPool::push(ArvBuffer* buffer) {
  arv_buffer_set_timestamp(buffer, 0);
  arv_stream_push_buffer(stream_, buffer);
}

void BufferPool::push_new() {
  push(arv_buffer_new_allocate(payload_bytes_));
  ++made_;
}

void BufferPool::top_up() {
  const std::lock_guard lock(mutex_);
  if (!stream_) return;
  int waiting = 0;
  arv_stream_get_n_buffers(stream_, &waiting, nullptr);
  for (; waiting < ready_ && made_ < at_most_; ++waiting) push_new();
}

std::shared_ptr<const std::uint8_t> BufferPool::lend(ArvBuffer* buffer, const std::uint8_t* data) {
  auto pool = shared_from_this();
  return {data, [pool = std::move(pool), buffer](const std::uint8_t*) { pool->give_back(buffer); }};
}

void BufferPool::give_back(ArvBuffer* buffer) {
  const std::lock_guard lock(mutex_);
  int waiting = 0;
  if (stream_) arv_stream_get_n_buffers(stream_, &waiting, nullptr);
  if (stream_ && waiting < ready_) {
    push(buffer);
    return;
  }
  g_object_unref(buffer);
  --made_;
}

void BufferPool::close() {
  const std::lock_guard lock(mutex_);
  stream_ = nullptr;
}

int BufferPool::made() const {
  const std::lock_guard lock(mutex_);
  return made_;
}

}  // namespace rotunda::capture
