#include "config/checked_yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

namespace rotunda::config {
namespace {

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0U);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

ConfigProblem problem_at(const YAML::Node& node, std::string key, std::string message) {
  const auto mark = node.IsDefined() ? node.Mark() : YAML::Mark::null_mark();
  if (mark.is_null()) return {0, 0, std::move(key), std::move(message)};
  return {mark.line + 1, mark.column + 1, std::move(key), std::move(message)};
}

std::string shown(const YAML::Node& node) {
  if (node.IsScalar()) return "\"" + node.Scalar() + "\"";
  if (node.IsSequence()) return "a list";
  return node.IsMap() ? "a mapping" : "nothing";
}

}  // namespace

std::string one_of(const Words& words) {
  return fmt::format("one of {}", fmt::join(words, ", "));
}

std::function<bool(const std::string&)> in(const Words& words) {
  return [&words](const std::string& word) { return words.count(word) != 0; };
}

std::string nearest_word(const std::string& word, const Words& known) {
  std::string nearest;
  std::size_t fewest = std::max<std::size_t>(3, word.size() / 2 + 1);
  for (const auto& candidate : known) {
    const auto distance = edit_distance(word, candidate);
    if (distance >= fewest) continue;
    fewest = distance;
    nearest = candidate;
  }
  return nearest;
}

CheckedMap::CheckedMap(YAML::Node node, std::string path, Problems& problems)
    : node_(node), path_(std::move(path)), problems_(problems) {
  if (node_.IsMap()) return;
  problems_.push_back(problem_at(node_, path_, "expected keys and values, found " + shown(node_)));
  node_ = YAML::Node(YAML::NodeType::Map);
}

std::string CheckedMap::path_of(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

YAML::Node CheckedMap::find(const std::string& key) {
  known_.insert(key);
  const YAML::Node& lookup = node_;  // const: operator[] of a mutable node would add the key
  return lookup[key];
}

void CheckedMap::require(const std::string& key, const std::string& expected) {
  if (!find(key)) problems_.push_back(problem_at(node_, path_of(key), "is missing; expected " + expected));
}

void CheckedMap::wrong(const YAML::Node& node, const std::string& key, const std::string& expected) {
  problems_.push_back(problem_at(node, path_of(key), fmt::format("expected {}, found {}", expected, shown(node))));
}

void CheckedMap::refuse_unknown_keys() {
  for (const auto& entry : node_) {
    const auto key = entry.first.IsScalar() ? entry.first.Scalar() : "(not a word)";
    if (known_.count(key) != 0) continue;
    const auto nearest = nearest_word(key, known_);
    const auto advice = nearest.empty() ? "known here: " + fmt::format("{}", fmt::join(known_, ", "))
                                        : "did you mean \"" + nearest + "\"?";
    problems_.push_back(problem_at(entry.first, path_of(key), "unknown key; " + advice));
  }
}

}  // namespace rotunda::config
