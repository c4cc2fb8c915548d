#include "simulator/gige/fault_script.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <numeric>
#include <system_error>

#include "config/checked_yaml.h"
#include "simulator/gige/fault_kinds.h"
#include "simulator/gige/fault_values.h"

namespace rotunda::simulator {
namespace {

using config::CheckedMap;
using config::Problems;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;
using Names = std::span<const std::string>;

constexpr std::size_t kMaxFileBytes = 1 << 20;
constexpr nanoseconds kReboot = 5s;  // if it does not say how long it is away

std::set<std::string> kind_names() {
  std::set<std::string> names;
  for (const auto& row : kFaultRows) names.emplace(to_string(row.kind));
  return names;
}

// --- one entry: when, which camera, what --------------------------------------------------------------------------

class EntryReader {
 public:
  EntryReader(Names cameras, Problems& problems) : cameras_(cameras), problems_(problems) {}

  // Every fault of the mapping; `whose` if it does not say itself.
  void read(const YAML::Node& node, const std::string& path, const std::vector<std::size_t>* whose, FaultScript& into) {
    CheckedMap map(node, path, problems_);
    if (!node.IsMap()) return;
    CameraFault entry;
    if (whose != nullptr)
      entry.cameras = *whose;
    else
      entry.cameras = cameras_of(map, "camera");
    read_begin(map, entry.fault);
    read_end(map, entry.fault);
    for (const auto& row : kFaultRows) read_fault(map, row, entry, into);
    map.refuse_unknown_keys();
    if (says_nothing(node))
      problems_.push_back({node.Mark().line + 1, node.Mark().column + 1, path,
                           fmt::format("names no fault; expected one of {}", fmt::join(kind_names(), ", "))});
  }

  std::vector<std::size_t> cameras_of(CheckedMap& map, const std::string& key) {
    map.require(key, expected_camera());
    std::vector<std::size_t> chosen;
    const auto node = map.find(key);
    if (!node) return chosen;
    if (node.IsScalar()) {
      if (!choose(node.Scalar(), chosen)) map.wrong(node, key, expected_camera());
    } else if (node.IsSequence() && node.size() > 0) {
      for (const auto& name : node)
        if (!name.IsScalar() || !choose(name.Scalar(), chosen)) map.wrong(name, key, expected_camera());
    } else {
      map.wrong(node, key, expected_camera());
    }
    return chosen;
  }

  bool choose(const std::string& name, std::vector<std::size_t>& chosen) const {
    if (name == "all") {
      chosen.resize(cameras_.size());
      std::iota(chosen.begin(), chosen.end(), 0U);
      return true;
    }
    const auto found = std::find(cameras_.begin(), cameras_.end(), name);
    if (found == cameras_.end()) return false;
    const auto number = static_cast<std::size_t>(found - cameras_.begin());
    if (std::count(chosen.begin(), chosen.end(), number) == 0) chosen.push_back(number);
    return true;
  }

  std::string expected_camera() const { return fmt::format("all, or cameras out of {}", fmt::join(cameras_, ", ")); }

  static bool any_kind(const YAML::Node& node) {
    const auto kinds = kind_names();
    return std::any_of(node.begin(), node.end(),
                       [&](const auto& item) { return item.first.IsScalar() && kinds.count(item.first.Scalar()); });
  }

 private:
  static bool says_nothing(const YAML::Node& node) {
    static const std::set<std::string> kAround{"camera", "at", "for"};
    return std::all_of(node.begin(), node.end(), [](const auto& item) {
      return item.first.IsScalar() && kAround.count(item.first.Scalar()) != 0;
    });
  }

  // "2s", "trigger 40" or "trigger 40 + 20ms"
  void read_begin(CheckedMap& map, Fault& fault) {
    const auto node = map.find("at");
    if (!node) return;
    constexpr std::string_view kTrigger = "trigger ";
    std::string text = node.IsScalar() ? node.Scalar() : "";
    bool right = node.IsScalar();
    if (right && text.rfind(kTrigger, 0) == 0) {
      const auto plus = text.find('+');
      const auto number = parse_count(without_spaces(text.substr(kTrigger.size(), plus - kTrigger.size())));
      fault.at_trigger = number;
      right = number.has_value();
      text = plus == std::string::npos ? "0s" : text.substr(plus + 1);
    }
    const auto after = parse_delay(text);
    if (!right || !after)
      map.wrong(node, "at", "a time such as 2s, or a trigger such as trigger 40 or trigger 40 + 5ms");
    fault.after = after.value_or(0ns);
  }

  // "2s" or "3 triggers"
  static void read_end(CheckedMap& map, Fault& fault) {
    const auto node = map.find("for");
    if (!node) return;
    std::string text = node.IsScalar() ? node.Scalar() : "";
    const auto word = text.find(" trigger");
    const bool counts =
        word != std::string::npos && (text.substr(word) == " trigger" || text.substr(word) == " triggers");
    if (counts) fault.triggers = parse_count(text.substr(0, word));
    if (!counts) fault.lasts = parse_span(text);
    if (!fault.triggers && !fault.lasts)
      map.wrong(node, "for", "a duration such as 2s, or triggers such as 3 triggers");
  }

