#pragma once
// What a program tells the shell; a promise to scripts.
namespace rotunda {

enum ExitCode : int {
  kDone = 0,
  kDoneWithLoss = 1,  // frames missing, some frames failed: told
  kUsage = 2,
  kBadInput = 3,      // bad input or configuration
  kDeviceFailed = 4,  // a device, the system or the daemon failed
};

// The exit code for the exception being handled, after printing its message on stderr as "PROGRAM: message".
int report_current_exception(const char* program) noexcept;

}  // namespace rotunda
