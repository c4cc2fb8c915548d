#include "simulator/gige/fault_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <utility>

namespace rotunda::simulator {
namespace {

using std::chrono::nanoseconds;

constexpr std::uint64_t kMostTriggers = 1'000'000'000;
constexpr double kLongestSeconds = 24.0 * 3600.0;

// The number a text begins with, and what follows it.
std::optional<std::pair<double, std::string>> number_and_unit(const std::string& text) {
  const std::string all = without_spaces(text);
  const char* first = all.data() + (!all.empty() && all[0] == '+' ? 1 : 0);
  double number = 0.0;
  const auto [end, error] = std::from_chars(first, all.data() + all.size(), number);
  if (error != std::errc{} || !std::isfinite(number)) return std::nullopt;
  return std::pair{number, std::string(end, all.data() + all.size())};
}

}  // namespace

std::string without_spaces(std::string text) {
  text.erase(std::remove(text.begin(), text.end(), ' '), text.end());
  return text;
}

std::optional<nanoseconds> parse_duration(const std::string& text) {
  static const std::map<std::string, double> kUnits{{"ns", 1e-9}, {"us", 1e-6},  {"ms", 1e-3},
                                                    {"s", 1.0},   {"min", 60.0}, {"h", 3600.0}};
  const auto parsed = number_and_unit(text);
  const auto unit = parsed ? kUnits.find(parsed->second) : kUnits.end();
  if (unit == kUnits.end()) return std::nullopt;
  const double seconds = parsed->first * unit->second;
  if (std::abs(seconds) > kLongestSeconds) return std::nullopt;
  return nanoseconds{std::llround(seconds * 1e9)};
}

std::optional<double> parse_share(const std::string& text) {
  const auto parsed = number_and_unit(text);
  if (!parsed || (parsed->second != "%" && !parsed->second.empty())) return std::nullopt;
  const double share = parsed->second == "%" ? parsed->first / 100.0 : parsed->first;
  return share >= 0.0 && share <= 1.0 ? std::optional(share) : std::nullopt;
}

std::optional<std::uint64_t> parse_count(const std::string& text) {
  std::uint64_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc{} || end != text.data() + text.size() || count < 1 || count > kMostTriggers)
    return std::nullopt;
  return count;
}

std::optional<std::uint32_t> parse_packets(const std::string& text) {
  const auto count = parse_count(text);
  return count && *count <= 1000 ? std::optional(static_cast<std::uint32_t>(*count)) : std::nullopt;
}

std::optional<double> parse_number(const std::string& text, const std::string& unit, double low, double high) {
  const auto parsed = number_and_unit(text);
  if (!parsed || (!parsed->second.empty() && parsed->second != unit)) return std::nullopt;
  return parsed->first >= low && parsed->first <= high ? std::optional(parsed->first) : std::nullopt;
}

std::optional<nanoseconds> parse_delay(const std::string& text) {
  const auto duration = parse_duration(text);
  return duration && duration->count() >= 0 ? duration : std::nullopt;
}

std::optional<nanoseconds> parse_span(const std::string& text) {
  const auto duration = parse_duration(text);
  return duration && duration->count() > 0 ? duration : std::nullopt;
}

std::optional<std::int64_t> parse_bytes(const std::string& text) {
  constexpr double kMostBytes = 64 << 20;
  const auto bytes = parse_number(text, "B", -kMostBytes, kMostBytes);
  return bytes && *bytes == std::floor(*bytes) ? std::optional(static_cast<std::int64_t>(*bytes)) : std::nullopt;
}

std::optional<LeaderFlaw> parse_flaw(const std::string& word) {
  static const std::map<std::string, LeaderFlaw> kFlaws{{"width", LeaderFlaw::width},
                                                        {"height", LeaderFlaw::height},
                                                        {"pixel_format", LeaderFlaw::pixel_format},
                                                        {"block_id", LeaderFlaw::block_id},
                                                        {"random", LeaderFlaw::random}};
  const auto flaw = kFlaws.find(word);
  return flaw == kFlaws.end() ? std::nullopt : std::optional(flaw->second);
}

}  // namespace rotunda::simulator
