#include "config/exit_code.h"

#include <cstdio>
#include <exception>
#include <system_error>

#include "config/errors.h"

namespace rotunda {
namespace {

int tell(const char* program, const std::exception& error, ExitCode code) noexcept {
  std::fprintf(stderr, "%s: %s\n", program, error.what());
  return code;
}

}  // namespace

int report_current_exception(const char* program) noexcept {
  try {
    throw;
  } catch (const ConfigError& error) {
    return tell(program, error, kBadInput);
  } catch (const InvalidInput& error) {
    return tell(program, error, kBadInput);
  } catch (const CorruptData& error) {
    return tell(program, error, kBadInput);
  } catch (const std::exception& error) {
    return tell(program, error, kDeviceFailed);
  }
}

}  // namespace rotunda
