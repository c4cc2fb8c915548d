#include "tests/integration/scoped_program.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace rotunda::tests {
namespace {

using namespace std::chrono_literals;

// Nothing between fork and exec may allocate or lock: other threads may hold the locks.
[[noreturn]] void become(char* const* command, const char* out, const char* err) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  constexpr int kNewFile = O_WRONLY | O_CREAT | O_TRUNC;
  dup2(open(out, kNewFile, 0600), STDOUT_FILENO);
  dup2(open(err, kNewFile, 0600), STDERR_FILENO);
  dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
  execv(command[0], command);
  _exit(127);
}

}  // namespace

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

ScopedProgram::ScopedProgram(const std::vector<std::string>& command, std::filesystem::path log)
    : log_(std::move(log)) {
  auto words = command;
  std::vector<char*> pointers;
  for (auto& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const auto out = log_.string() + ".out", err = log_.string() + ".err";
  pid_ = fork();
  if (pid_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (pid_ == 0) become(pointers.data(), out.c_str(), err.c_str());
}

ScopedProgram::~ScopedProgram() {
  if (!running()) return;
  send(SIGTERM);
  try {
    wait(60s);
  } catch (const std::exception&) {  // it was killed
  }
}

void ScopedProgram::send(int signal) const {
  if (pid_ > 0 && exit_code_ < 0) kill(pid_, signal);
}

bool ScopedProgram::running() {
  if (exit_code_ >= 0) return false;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return true;
  exit_code_ = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  return false;
}

int ScopedProgram::wait(std::chrono::seconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (running()) {
    if (std::chrono::steady_clock::now() > end) {
      send(SIGKILL);
      while (running()) std::this_thread::sleep_for(10ms);
      throw std::runtime_error("a program hangs: " + log_.string() + "\n" + out() + err());
    }
    std::this_thread::sleep_for(20ms);
  }
  return exit_code_;
}

bool ScopedProgram::wait_for(const std::string& text, std::chrono::seconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  const auto said = [&] { return (out() + err()).find(text) != std::string::npos; };
  while (!said() && running() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(20ms);
  return said();
}

std::string ScopedProgram::out() const {
  return text_of(log_.string() + ".out");
}

std::string ScopedProgram::err() const {
  return text_of(log_.string() + ".err");
}

Outcome run_program(const std::vector<std::string>& command, const std::filesystem::path& log) {
  ScopedProgram program(command, log);
  Outcome outcome;
  outcome.exit_code = program.wait();
  outcome.out = program.out();
  outcome.err = program.err();
  return outcome;
}

}  // namespace rotunda::tests
