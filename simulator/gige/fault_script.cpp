#include "simulator/gige/fault_script.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <system_error>

#include "config/checked_yaml.h"

namespace rotunda::simulator {
namespace {

using config::CheckedMap;
using config::Problems;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;
using Names = std::span<const std::string>;

constexpr std::size_t kMaxFileBytes = 1 << 20;
constexpr std::uint64_t kMostTriggers = 1'000'000'000;
constexpr nanoseconds kReboot = 5s;  // if it does not say how long it is away
constexpr double kLongestSeconds = 24.0 * 3600.0;

const std::string kDuration = "a duration such as 20ms, 2s or 1min, up to a day";
const std::string kPackets = "1 to 1000 packets";
const std::string kShare = "a share such as 1% or 0.01";

// --- values -----------------------------------------------------------------------------------------------------

std::string without_spaces(std::string text) {
  text.erase(std::remove(text.begin(), text.end(), ' '), text.end());
  return text;
}

// The number a text begins with, and what follows it.
std::optional<std::pair<double, std::string>> number_and_unit(const std::string& text) {
  const std::string all = without_spaces(text);
  const char* first = all.data() + (!all.empty() && all[0] == '+' ? 1 : 0);
  double number = 0.0;
  const auto [end, error] = std::from_chars(first, all.data() + all.size(), number);
  if (error != std::errc{} || !std::isfinite(number)) return std::nullopt;
  return std::pair{number, std::string(end, all.data() + all.size())};
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

std::optional<nanoseconds> parse_delay(const std::string& text) {  // forwards only
  const auto duration = parse_duration(text);
  return duration && duration->count() >= 0 ? duration : std::nullopt;
}

std::optional<nanoseconds> parse_span(const std::string& text) {  // and not nothing
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

// --- one fault --------------------------------------------------------------------------------------------------

// The value of a fault's key: keys and values, or the value of its most important key alone.
class Parameters {
 public:
  Parameters(const YAML::Node& node, const std::string& path, const std::string& main, Problems& problems)
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
  CheckedMap& map() { return map_; }

 private:
  static YAML::Node only(const std::string& key, const YAML::Node& value) {
    YAML::Node map(YAML::NodeType::Map);
    map[key] = value;
    return map;
  }
  CheckedMap map_;
};

void read_times(Parameters& p, Fault& fault) {
  p.read("for", kDuration, parse_span, fault.lasts);
}

// The next so many triggers, or each whose number is a multiple.
void read_triggers(Parameters& p, Fault& fault, std::uint64_t& every) {
  const std::string expected = "a number of triggers from 1 on";
  std::uint64_t next = 0;
  const bool all_of_the_next = p.read("next", expected, parse_count, next);
  const bool some = p.read("every", expected, parse_count, every);
  const auto both = p.map().find("every");
  if (all_of_the_next && some) p.map().wrong(both, "every", "either next (so many triggers) or every (each n-th)");
  if (!both) p.map().require("next", expected);
  if (!all_of_the_next) return;
  every = 1;
  fault.triggers = next;
}

FaultEffect rate_only(Parameters& p, auto effect) {
  p.need("rate", kShare, parse_share, effect.rate);
  return effect;
}

FaultEffect delay_only(Parameters& p, auto effect) {
  p.need("by", kDuration, parse_span, effect.by);
  return effect;
}

FaultEffect read_loss(Parameters& p, Fault&) {
  PacketLoss loss;
  p.need("rate", kShare, parse_share, loss.rate);
  p.read("burst", kPackets, parse_packets, loss.burst);
  return loss;
}

FaultEffect read_reorder(Parameters& p, Fault&) {
  Reorder reorder;
  p.need("rate", kShare, parse_share, reorder.rate);
  p.read("by", kPackets, parse_packets, reorder.by);
  return reorder;
}

FaultEffect read_leader(Parameters& p, Fault&) {
  CorruptedLeader leader{.rate = 1.0};
  p.need("what", "one of width, height, pixel_format, block_id, random", parse_flaw, leader.flaw);
  p.read("rate", kShare, parse_share, leader.rate);
  return leader;
}

FaultEffect read_payload(Parameters& p, Fault&) {
  WrongPayloadSize wrong;
  const std::string expected = "a number of bytes, such as -1000 or 4096";
  const bool sent = p.read("sent", expected, parse_bytes, wrong.sent_change);
  const bool told = p.read("register", expected, parse_bytes, wrong.register_change);
  if (!sent && !told) p.map().require("sent", expected);
  return wrong;
}

template <class Effect>
FaultEffect timed(Parameters& p, Fault& fault) {
  read_times(p, fault);
  return Effect{};
}

FaultEffect read_theft(Parameters& p, Fault& fault) {
  ControlStolen theft;
  read_times(p, fault);
  p.map().read<bool>("exclusive", theft.exclusive, "true or false");
  return theft;
}

FaultEffect read_heat(Parameters& p, Fault&) {
  const auto celsius = [](const std::string& text) { return parse_number(text, "C", 0.0, 200.0); };
  OverTemperature heat;
  p.need("to", "0 to 200 degrees Celsius", celsius, heat.celsius);
  p.read("within", kDuration, parse_delay, heat.within);
  p.read("stops_at", "0 to 200 degrees Celsius", celsius, heat.stops_at);
  return heat;
}

FaultEffect read_doubled(Parameters& p, Fault& fault) {
  DoubledTrigger doubled;
  read_triggers(p, fault, doubled.every);
  p.read("after", kDuration, parse_span, doubled.after);
  return doubled;
}

FaultEffect read_missed(Parameters& p, Fault& fault) {
  MissedTrigger missed;
  read_triggers(p, fault, missed.every);
  return missed;
}

FaultEffect read_step(Parameters& p, Fault&) {
  ClockStep step;
  p.need("by", kDuration + ", forwards or (with a minus) back", parse_duration, step.by);
  return step;
}

FaultEffect read_drift(Parameters& p, Fault&) {
  ClockDrift drift;
  p.need(
      "ppm", "-10000 to 10000 parts a million", [](const auto& t) { return parse_number(t, "ppm", -1e4, 1e4); },
      drift.ppm);
  return drift;
}

// What is written as what. The main key may be left out.
struct Row {
  FaultKind kind;
  const char* main;
  FaultEffect (*read)(Parameters&, Fault&);
};
const std::array<Row, kFaultKinds> kRows{
    Row{FaultKind::packet_loss, "rate", read_loss},
    {FaultKind::reorder, "rate", read_reorder},
    {FaultKind::duplicate, "rate", [](Parameters& p, Fault&) { return rate_only(p, Duplicate{}); }},
    {FaultKind::network_error, "rate", [](Parameters& p, Fault&) { return rate_only(p, NetworkError{}); }},
    {FaultKind::late_frames, "by", [](Parameters& p, Fault&) { return delay_only(p, LateFrames{}); }},
    {FaultKind::missing_trailer, "rate", [](Parameters& p, Fault&) { return rate_only(p, MissingTrailer{}); }},
    {FaultKind::corrupted_leader, "what", read_leader},
    {FaultKind::wrong_payload_size, "sent", read_payload},
    {FaultKind::stall, "for", timed<Stall>},
    {FaultKind::silence, "for", timed<Silence>},
    {FaultKind::reboot, "for", timed<Reboot>},
    {FaultKind::control_stolen, "for", read_theft},
    {FaultKind::slow_registers, "by", [](Parameters& p, Fault&) { return delay_only(p, SlowRegisters{}); }},
    {FaultKind::over_temperature, "to", read_heat},
    {FaultKind::late_trigger, "by", [](Parameters& p, Fault&) { return delay_only(p, LateTrigger{}); }},
    {FaultKind::missed_trigger, "next", read_missed},
    {FaultKind::doubled_trigger, "next", read_doubled},
    {FaultKind::clock_step, "by", read_step},
    {FaultKind::clock_drift, "ppm", read_drift},
};

std::set<std::string> kind_names() {
  std::set<std::string> names;
  for (const auto& row : kRows) names.emplace(to_string(row.kind));
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
    for (const auto& row : kRows) read_fault(map, row, entry, into);
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

  void read_fault(CheckedMap& map, const Row& row, const CameraFault& entry, FaultScript& into) {
    const std::string name{to_string(row.kind)};
    const auto node = map.find(name);
    if (!node) return;
    if (node.IsNull() && std::string_view(row.main) != "for") {
      map.wrong(node, name, "a value, or keys and values");
      return;
    }
    Parameters parameters(node, map.path_of(name), row.main, problems_);
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