  void read_fault(CheckedMap& map, const FaultRow& row, const CameraFault& entry, FaultScript& into) {
    const std::string name{to_string(row.kind)};
    const auto node = map.find(name);
    if (!node) return;
    if (node.IsNull() && std::string_view(row.main) != "for") {
      map.wrong(node, name, "a value, or keys and values");
      return;
    }
    FaultParameters parameters(node, map.path_of(name), row.main, problems_);
    Fault own;
    CameraFault made = entry;
    made.fault.effect = row.read(parameters, own);
    parameters.map().refuse_unknown_keys();
    const bool has_end = made.fault.lasts || made.fault.triggers;
    if (has_end && (own.lasts || own.triggers))
      map.wrong(map.find("for"), "for", fmt::format("one end: {} tells its own", name));
    if (!has_end) {
      made.fault.lasts = own.lasts;
      made.fault.triggers = own.triggers;
    }
    if (row.kind == FaultKind::reboot && !made.fault.lasts && !made.fault.triggers) made.fault.lasts = kReboot;
    into.faults.push_back(std::move(made));
  }

  Names cameras_;
  Problems& problems_;
};

void read_seed(CheckedMap& map, FaultScript& script) {
  std::uint64_t seed = 0;
  if (!map.find("seed")) return;
  map.read<std::uint64_t>("seed", seed, "a whole number from 0 on");
  script.seed = seed;
}

YAML::Node parsed(const std::string& text, const std::string& name) {
  if (text.find("\n---") != std::string::npos)
    throw ConfigError(name, {{0, 0, "", "holds more than one YAML document (a line of ---)"}});
  try {
    return YAML::Load(text);  // LoadAll() of yaml-cpp 0.7 never ends on a stray bracket
  } catch (const YAML::Exception& error) {
    const bool placed = !error.mark.is_null();
    throw ConfigError(name, {{placed ? error.mark.line + 1 : 0, placed ? error.mark.column + 1 : 0, "",
                              "is not YAML: " + error.msg}});
  }
}

void throw_if_any(const std::string& name, Problems problems) {
  if (problems.empty()) return;
  std::stable_sort(problems.begin(), problems.end(), [](const auto& a, const auto& b) {
    return std::pair{a.line, a.column} < std::pair{b.line, b.column};
  });
  throw ConfigError(name, std::move(problems));
}

// "cam03: { silence: 2s }": the cameras are the keys.
void read_by_camera(const YAML::Node& root, EntryReader& reader, Problems& problems, FaultScript& script) {
  for (const auto& item : root) {
    std::vector<std::size_t> cameras;
    const auto key = item.first.IsScalar() ? item.first.Scalar() : "";
    const auto mark = item.first.Mark();
    if (key == "seed") continue;
    if (reader.choose(key, cameras))
      reader.read(item.second, key, &cameras, script);
    else
      problems.push_back({mark.line + 1, mark.column + 1, key,
                          "unknown; expected " + reader.expected_camera() + ", or status, clear, seed, help"});
  }
}

FaultRequest read_request(const YAML::Node& root, EntryReader& reader, Problems& problems) {
  FaultRequest request;
  CheckedMap map(root, "", problems);
  if (root.size() == 1 && root["clear"]) {
    request.what = FaultRequest::What::clear;
    request.cameras = reader.cameras_of(map, "clear");
    return request;
  }
  read_seed(map, request.script);
  if (root["camera"] || EntryReader::any_kind(root))
    reader.read(root, "", nullptr, request.script);
  else
    read_by_camera(root, reader, problems, request.script);
  return request;
}

}  // namespace

FaultScript parse_fault_script(const std::string& text, const std::string& name, Names cameras) {
  const auto root = parsed(text, name);
  Problems problems;
  FaultScript script;
  CheckedMap map(root, "", problems);
  if (root.IsMap()) read_seed(map, script);
  if (root.IsMap()) map.require("faults", "a list with one entry a fault");
  if (const auto list = map.find("faults"); list && !list.IsSequence()) {
    map.wrong(list, "faults", "a list with one entry a fault");
  } else if (list) {
    EntryReader reader(cameras, problems);
    for (std::size_t i = 0; i < list.size(); ++i) reader.read(list[i], fmt::format("faults[{}]", i), nullptr, script);
  }
  map.refuse_unknown_keys();
  if (script.faults.size() > FaultSchedule::kMaxFaults)
    problems.push_back({0, 0, "faults", fmt::format("has more than {} entries", FaultSchedule::kMaxFaults)});
  throw_if_any(name, std::move(problems));
  return script;
}

FaultScript load_fault_script(const std::filesystem::path& file, Names cameras) {
  std::ifstream in(file, std::ios::binary);
  std::string text(kMaxFileBytes + 1, '\0');
  if (!in) throw std::system_error(errno, std::generic_category(), "cannot read " + file.string());
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad()) throw std::system_error(errno, std::generic_category(), "cannot read " + file.string());
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxFileBytes) throw ConfigError(file, {{0, 0, "", "is longer than a fault file can be, 1 MiB"}});
  return parse_fault_script(text, file.string(), cameras);
}

FaultRequest parse_fault_request(const std::string& line, Names cameras) {
  constexpr const char* kName = "request";
  if (line.find_first_of("&*") != std::string::npos)
    throw ConfigError(kName, {{0, 0, "", "anchors (&) and aliases (*) are not understood"}});
  const auto root = parsed(line, kName);
  Problems problems;
  EntryReader reader(cameras, problems);
  FaultRequest request;
  const std::string word = root.IsScalar() ? root.Scalar() : "";
  if (word == "clear") {
    request.what = FaultRequest::What::clear;
    reader.choose("all", request.cameras);
  } else if (word == "status" || word == "help") {
    request.what = word == "status" ? FaultRequest::What::status : FaultRequest::What::help;
  } else if (root.IsMap() && root.size() > 0) {
    request = read_request(root, reader, problems);
  } else {
    problems.push_back({1, 1, "", "expected status, clear, help, or a fault such as cam00: { silence: 2s }"});
  }
  throw_if_any(kName, std::move(problems));
  return request;
}

}  // namespace rotunda::simulator
