#include "recon/body/joint_names.h"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace rotunda::recon {
namespace {

// A word for a segment. Where several joints of a side fit, the lowest rank is meant.
struct Word {
  std::string_view word;
  BodySegment segment;
  bool has_side;
  int rank = 0;
};
constexpr Word kWords[] = {
    {"hips", BodySegment::pelvis, false},        {"pelvis", BodySegment::pelvis, false},
    {"hip", BodySegment::pelvis, false},         {"spine", BodySegment::spine, false},
    {"chest", BodySegment::spine, false},        {"upperchest", BodySegment::spine, false},
    {"abdomen", BodySegment::spine, false},      {"lowerback", BodySegment::spine, false},
    {"torso", BodySegment::spine, false},        {"waist", BodySegment::spine, false},
    {"upperback", BodySegment::spine, false},    {"thorax", BodySegment::spine, false},
    {"spinemid", BodySegment::spine, false},     {"spineshoulder", BodySegment::spine, false},
    {"ab", BodySegment::spine, false},           {"spinebase", BodySegment::pelvis, false},
    {"abdomenlower", BodySegment::spine, false}, {"abdomenupper", BodySegment::spine, false},
    {"chestlower", BodySegment::spine, false},   {"chestupper", BodySegment::spine, false},
    {"neck", BodySegment::neck, false},          {"necklower", BodySegment::neck, false},
    {"neckupper", BodySegment::neck, false},     {"head", BodySegment::head, false},
    {"lowerneck", BodySegment::neck, false},     {"upperneck", BodySegment::neck, false},
    {"humerus", BodySegment::upper_arm, true},   {"uarm", BodySegment::upper_arm, true},
    {"radius", BodySegment::forearm, true},      {"farm", BodySegment::forearm, true},
    {"femur", BodySegment::thigh, true},         {"tibia", BodySegment::shank, true},
    {"clavicle", BodySegment::clavicle, true},   {"collar", BodySegment::clavicle, true},
    {"collarbone", BodySegment::clavicle, true}, {"shoulder", BodySegment::clavicle, true, 1},
    {"upperarm", BodySegment::upper_arm, true},  {"uparm", BodySegment::upper_arm, true},
    {"shldr", BodySegment::upper_arm, true},     {"shldrbend", BodySegment::upper_arm, true},
    {"arm", BodySegment::upper_arm, true, 1},    {"shoulder", BodySegment::upper_arm, true, 2},
    {"forearm", BodySegment::forearm, true},     {"lowerarm", BodySegment::forearm, true},
    {"lowarm", BodySegment::forearm, true},      {"forearmbend", BodySegment::forearm, true},
    {"elbow", BodySegment::forearm, true, 1},    {"wrist", BodySegment::hand, true},
    {"hand", BodySegment::hand, true, 1},        {"thigh", BodySegment::thigh, true},
    {"upleg", BodySegment::thigh, true},         {"upperleg", BodySegment::thigh, true},
    {"thighbend", BodySegment::thigh, true},     {"hip", BodySegment::thigh, true, 1},
    {"leg", BodySegment::thigh, true, 2},        {"shank", BodySegment::shank, true},
    {"shin", BodySegment::shank, true},          {"calf", BodySegment::shank, true},
    {"lowerleg", BodySegment::shank, true},      {"lowleg", BodySegment::shank, true},
    {"knee", BodySegment::shank, true},          {"leg", BodySegment::shank, true, 1},
    {"ankle", BodySegment::foot, true},          {"foot", BodySegment::foot, true, 1},
    {"toes", BodySegment::toes, true},           {"toe", BodySegment::toes, true},
    {"toebase", BodySegment::toes, true},        {"ball", BodySegment::toes, true},
    {"foot", BodySegment::toes, true, 1},
};

constexpr std::string_view kPrefixes[] = {"mixamorig", "bip", "character",  "joint",   "j",
                                          "c",         "def", "valvebiped", "skeleton"};

// A name in lower-case words, cut at marks, digits and humps, without digits and prefixes: "mixamorig:LeftUpLeg" is
// "left", "up", "leg".
std::vector<std::string> words_of(std::string name) {
  if (const auto colon = name.find_last_of(":|"); colon != std::string::npos) name.erase(0, colon + 1);
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const bool is_hump = std::isupper(c) != 0 && i > 0 &&
                         (std::islower(static_cast<unsigned char>(name[i - 1])) != 0 ||
                          (i + 1 < name.size() && std::islower(static_cast<unsigned char>(name[i + 1])) != 0));
    if (std::isalpha(c) == 0 || is_hump) words.emplace_back();
    if (std::isalpha(c) != 0) words.back() += static_cast<char>(std::tolower(c));
  }
  const auto is_idle = [](const std::string& word) {
    return word.empty() || std::find(std::begin(kPrefixes), std::end(kPrefixes), word) != std::end(kPrefixes);
  };
  words.erase(std::remove_if(words.begin(), words.end(), is_idle), words.end());
  return words;
}

