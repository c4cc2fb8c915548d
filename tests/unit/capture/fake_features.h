#pragma once
// A camera made of nothing but features, for tests: values by name, and what writing or executing one does.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "capture/source/feature_access.h"
#include "config/errors.h"

namespace rotunda::capture {

class FakeFeatures : public FeatureAccess {
 public:
  std::map<std::string, std::string> values;
  std::map<std::string, std::function<void()>> commands;
  std::map<std::string, std::function<std::string(const std::string&)>> takes;  // what it makes of what is written
  std::vector<std::string> calls;                                               // "Gain=3", "UserSetLoad"

  bool has(const std::string& name) override { return values.count(name) + commands.count(name) > 0; }
  std::string read(const std::string& name) override { return there(name); }
  void write(const std::string& name, const std::string& value) override {
    there(name) = takes.count(name) ? takes[name](value) : value;
    calls.push_back(name + "=" + value);
  }
  void execute(const std::string& name) override {
    if (!commands.count(name)) throw DeviceError("fake", "no command " + name);
    calls.push_back(name);
    commands[name]();
  }

 private:
  std::string& there(const std::string& name) {
    if (!values.count(name)) throw DeviceError("fake", "no feature " + name);
    return values[name];
  }
};

}  // namespace rotunda::capture
