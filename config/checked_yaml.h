#pragma once
// Reads a YAML mapping key by key and remembers every mistake with its place, so that all are told at once.
#include <yaml-cpp/yaml.h>

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "config/errors.h"

namespace rotunda::config {

using Problems = std::vector<ConfigProblem>;
using Words = std::set<std::string>;

// What CheckedMap::read() is told to expect, in words and as a test. `words` must outlive it.
std::string one_of(const Words& words);
std::function<bool(const std::string&)> in(const Words& words);
template <class T>
std::function<bool(const T&)> between(T low, T high) {
  return [low, high](const T& value) { return value >= low && value <= high; };
}

class CheckedMap {
 public:
  // `path` names the mapping in messages ("cameras[3]"), "" for the file itself. A node that is no mapping is told.
  CheckedMap(YAML::Node node, std::string path, Problems& problems);

  // Leaves `into` alone if the key is absent; tells a value of the wrong type, or one that `fits` refuses.
  template <class T>
  void read(const std::string& key, T& into, const std::string& expected,
            const std::function<bool(const T&)>& fits = {}) {
    const auto node = find(key);
    if (!node) return;
    T value{};
    if (YAML::convert<T>::decode(node, value) && (!fits || fits(value)))
      into = std::move(value);
    else
      wrong(node, key, expected);
  }

  void require(const std::string& key, const std::string& expected);  // tells the key's absence
  YAML::Node find(const std::string& key);                            // an undefined node if absent
  void wrong(const YAML::Node& node, const std::string& key, const std::string& expected);
  std::string path_of(const std::string& key) const;

  // Call last: tells every key that nobody asked for, with the nearest that was.
  void refuse_unknown_keys();

 private:
  YAML::Node node_;
  std::string path_;
  Problems& problems_;
  Words known_;
};

// The word of `known` that takes the fewest edits from `word`; "" if none is near.
std::string nearest_word(const std::string& word, const Words& known);

}  // namespace rotunda::config
