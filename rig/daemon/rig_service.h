#pragma once
// Serves the control API (rotunda.proto) on a Unix socket that only this user may open.
#include <filesystem>
#include <memory>

#include "rig/daemon/rig_daemon.h"

namespace rotunda::rig {

class RigServer {
 public:
  // Throws DeviceError if another daemon holds the socket or its folder cannot be written.
  RigServer(RigDaemon& daemon, const std::filesystem::path& socket);
  ~RigServer();  // ends the calls that are running

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace rotunda::rig
