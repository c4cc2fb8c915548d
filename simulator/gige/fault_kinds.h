#pragma once
// How each kind of fault is written: which keys it has, and which of them may be left out when it is alone. Private to
// the fault files' reader.
#include <array>

#include "config/checked_yaml.h"
#include "simulator/gige/fault_schedule.h"

namespace rotunda::simulator {

// The value of a fault's key: keys and values, or the value of its most important key alone.
class FaultParameters {
 public:
  FaultParameters(const YAML::Node& node, const std::string& path, const std::string& main, config::Problems& problems)
      : map_(node.IsScalar() ? only(main, node)
             : node.IsNull() ? YAML::Node(YAML::NodeType::Map)
                             : node,
             path, problems) {}

  // Whether the key is there and right.
  template <class Parse>
  bool read(const std::string& key, const std::string& expected, Parse parse, auto& into) {
    const auto node = map_.find(key);
    if (!node) return false;
    if (node.IsScalar()) {
      if (const auto value = parse(node.Scalar())) {
        into = *value;
        return true;
      }
    }
    map_.wrong(node, key, expected);
    return false;
  }
  template <class Parse>
  void need(const std::string& key, const std::string& expected, Parse parse, auto& into) {
    map_.require(key, expected);
    read(key, expected, parse, into);
  }
  config::CheckedMap& map() { return map_; }

 private:
  static YAML::Node only(const std::string& key, const YAML::Node& value) {
    YAML::Node map(YAML::NodeType::Map);
    map[key] = value;
    return map;
  }
  config::CheckedMap map_;
};

struct FaultRow {
  FaultKind kind;
  const char* main;  // the key that may be left out
  FaultEffect (*read)(FaultParameters&, Fault&);
};
extern const std::array<FaultRow, kFaultKinds> kFaultRows;

}  // namespace rotunda::simulator
