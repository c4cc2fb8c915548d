#include "recon/motion/graph_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <sstream>
#include <system_error>

#include "config/checked_yaml.h"
#include "config/errors.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using config::CheckedMap;
using config::Problems;
using config::Words;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::uintmax_t kLargestFile = 4U << 20U;

constexpr const char* kHead =
    R"(# A character: who can idle, walk, jog, ... on command. `rotunda show` prices it, `rotunda play` steers it.
# Frames are counted from 0 in each clip's own geometry video, CLIP.mkv beside this file. Metres, degrees.
# You may rename states and transitions, delete transitions, move seams (leave, enter: frames; blend: how many);
# then `rotunda character edit FOLDER` checks the file and works x, y, turn_deg and the prices of moved seams out anew.
)";

// A name as YAML takes it: quoted unless it is plain.
std::string scalar(const std::string& text) {
  static const std::set<std::string> words{"true", "false", "yes", "no", "on", "off", "null", "y", "n"};
  const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0 || c == '_'; };
  const auto is_plain = [&](unsigned char c) { return is_letter(c) || std::isdigit(c) != 0 || c == '-'; };
  std::string lower;
  for (const unsigned char c : text) lower += static_cast<char>(std::tolower(c));
  const bool plain = !text.empty() && is_letter(static_cast<unsigned char>(text.front())) &&
                     std::all_of(text.begin(), text.end(), is_plain) && words.count(lower) == 0;
  return plain ? text : nlohmann::json(text).dump();
}

const char* word_of(Side side) {
  return side == Side::left ? "left" : "right";
}

std::string join_text(const Join& join) {
  return fmt::format(
      "{{leave: {}, enter: {}, blend: {}, x: {:.5f}, y: {:.5f}, turn_deg: {:.3f}, error_mm: {:.1f}, largest_mm: "
      "{:.1f}, "
      "step_ratio: {:.2f}, colour: {:.1f}, slide_mm: {:.1f}}}",
      join.leave, join.enter, join.blend, join.pose.x, join.pose.y, join.pose.yaw / kDegree, join.price.error_mm,
      join.price.largest_mm, join.price.step_ratio, join.price.colour, join.price.slide_mm);
}

std::string clip_text(const MotionClip& clip) {
  std::string text = fmt::format(
      "  {}:\n    take: {}\n    frames: {}\n    heading_deg: {:.2f}  # which way the person faces\n"
      "    speed: {:.3f}  # m/s\n",
      scalar(clip.name), scalar(clip.take), clip.frames, clip.heading / kDegree, clip.speed);
  text += "    heel_strikes:";
  if (clip.strikes.empty()) text += " []";
  for (const auto& strike : clip.strikes)
    text += fmt::format("\n      - {{frame: {}, foot: {}}}", strike.frame, word_of(strike.side));
  text += "\n    contacts:";
  if (clip.contacts.empty()) text += " []";
  for (const auto& contact : clip.contacts)
    text += fmt::format("\n      - {{begin: {}, end: {}, foot: {}, x: {:.4f}, y: {:.4f}}}", contact.begin, contact.end,
                        word_of(contact.side), contact.place.x(), contact.place.y());
  return text + "\n";
}

std::string transition_text(const MotionTransition& transition) {
  std::string text = fmt::format("  {}:\n    from: {}\n    to: {}\n", scalar(transition.name), scalar(transition.from),
                                 scalar(transition.to));
  text += transition.synthesised() ? "    synthesised: true  # nobody was recorded doing this\n"
                                   : fmt::format("    clip: {}\n", scalar(transition.clip));
  text += "    leaves:  # out of the state, earliest first; a command takes the next one\n";
  for (const auto& join : transition.leaves) text += "      - " + join_text(join) + "\n";
  if (!transition.synthesised()) text += "    arrive: " + join_text(transition.arrive) + "\n";
  return text;
}

std::string graph_text(const MotionGraph& graph) {
  std::string text = kHead;
  text += fmt::format("version: 1\nname: {}\nfps: {}\nstart: {}  # the state it begins in\n", scalar(graph.name),
                      graph.fps, graph.start);
  text += "states:\n";
  for (const auto& state : graph.states)
    text += fmt::format("  {}:\n    clip: {}\n    loop: {}\n", scalar(state.name), scalar(state.clip),
                        join_text(state.loop));
  text += graph.transitions.empty() ? "transitions: {}\n" : "transitions:\n";
  for (const auto& transition : graph.transitions) text += transition_text(transition);
  text += "clips:\n";
  for (const auto& clip : graph.clips) text += clip_text(clip);
  return text;
}

class GraphReader {
 public:
  explicit GraphReader(Problems& problems) : problems_(problems) {}

