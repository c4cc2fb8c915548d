#pragma once
// The values of a fault file as text: durations, shares, counts. Each is nothing if the text is not that. Private to
// the fault files' reader.
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "simulator/gige/faults.h"

namespace rotunda::simulator {

inline const std::string kDuration = "a duration such as 20ms, 2s or 1min, up to a day";
inline const std::string kPackets = "1 to 1000 packets";
inline const std::string kShare = "a share such as 1% or 0.01";

// "2s", "-1.5 ms", "90min": at most a day, either way.
std::optional<std::chrono::nanoseconds> parse_duration(const std::string& text);
std::optional<std::chrono::nanoseconds> parse_delay(const std::string& text);  // forwards only
std::optional<std::chrono::nanoseconds> parse_span(const std::string& text);   // and not nothing
std::optional<double> parse_share(const std::string& text);
std::optional<std::uint64_t> parse_count(const std::string& text);  // 1 to a thousand million
std::optional<std::uint32_t> parse_packets(const std::string& text);
// The unit may be left out.
std::optional<double> parse_number(const std::string& text, const std::string& unit, double low, double high);
std::optional<std::int64_t> parse_bytes(const std::string& text);  // 64 MiB at most, either way
std::optional<LeaderFlaw> parse_flaw(const std::string& word);
std::string without_spaces(std::string text);

}  // namespace rotunda::simulator
