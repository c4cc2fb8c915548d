#pragma once
// A GigE Vision device that is nothing but a memory: it answers whoever reads or writes it, and has whatever
// description it is given. For what a well-made camera would never say.
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "simulator/gige/big_endian.h"
#include "simulator/gige/gvcp.h"
#include "simulator/gige/udp_socket.h"

namespace rotunda::tests {

// A description of one node: what an opening asks for at least.
inline std::string bare_description(const std::string& nodes = "") {
  return "<?xml version=\"1.0\"?><RegisterDescription ModelName=\"Bare\" VendorName=\"Bare\" "
         "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\">" +
         nodes + "<Port Name=\"Device\"/></RegisterDescription>";
}

struct BareDeviceOptions {
  std::size_t devices = 1;
  std::uint8_t first_address = 1;  // 127.0.0.x
  std::string description = bare_description();
  std::string url;  // where it says that the description lies; empty: the truth
  // What becomes of its answers on their way out; nothing: they leave as they are.
  std::function<void(std::vector<std::uint8_t>& datagram)> spoil;
};

class BareDevice {
 public:
  static constexpr std::uint32_t kDescription = 0x1000;  // where it lies

  explicit BareDevice(BareDeviceOptions options = {}) : options_(std::move(options)) {
    memory_.resize(kDescription + options_.description.size() + 0x1000);
    const std::string url = options_.url.empty()
                                ? fmt::format("Local:bare.xml;{:x};{:x}", kDescription, options_.description.size())
                                : options_.url;
    std::copy_n(url.begin(), std::min<std::size_t>(url.size(), 512), memory_.begin() + 0x200);
    std::copy(options_.description.begin(), options_.description.end(), memory_.begin() + kDescription);
    memory_[0x48] = memory_[0x68] = 'b';  // vendor, model
    for (std::size_t i = 0; i < options_.devices; ++i) {
      const auto address = INADDR_LOOPBACK + static_cast<std::uint32_t>(options_.first_address - 1U + i);
      sockets_.emplace_back(simulator::Endpoint{address, simulator::kGvcpPort});
      ready_.push_back({.fd = sockets_.back().fd(), .events = POLLIN, .revents = 0});
    }
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) serve();
    });
  }

  std::uint64_t answered() const { return answered_; }

 private:
  void serve() {
    if (poll(ready_.data(), ready_.size(), 50) <= 0) return;
    std::array<std::uint8_t, 1024> buffer{};
    for (auto& socket : sockets_)
      while (const auto received = socket.receive(buffer))
        if (const auto command = simulator::parse_gvcp(std::span{buffer}.first(received->bytes))) {
          auto datagram = answer(*command);
          if (options_.spoil) options_.spoil(datagram);
          socket.send(datagram, received->from);
          ++answered_;
        }
  }

  std::vector<std::uint8_t> answer(const simulator::GvcpCommand& command) {
    using simulator::GvcpOpcode;
    using simulator::load_be;
    const auto address = command.payload.size() < 4 ? 0 : load_be<std::uint32_t>(command.payload, 0);
    const auto at = std::span{memory_}.subspan(std::min<std::size_t>(address, memory_.size() - 1024));
    std::vector<std::uint8_t> payload(4);
    if (command.opcode == GvcpOpcode::read_memory && command.payload.size() >= 8) {
      std::copy_n(command.payload.begin(), 4, payload.begin());
      const auto bytes = std::min<std::size_t>(load_be<std::uint16_t>(command.payload, 6), 1024);
      payload.insert(payload.end(), at.begin(), at.begin() + static_cast<std::ptrdiff_t>(bytes));
    } else if (command.opcode == GvcpOpcode::read_register) {
      std::copy_n(at.begin(), 4, payload.begin());
    } else if (command.payload.size() >= 8) {
      std::copy_n(command.payload.begin() + 4, 4, at.begin());
      simulator::store_be<std::uint16_t>(payload, 2, 1);
    }
    return simulator::gvcp_acknowledge(command, simulator::GvcpStatus::success, payload);
  }

  BareDeviceOptions options_;
  std::vector<std::uint8_t> memory_;
  std::vector<simulator::UdpSocket> sockets_;
  std::vector<pollfd> ready_;
  std::atomic<std::uint64_t> answered_ = 0;
  std::jthread thread_;
};

}  // namespace rotunda::tests