  MotionGraph read(const YAML::Node& node) {
    CheckedMap map(node, "", problems_);
    if (!node.IsMap()) return graph_;
    int version = 0;
    map.require("version", "1");
    map.read<int>("version", version, "1", config::between(1, 1));
    map.read("name", graph_.name, "a name");
    map.read<double>("fps", graph_.fps, "frames a second, 1 to 1000", config::between(1.0, 1000.0));
    map.require("clips", "the clips by name");
    map.require("states", "at least one state by name");
    map.require("start", "the state it begins in");
    each(map, "clips", [&](CheckedMap& entry, const std::string& name) { read_clip(entry, name); });
    each(map, "states", [&](CheckedMap& entry, const std::string& name) { read_state(entry, name); });
    if (states_.empty() && map.find("states").IsDefined())
      map.wrong(map.find("states"), "states", "at least one state by name");
    map.read<std::string>("start", graph_.start, expected(states_), config::in(states_));
    each(map, "transitions", [&](CheckedMap& entry, const std::string& name) { read_transition(entry, name); });
    map.refuse_unknown_keys();
    return graph_;
  }

 private:
  static std::string expected(const Words& words) { return config::one_of(words); }

  template <class Read>
  void each(CheckedMap& map, const std::string& key, const Read& read) {
    const auto node = map.find(key);
    if (!node) return;
    if (!node.IsMap()) return map.wrong(node, key, "a mapping of names");
    for (const auto& entry : node) {
      CheckedMap child(entry.second, key + "." + entry.first.Scalar(), problems_);
      if (!entry.second.IsMap()) continue;
      read(child, entry.first.Scalar());
      child.refuse_unknown_keys();
    }
  }

  static void read_side(CheckedMap& map, Side& side) {
    static const Words kFeet{"left", "right"};
    std::string foot = "left";
    map.read<std::string>("foot", foot, "left or right", config::in(kFeet));
    side = foot == "left" ? Side::left : Side::right;
  }

  template <class Read>
  void each_of_list(CheckedMap& map, const std::string& key, const Read& read) {
    const auto node = map.find(key);
    if (!node) return;
    if (!node.IsSequence()) return map.wrong(node, key, "a list");
    for (std::size_t i = 0; i < node.size(); ++i) {
      CheckedMap entry(node[i], fmt::format("{}[{}]", map.path_of(key), i), problems_);
      if (!node[i].IsMap()) continue;
      read(entry);
      entry.refuse_unknown_keys();
    }
  }

  void read_clip(CheckedMap& map, const std::string& name) {
    MotionClip clip{.name = name};
    map.require("frames", "how many frames it has");
    map.read("take", clip.take, "the take it is made of");
    map.read<int>("frames", clip.frames, "2 to 100000", config::between(2, 100000));
    double heading = 0.0;
    map.read<double>("heading_deg", heading, "degrees, -360 to 360", config::between(-360.0, 360.0));
    clip.heading = heading * kDegree;
    map.read<double>("speed", clip.speed, "m/s, 0 to 20", config::between(0.0, 20.0));
    each_of_list(map, "heel_strikes", [&](CheckedMap& entry) {
      HeelStrike strike;
      entry.read<int>("frame", strike.frame, frames_of(clip), config::between(0, clip.frames));
      read_side(entry, strike.side);
      clip.strikes.push_back(strike);
    });
    each_of_list(map, "contacts", [&](CheckedMap& entry) {
      FootContact contact;
      entry.read<int>("begin", contact.begin, frames_of(clip), config::between(0, clip.frames));
      entry.read<int>("end", contact.end, frames_of(clip), config::between(0, clip.frames));
      entry.read("x", contact.place.x(), "metres");
      entry.read("y", contact.place.y(), "metres");
      read_side(entry, contact.side);
      clip.contacts.push_back(contact);
    });
    clips_.insert(name);
    graph_.clips.push_back(std::move(clip));
  }

  static std::string frames_of(const MotionClip& clip) {
    return fmt::format("a frame of the clip, 0 to {}", clip.frames);
  }

  // A seam needs its blended frames of both clips.
  void read_join(CheckedMap& map, const std::string& from, const std::string& to, Join& join) {
    map.read<int>("blend", join.blend, "1 to 50 frames", config::between(1, 50));
    const int left = last_of(from, join.blend), entered = last_of(to, join.blend);
    map.require("leave", "the first blended frame of the clip that is left");
    map.require("enter", "the frame entered there");
    map.read<int>("leave", join.leave, fmt::format("0 to {}: {} blended frames of clip {}", left, join.blend, from),
                  config::between(0, left));
    map.read<int>("enter", join.enter, fmt::format("0 to {}: {} blended frames of clip {}", entered, join.blend, to),
                  config::between(0, entered));
    map.read("x", join.pose.x, "metres");
    map.read("y", join.pose.y, "metres");
    double turn = 0.0;
    map.read("turn_deg", turn, "degrees");
    join.pose.yaw = turn * kDegree;
    map.read("error_mm", join.price.error_mm, "mm");
    map.read("largest_mm", join.price.largest_mm, "mm");
    map.read("step_ratio", join.price.step_ratio, "a number");
    map.read("colour", join.price.colour, "of 255");
    map.read("slide_mm", join.price.slide_mm, "mm");
  }

