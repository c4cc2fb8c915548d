#include "simulator/gige/control_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <random>
#include <system_error>
#include <thread>
#include <vector>

#include "capture/base/unique_fd.h"
#include "config/errors.h"

namespace rotunda::simulator {
namespace {

namespace fs = std::filesystem;
using capture::UniqueFd;
using testing::HasSubstr;
using namespace std::chrono_literals;

class ControlSocketTest : public testing::Test {
 protected:
  ControlSocketTest() {
    auto name = (fs::temp_directory_path() / "rotunda-control-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::system_error(errno, std::generic_category(), "mkdtemp");
    folder = name;
  }
  ~ControlSocketTest() override { fs::remove_all(folder); }
  fs::path path() const { return folder / "sim.sock"; }

  fs::path folder;
};

std::string reversed(const std::string& line) {
  return {line.rbegin(), line.rend()};
}

// A client that speaks bytes, not lines.
struct RawClient {
  explicit RawClient(const fs::path& path) : fd(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.string().copy(address.sun_path, sizeof address.sun_path - 1);
    connected = connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  void say(const std::string& bytes) { send(fd.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT); }
  // What comes until a line ends; what came if the other side hangs up or ten seconds pass.
  std::string line() {
    std::string text;
    char byte = 0;
    pollfd waiting{fd.get(), POLLIN, 0};
    while (text.find('\n') == std::string::npos && poll(&waiting, 1, 10'000) > 0 && recv(fd.get(), &byte, 1, 0) == 1)
      text += byte;
    return text;
  }
  bool is_hung_up() {
    char byte = 0;
    pollfd waiting{fd.get(), POLLIN, 0};
    return poll(&waiting, 1, 10'000) > 0 && recv(fd.get(), &byte, 1, 0) <= 0;
  }

  UniqueFd fd;
  bool connected = false;
};

}  // namespace

TEST_F(ControlSocketTest, AnswersEachLineInOrder) {
  const ControlSocket socket(path(), reversed);
  EXPECT_EQ(ask_control_socket(path(), "abc"), "cba");
  RawClient client(path());
  client.say("one\r\ntw");
  EXPECT_EQ(client.line(), "eno\n");
  client.say("o\n\nthree\n");
  EXPECT_EQ(client.line(), "owt\n");
  EXPECT_EQ(client.line(), "eerht\n");
}

TEST_F(ControlSocketTest, AnswersAClientThatHasSaidItsLast) {
  const ControlSocket socket(path(), reversed);
  RawClient client(path());
  client.say("abc\n");
  shutdown(client.fd.get(), SHUT_WR);  // as `echo abc | socat - UNIX-CONNECT:...` does
  EXPECT_EQ(client.line(), "cba\n");
  EXPECT_TRUE(client.is_hung_up());
}

TEST_F(ControlSocketTest, HangsUpOnLinesWithoutEnd) {
  const ControlSocket socket(path(), reversed);
  RawClient client(path());
  client.say(std::string(ControlSocket::kMaxLineBytes + 1, 'x'));
  EXPECT_THAT(client.line(), HasSubstr("one line of at most 4096 bytes"));
  EXPECT_TRUE(client.is_hung_up());
  EXPECT_EQ(ask_control_socket(path(), std::string(ControlSocket::kMaxLineBytes, 'y')).size(),
            ControlSocket::kMaxLineBytes);
}

TEST_F(ControlSocketTest, TurnsTheNinthClientAwayUntilOneLeaves) {
  const ControlSocket socket(path(), reversed);
  std::vector<std::unique_ptr<RawClient>> clients;
  for (std::size_t i = 0; i < ControlSocket::kMaxClients; ++i) {
    clients.push_back(std::make_unique<RawClient>(path()));
    clients.back()->say("ab\n");
    ASSERT_EQ(clients.back()->line(), "ba\n");
  }
  RawClient ninth(path());
  EXPECT_THAT(ninth.line(), HasSubstr("too many clients"));
  EXPECT_TRUE(ninth.is_hung_up());
  clients.pop_back();
  std::string answer;
  for (int k = 0; k < 100 && answer != "ba"; ++k) {
    std::this_thread::sleep_for(10ms);
    answer = ask_control_socket(path(), "ab");
  }
  EXPECT_EQ(answer, "ba");
}

TEST_F(ControlSocketTest, HangsUpOnWhoDoesNotTakeItsAnswers) {
  const ControlSocket socket(path(), [](const std::string&) { return std::string(100'000, 'z'); });
  RawClient client(path());
  client.say(std::string(4000, '\n') + "a\na\na\na\na\na\na\na\na\na\na\na\na\na\na\na\n");
  std::string all;
  std::array<char, 65536> buffer{};
  std::this_thread::sleep_for(100ms);
  for (ssize_t bytes = 1; bytes > 0; all.append(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(bytes, 0))))
    bytes = recv(client.fd.get(), buffer.data(), buffer.size(), 0);
  EXPECT_LT(all.size(), 16U * 100'001U);
  EXPECT_EQ(ask_control_socket(path(), "a").size(), 100'000U);
}

TEST_F(ControlSocketTest, SurvivesNoiseFromManyClients) {
  const ControlSocket socket(path(), reversed);
  std::mt19937 random(5);
  for (int k = 0; k < 300; ++k) {
    RawClient client(path());
    std::string noise(random() % 3000, '\0');
    for (auto& byte : noise) byte = static_cast<char>(random());
    client.say(noise);
    if (k % 3 == 0) client.say("\n");
    if (k % 5 == 0) shutdown(client.fd.get(), SHUT_WR);
  }
  std::string answer;
  for (int k = 0; k < 100 && answer != "kcab"; ++k) {
    answer = ask_control_socket(path(), "back");
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_EQ(answer, "kcab");
}

TEST_F(ControlSocketTest, BelongsToThisUserAloneAndGoesWithItsOwner) {
  {
    const ControlSocket socket(path(), reversed);
    struct stat about {};
    ASSERT_EQ(stat(path().c_str(), &about), 0);
    EXPECT_EQ(about.st_mode & 0777U, 0600U);
    EXPECT_THROW(ControlSocket(path(), reversed), DeviceError) << "somebody listens there";
    EXPECT_EQ(ask_control_socket(path(), "ab"), "ba");
  }
  EXPECT_FALSE(fs::exists(path()));
  EXPECT_THROW(ask_control_socket(path(), "ab"), DeviceError);
}

TEST_F(ControlSocketTest, ReplacesADeadSocketAndNothingElse) {
  {
    UniqueFd dead(::socket(AF_UNIX, SOCK_STREAM, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path().string().copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(bind(dead.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ASSERT_TRUE(fs::exists(path()));
  EXPECT_NO_THROW(ControlSocket(path(), reversed));
  std::ofstream(folder / "notes") << "keep me";
  EXPECT_THROW(ControlSocket(folder / "notes", reversed), InvalidInput);
  EXPECT_TRUE(fs::exists(folder / "notes"));
  EXPECT_THROW(ControlSocket(folder / std::string(200, 'n'), reversed), InvalidInput);
  EXPECT_THROW(ControlSocket(folder / "no" / "where", reversed), std::system_error);
}

}  // namespace rotunda::simulator
