#include "simulator/gige/control_socket.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "capture/base/unique_fd.h"
#include "config/errors.h"

namespace rotunda::simulator {
namespace {

using capture::UniqueFd;
namespace fs = std::filesystem;

constexpr std::size_t kMaxUnsentBytes = 1 << 20;
constexpr int kPatienceSeconds = 10;

[[noreturn]] void fail(const fs::path& path, const char* what) {
  throw std::system_error(errno, std::generic_category(), path.string() + ": " + what);
}

sockaddr_un address_of(const fs::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const auto text = path.string();
  if (text.empty() || text.size() >= sizeof address.sun_path)
    throw InvalidInput(
        fmt::format("\"{}\" cannot be a socket's path: 1 to {} characters", text, sizeof address.sun_path - 1));
  std::copy(text.begin(), text.end(), address.sun_path);
  return address;
}

UniqueFd stream_socket(const fs::path& path, int flags) {
  UniqueFd fd(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | flags, 0));
  if (fd.get() < 0) fail(path, "socket");
  return fd;
}

bool connects(const UniqueFd& fd, const sockaddr_un& address) {
  return connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

void make_way(const fs::path& path, const sockaddr_un& address) {
  std::error_code ignored;
  const auto kind = fs::symlink_status(path, ignored).type();
  if (kind == fs::file_type::not_found) return;
  if (kind != fs::file_type::socket)
    throw InvalidInput(path.string() + " is there already and is no socket; name another");
  if (connects(stream_socket(path, 0), address))
    throw DeviceError(path.string(), "somebody listens here already; is another rotunda-sim running?");
  fs::remove(path);
}

UniqueFd listener(const fs::path& path) {
  const auto address = address_of(path);
  make_way(path, address);
  auto fd = stream_socket(path, SOCK_NONBLOCK);
  if (fchmod(fd.get(), S_IRUSR | S_IWUSR) != 0) fail(path, "chmod");  // the file is made with this mode
  if (bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) fail(path, "bind");
  if (listen(fd.get(), static_cast<int>(ControlSocket::kMaxClients)) != 0) fail(path, "listen");
  return fd;
}

struct Client {
  UniqueFd fd;
  std::string heard, unsent;
  bool closing = false;  // once `unsent` has left
  bool gone = false;
};

}  // namespace

struct ControlSocket::Impl {
  Impl(fs::path where, Answer answering) : path(std::move(where)), answer(std::move(answering)) {
    listening = listener(path);
    stop = UniqueFd(eventfd(0, EFD_CLOEXEC));
    if (stop.get() < 0) fail(path, "eventfd");
    thread = std::jthread([this] { loop(); });
  }

  void loop();
  void welcome();
  void hear(Client& client);
  void answer_lines(Client& client);
  static void reply(Client& client, const std::string& line);
  static void send_some(Client& client);

  fs::path path;
  Answer answer;
  UniqueFd listening, stop;
  std::vector<Client> clients;  // the thread's own
  std::jthread thread;
};

void ControlSocket::Impl::loop() {
  prctl(PR_SET_NAME, "sim-control");
  for (;;) {
    std::vector<pollfd> waiting{{stop.get(), POLLIN, 0}, {listening.get(), POLLIN, 0}};
    for (const auto& client : clients)
      waiting.push_back({client.fd.get(),
                         static_cast<short>((client.closing ? 0 : POLLIN) | (client.unsent.empty() ? 0 : POLLOUT)), 0});
    if (poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) return;
    if (waiting[0].revents != 0) return;
    for (std::size_t i = 0; i < clients.size(); ++i) {
      const short happened = waiting[i + 2].revents;
      if ((happened & (POLLIN | POLLHUP | POLLERR)) != 0 && !clients[i].closing) hear(clients[i]);
      if (!clients[i].unsent.empty()) send_some(clients[i]);
    }
    clients.erase(std::remove_if(clients.begin(), clients.end(),
                                 [](const Client& c) { return c.gone || (c.closing && c.unsent.empty()); }),
                  clients.end());
    if (waiting[1].revents != 0) welcome();
  }
}

void ControlSocket::Impl::welcome() {
  UniqueFd fd(accept4(listening.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (fd.get() < 0) return;
  Client client{.fd = std::move(fd), .heard = {}, .unsent = {}};
  if (clients.size() >= kMaxClients) {
    reply(client, R"({"ok":false,"error":"too many clients; close another connection first"})");
    send_some(client);
    return;
  }
  clients.push_back(std::move(client));
}

void ControlSocket::Impl::hear(Client& client) {
  std::array<char, kMaxLineBytes> buffer{};
  const auto bytes = recv(client.fd.get(), buffer.data(), buffer.size(), 0);
  if (bytes < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (bytes < 0) client.gone = true;
  if (bytes == 0) client.closing = true;  // it may still want the answers to what it asked
  if (bytes <= 0) return;
  client.heard.append(buffer.data(), static_cast<std::size_t>(bytes));
  answer_lines(client);
}

void ControlSocket::Impl::answer_lines(Client& client) {
  while (!client.gone) {
    const auto end = client.heard.find('\n');
    if (std::min(end, client.heard.size()) > kMaxLineBytes) {
      reply(client,
            fmt::format(R"({{"ok":false,"error":"a request is one line of at most {} bytes"}})", kMaxLineBytes));
      client.closing = true;
      return;
    }
    if (end == std::string::npos) return;
    auto line = client.heard.substr(0, end);
    client.heard.erase(0, end + 1);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty()) reply(client, answer(line));
  }
}

void ControlSocket::Impl::reply(Client& client, const std::string& line) {
  client.unsent += line + '\n';
  client.gone |= client.unsent.size() > kMaxUnsentBytes;
}

void ControlSocket::Impl::send_some(Client& client) {
  const auto sent = send(client.fd.get(), client.unsent.data(), client.unsent.size(), MSG_NOSIGNAL);
  if (sent < 0) client.gone |= errno != EAGAIN && errno != EINTR;
  if (sent > 0) client.unsent.erase(0, static_cast<std::size_t>(sent));
}

ControlSocket::ControlSocket(const fs::path& path, Answer answer)
    : impl_(std::make_unique<Impl>(path, std::move(answer))) {}

ControlSocket::~ControlSocket() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = write(impl_->stop.get(), &one, sizeof one);
  impl_->thread.join();
  unlink(impl_->path.c_str());
}

std::string ask_control_socket(const fs::path& path, const std::string& line) {
  const auto address = address_of(path);
  const auto fd = stream_socket(path, 0);
  const timeval patience{.tv_sec = kPatienceSeconds, .tv_usec = 0};
  setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  if (!connects(fd, address))
    throw DeviceError(path.string(), "no rotunda-sim listens here; start it with --control " + path.string());
  const std::string request = line + '\n';
  if (send(fd.get(), request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size()))
    throw DeviceError(path.string(), "the simulator does not take the request");
  std::string answer;
  std::array<char, 4096> buffer{};
  while (answer.find('\n') == std::string::npos) {
    const auto bytes = recv(fd.get(), buffer.data(), buffer.size(), 0);
    if (bytes <= 0) throw DeviceError(path.string(), "the simulator does not answer");
    answer.append(buffer.data(), static_cast<std::size_t>(bytes));
  }
  return answer.substr(0, answer.find('\n'));
}

}  // namespace rotunda::simulator
