#include "capture/source/feature_access.h"

#include <charconv>

namespace rotunda::capture {
namespace {

template <class Number>
std::optional<Number> parsed(const std::string& text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

std::string first_of(FeatureAccess& camera, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (camera.has(name)) return name;
  return "";
}

std::optional<std::int64_t> read_integer(FeatureAccess& camera, const std::string& name) {
  return parsed<std::int64_t>(camera.read(name));
}

std::optional<double> read_number(FeatureAccess& camera, const std::string& name) {
  return parsed<double>(camera.read(name));
}

}  // namespace rotunda::capture
