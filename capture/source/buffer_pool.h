#pragma once
// The image buffers of one Aravis stream: so many wait for the camera at any time; more are made while readers hold on
// to theirs, up to a limit; those given back go to the stream again, or are freed once it is gone.
#include <arv.h>

#include <cstdint>
#include <memory>
#include <mutex>

namespace rotunda::capture {

class BufferPool : public std::enable_shared_from_this<BufferPool> {
 public:
  // Borrows the stream until close(); top_up() makes the first buffers.
  BufferPool(ArvStream* stream, std::size_t payload_bytes, int ready, int at_most);

  // The pixels of a buffer popped from the stream, from `data` on; keeps the buffer while they are read.
  std::shared_ptr<const std::uint8_t> lend(ArvBuffer* buffer, const std::uint8_t* data);
  void give_back(ArvBuffer* buffer);
  void top_up();  // makes up for what readers hold
  void close();   // the stream is about to go
  int made() const;

 private:
  void push(ArvBuffer* buffer);
  void push_new();

  mutable std::mutex mutex_;
  ArvStream* stream_;
  const std::size_t payload_bytes_;
  const int ready_;
  const int at_most_;
  int made_ = 0;
};

}  // namespace rotunda::capture
