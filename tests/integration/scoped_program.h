#pragma once
// A program of the house run as a child: its output is kept in files, and it never outlives its owner.
#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace rotunda::tests {

// What a program left. An exit code above 128 is a signal's number + 128, as shells have it.
struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

// Long enough for a sanitized program on a machine that is busy elsewhere: running out of it means it hangs.
inline constexpr std::chrono::seconds kPatience{240};

class ScopedProgram {
 public:
  // Runs command[0], a program of the build; `log` is the path of its output files without their endings .out, .err.
  // Throws std::system_error.
  ScopedProgram(const std::vector<std::string>& command, std::filesystem::path log);
  ~ScopedProgram();  // asks it to end; kills it if it does not
  ScopedProgram(const ScopedProgram&) = delete;
  ScopedProgram& operator=(const ScopedProgram&) = delete;

  void send(int signal) const;
  bool running();
  // Until it ends: its exit code. Past the patience it is killed, and throws std::runtime_error with its output.
  int wait(std::chrono::seconds patience = kPatience);
  // Until it has printed `text`: true; false if it ends or hangs without.
  bool wait_for(const std::string& text, std::chrono::seconds patience = kPatience);

  std::string out() const;
  std::string err() const;

 private:
  std::filesystem::path log_;
  pid_t pid_ = -1;
  int exit_code_ = -1;  // once it has ended
};

// Runs it to its end.
Outcome run_program(const std::vector<std::string>& command, const std::filesystem::path& log);

std::string text_of(const std::filesystem::path& file);

}  // namespace rotunda::tests
