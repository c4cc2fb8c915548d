#include "config/errors.h"

#include <fmt/format.h>

namespace rotunda {
namespace {

std::string describe(const std::filesystem::path& file, const std::vector<ConfigProblem>& problems) {
  std::string text;
  for (const auto& problem : problems) {
    if (!text.empty()) text += '\n';
    text += file.string();
    if (problem.line > 0) text += fmt::format(":{}:{}", problem.line, problem.column);
    text += ": ";
    if (!problem.key.empty()) text += problem.key + ": ";
    text += problem.message;
  }
  return text;
}

}  // namespace

ConfigError::ConfigError(const std::filesystem::path& file, std::vector<ConfigProblem> problems)
    : std::runtime_error(describe(file, problems)), problems_(std::move(problems)) {}

CorruptData::CorruptData(const std::filesystem::path& file, std::uint64_t offset, const std::string& what)
    : std::runtime_error(fmt::format("{}: at byte {}: {}", file.string(), offset, what)) {}

DeviceError::DeviceError(const std::string& device, const std::string& what)
    : std::runtime_error(device + ": " + what) {}

}  // namespace rotunda
