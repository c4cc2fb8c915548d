#pragma once
// Serves the control API (rotunda.proto) on a Unix socket that only this user may open.
#include <filesystem>
#include <memory>

#include "capture/base/unique_fd.h"
#include "rig/daemon/rig_daemon.h"

namespace rotunda::rig {

// The right to serve a socket: gRPC takes a Unix socket over without asking, the lock file beside it says whether its
// owner still lives. Take it before touching cameras. Throws DeviceError if another daemon holds it or its folder
// cannot be written.
class SocketLock {
 public:
  explicit SocketLock(std::filesystem::path socket);
  const std::filesystem::path& socket() const { return socket_; }

 private:
  std::filesystem::path socket_;
  capture::UniqueFd file_;
};

class RigServer {
 public:
  // `lock` must outlive the server. Throws DeviceError if the socket cannot be served.
  RigServer(RigDaemon& daemon, const SocketLock& lock);
  ~RigServer();  // ends the calls that are running

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace rotunda::rig
