#pragma once
// A Unix stream socket on which lines are asked and answered with lines: `socat - UNIX-CONNECT:PATH` is a client.
// Owns one thread, "sim-control". Clients are not trusted: at most kMaxClients at a time, lines of at most
// kMaxLineBytes, and who does not take its answers is hung up on. Only this user may connect.
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace rotunda::simulator {

class ControlSocket {
 public:
  static constexpr std::size_t kMaxClients = 8;
  static constexpr std::size_t kMaxLineBytes = 4096;

  // The answer to one line, neither with its line end; must not throw. Called on the socket's thread.
  using Answer = std::function<std::string(const std::string& line)>;

  // A socket file nobody listens on any more is replaced. Throws InvalidInput for a path that is too long or another
  // kind of file, DeviceError if somebody listens there already, std::system_error.
  ControlSocket(const std::filesystem::path& path, Answer answer);
  ~ControlSocket();  // hangs up and removes the file
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Asks one line and returns its answer. Throws DeviceError if nobody answers within ten seconds.
std::string ask_control_socket(const std::filesystem::path& path, const std::string& line);

}  // namespace rotunda::simulator