std::optional<Side> side_of(std::string_view word) {
  if (word == "left" || word == "l" || word == "lft") return Side::left;
  if (word == "right" || word == "r" || word == "rgt") return Side::right;
  return std::nullopt;
}

bool is_word(std::string_view text) {
  return std::any_of(std::begin(kWords), std::end(kWords), [&](const Word& word) { return word.word == text; });
}

struct ReadName {
  std::string word;  // without the side
  std::optional<Side> side;
};

ReadName read_name(const std::string& name) {
  ReadName result;
  for (const auto& word : words_of(name)) {
    const auto side = side_of(word);
    if (side && !result.side)
      result.side = side;
    else
      result.word += word;
  }
  // Without humps: "leftupleg", "lthigh".
  for (const std::string_view prefix : {"left", "right", "l", "r"})
    if (!result.side && result.word.starts_with(prefix) &&
        is_word(std::string_view(result.word).substr(prefix.size()))) {
      result.side = side_of(prefix);
      result.word.erase(0, prefix.size());
    }
  return result;
}

using Named = std::vector<std::optional<NamedJoint>>;

class Namer {
 public:
  Namer(const std::vector<std::string>& names, const std::vector<int>& parents)
      : parents_(parents), named_(names.size()) {
    for (const auto& name : names) read_.push_back(read_name(name));
  }

  Named name() {
    // What is certain first: a word that two segments share goes to the one that is still without.
    for (const auto segment : {BodySegment::pelvis, BodySegment::head}) take_best(segment, std::nullopt);
    for (const auto segment : {BodySegment::spine, BodySegment::neck}) take_all(segment);
    for (const Side side : {Side::left, Side::right})
      for (const auto segment : {BodySegment::upper_arm, BodySegment::clavicle, BodySegment::forearm, BodySegment::hand,
                                 BodySegment::shank, BodySegment::thigh, BodySegment::foot, BodySegment::toes})
        take_best(segment, side);
    find_pelvis();
    return std::move(named_);
  }

 private:
  // The rank of a word as a segment, if it can mean it.
  static std::optional<int> rank(const ReadName& name, BodySegment segment, std::optional<Side> side) {
    if (name.side != side) return std::nullopt;
    for (const auto& word : kWords)
      if (word.word == name.word && word.segment == segment && word.has_side == side.has_value()) return word.rank;
    return std::nullopt;
  }
  void take_best(BodySegment segment, std::optional<Side> side) {
    std::optional<std::size_t> best;
    for (std::size_t j = 0; j < read_.size(); ++j) {
      const auto own = rank(read_[j], segment, side);
      if (!own || named_[j]) continue;
      if (!best || *own < *rank(read_[*best], segment, side)) best = j;
    }
    if (best) named_[*best] = NamedJoint{segment, side};
  }
  void take_all(BodySegment segment) {
    for (std::size_t j = 0; j < read_.size(); ++j)
      if (!named_[j] && rank(read_[j], segment, std::nullopt)) named_[j] = NamedJoint{segment, std::nullopt};
  }
  // Without a name, or called the first of the spine, it is the joint that carries both thighs.
  void find_pelvis() {
    std::vector<std::size_t> thighs;
    for (std::size_t j = 0; j < named_.size(); ++j) {
      if (named_[j] && named_[j]->segment == BodySegment::pelvis) return;
      if (named_[j] && named_[j]->segment == BodySegment::thigh) thighs.push_back(j);
    }
    if (thighs.size() != 2) return;
    std::vector<bool> is_above(named_.size(), false);
    for (int j = parents_[thighs[0]]; j >= 0; j = parents_[static_cast<std::size_t>(j)])
      is_above[static_cast<std::size_t>(j)] = true;
    for (int j = parents_[thighs[1]]; j >= 0; j = parents_[static_cast<std::size_t>(j)]) {
      auto& joint = named_[static_cast<std::size_t>(j)];
      if (!is_above[static_cast<std::size_t>(j)]) continue;
      if (!joint || joint->segment == BodySegment::spine) joint = NamedJoint{BodySegment::pelvis, std::nullopt};
      return;
    }
  }

  const std::vector<int>& parents_;
  std::vector<ReadName> read_;
  Named named_;
};

}  // namespace

Named name_joints(const std::vector<std::string>& names, const std::vector<int>& parents) {
  return Namer(names, parents).name();
}

}  // namespace rotunda::recon