  int last_of(const std::string& clip, int blend) const {
    for (const auto& one : graph_.clips)
      if (one.name == clip) return std::max(0, one.frames - blend);
    return 1 << 30;  // told already: there is no such clip
  }

  void read_state(CheckedMap& map, const std::string& name) {
    MotionState state{.name = name};
    map.require("clip", expected(clips_));
    map.read<std::string>("clip", state.clip, expected(clips_), config::in(clips_));
    map.require("loop", "where the cycle closes: {leave: FRAME, enter: FRAME}");
    if (const auto node = map.find("loop")) {
      CheckedMap loop(node, map.path_of("loop"), problems_);
      if (node.IsMap()) read_join(loop, state.clip, state.clip, state.loop);
      if (node.IsMap() && state.period() < 2)
        loop.wrong(loop.find("enter"), "enter", "a frame before leave: the cycle goes back");
      loop.refuse_unknown_keys();
    }
    states_.insert(name);
    graph_.states.push_back(std::move(state));
  }

  std::string clip_of(const std::string& state) const {
    for (const auto& one : graph_.states)
      if (one.name == state) return one.clip;
    return "";
  }

  void read_transition(CheckedMap& map, const std::string& name) {
    MotionTransition transition{.name = name};
    for (const auto& [key, into] : {std::pair("from", &transition.from), std::pair("to", &transition.to)}) {
      map.require(key, expected(states_));
      map.read<std::string>(key, *into, expected(states_), config::in(states_));
    }
    bool synthesised = false;
    map.read("synthesised", synthesised, "true or false");
    map.read<std::string>("clip", transition.clip, expected(clips_), config::in(clips_));
    if (transition.clip.empty() && !synthesised) map.require("clip", expected(clips_) + ", or synthesised: true");
    const std::string entered = transition.clip.empty() ? clip_of(transition.to) : transition.clip;
    map.require("leaves", "a list of seams {leave: FRAME, enter: FRAME}");
    each_of_list(map, "leaves", [&](CheckedMap& entry) {
      transition.leaves.emplace_back();
      read_join(entry, clip_of(transition.from), entered, transition.leaves.back());
    });
    if (const auto node = map.find("leaves"); node && node.IsSequence() && node.size() == 0)
      map.wrong(node, "leaves", "at least one seam");
    if (!transition.clip.empty()) map.require("arrive", "the seam into " + transition.to);
    if (const auto node = map.find("arrive"); node && node.IsMap()) {
      CheckedMap arrive(node, map.path_of("arrive"), problems_);
      read_join(arrive, transition.clip, clip_of(transition.to), transition.arrive);
      for (const auto& leave : transition.leaves)
        if (!transition.clip.empty() && leave.enter >= transition.arrive.leave)
          arrive.wrong(arrive.find("leave"), "leave", "a frame after those that the leaves enter");
      arrive.refuse_unknown_keys();
    }
    graph_.transitions.push_back(std::move(transition));
  }

  Problems& problems_;
  MotionGraph graph_;
  Words clips_, states_;
};

YAML::Node load(const fs::path& file) {
  std::error_code none;
  if (!fs::is_regular_file(file, none))
    throw InvalidInput(file.parent_path().string() +
                       " is no character: it has no graph.yaml; make one with rotunda character build");
  if (fs::file_size(file) > kLargestFile) throw ConfigError(file, {{0, 0, "", "is longer than a graph can be, 4 MiB"}});
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  if (!stream) throw std::system_error(errno, std::generic_category(), file.string());
  try {
    return YAML::Load(text.str());
  } catch (const YAML::Exception& error) {
    throw ConfigError(file, {{error.mark.line + 1, error.mark.column + 1, "", error.msg}});
  }
}

}  // namespace

void write_graph(const fs::path& file, const MotionGraph& graph) {
  const auto part = file.parent_path() / ("." + file.filename().string());
  {
    std::ofstream stream(part);
    stream << graph_text(graph);
    stream.close();
    if (!stream) throw std::system_error(errno, std::generic_category(), part.string());
  }
  fs::rename(part, file);
}

MotionGraph read_graph(const fs::path& file) {
  const auto node = load(file);
  Problems problems;
  MotionGraph graph = GraphReader(problems).read(node);
  if (!problems.empty()) throw ConfigError(file, std::move(problems));
  return graph;
}

}  // namespace rotunda::recon
