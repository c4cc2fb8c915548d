#include "capture/source/genicam_description.h"

#include <fmt/format.h>
#include <libxml/xmlreader.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

namespace rotunda::capture {
namespace {

// Many times what large cameras have (2 MB, 10 000 nodes, chains of 20 nodes, thousands of steps a value).
constexpr std::size_t kMostBytes = 16 << 20;
constexpr std::size_t kMostZippedBytes = 1 << 20;  // which may grow a thousandfold
constexpr std::size_t kMostNodes = 200'000;
constexpr int kDeepestElement = 32;
constexpr int kLongestChain = 200;
constexpr double kMostSteps = 1e5;

// The elements by which one node's value is made of others'. Limits, availability and selection are not: two
// nodes may well limit each other.
const std::set<std::string, std::less<>> kValueLinks{"pValue",        "pVariable", "pAddress", "pIndex",
                                                     "pValueIndexed", "pLength",   "pOffset",  "pValueDefault"};

const std::set<std::string, std::less<>> kNamedButNoNodes{"Group", "EnumEntry"};

struct Node {
  std::vector<std::string> needs;  // names of nodes
  int chain = 0;                   // longest way from here to a node that needs none; 0: not known yet
  double steps = 0.0;              // to evaluate it
  bool open = false;               // being evaluated
};
using Nodes = std::unordered_map<std::string, Node>;

std::string_view view_of(const xmlChar* text) {
  return text ? reinterpret_cast<const char*>(text) : "";
}

// The nodes with what they need.
class DescriptionReader {
 public:
  explicit DescriptionReader(std::string_view xml)
      : reader_(xmlReaderForMemory(xml.data(), static_cast<int>(xml.size()), nullptr, nullptr,
                                   XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING),
                xmlFreeTextReader) {}

  // Says what is wrong; empty: nothing.
  std::string read(Nodes& nodes) {
    if (!reader_) return "is no XML";
    int result = 0;
    while ((result = xmlTextReaderRead(reader_.get())) == 1) {
      if (auto problem = look(nodes); !problem.empty()) return problem;
    }
    return result == 0 ? "" : "is no whole XML";
  }

 private:
  std::string look(Nodes& nodes) {
    const int kind = xmlTextReaderNodeType(reader_.get());
    const int depth = xmlTextReaderDepth(reader_.get());
    if (kind == XML_READER_TYPE_ENTITY_REFERENCE) return "refers to entities";
    if (depth > kDeepestElement) return fmt::format("nests its elements more than {} deep", kDeepestElement);
    if (kind == XML_READER_TYPE_ELEMENT) begin(nodes, depth);
    if (kind == XML_READER_TYPE_END_ELEMENT) end(depth);
    if ((kind == XML_READER_TYPE_TEXT || kind == XML_READER_TYPE_CDATA) && link_depth_ >= 0)
      for (const auto& around : around_)
        nodes[around.name].needs.push_back(trimmed(view_of(xmlTextReaderConstValue(reader_.get()))));
    return nodes.size() > kMostNodes ? fmt::format("has more than {} nodes", kMostNodes) : "";
  }

  // A link belongs to every node around it: whatever the library makes of nested ones, none is overlooked.
  void begin(Nodes& nodes, int depth) {
    if (xmlTextReaderIsEmptyElement(reader_.get())) return;
    const std::string_view element = view_of(xmlTextReaderConstLocalName(reader_.get()));
    if (element.substr(0, 1) == "p" && kValueLinks.count(element) > 0) {
      link_depth_ = depth;
      return;
    }
    if (xmlTextReaderHasAttributes(reader_.get()) != 1 || kNamedButNoNodes.count(element) > 0) return;
    const std::unique_ptr<xmlChar, decltype(xmlFree)> name(
        xmlTextReaderGetAttribute(reader_.get(), reinterpret_cast<const xmlChar*>("Name")), xmlFree);
    if (!name) return;
    around_.push_back({std::string(view_of(name.get())), depth});
    nodes.try_emplace(around_.back().name);
  }

  void end(int depth) {
    if (depth <= link_depth_) link_depth_ = -1;
    while (!around_.empty() && around_.back().depth >= depth) around_.pop_back();
  }

  static std::string trimmed(std::string_view text) {
    const auto from = text.find_first_not_of(" \t\r\n"), to = text.find_last_not_of(" \t\r\n");
    return std::string(from == std::string_view::npos ? "" : text.substr(from, to - from + 1));
  }

  std::unique_ptr<xmlTextReader, decltype(&xmlFreeTextReader)> reader_;
  struct Around {
    std::string name;
    int depth;
  };
  std::vector<Around> around_;  // the nodes that are being described
  int link_depth_ = -1;         // of the link that is being read
};

// What evaluating it takes, in `chain` and `steps`; the problem if it cannot be. Recurses kLongestChain deep at most.
std::string evaluate(Nodes& nodes, const std::string& name, int depth) {
  const auto found = nodes.find(name);
  if (found == nodes.end() || found->second.chain > 0) return "";
  Node& node = found->second;
  if (node.open) return fmt::format("has a node \"{}\" whose value needs itself", name.substr(0, 64));
  if (depth >= kLongestChain) return fmt::format("has values of more than {} nodes in a row", kLongestChain);
  node.open = true;
  int chain = 1;
  double steps = 1.0;
  for (const auto& need : node.needs) {
    if (auto problem = evaluate(nodes, need, depth + 1); !problem.empty()) return problem;
    if (const auto other = nodes.find(need); other != nodes.end()) {
      chain = std::max(chain, other->second.chain + 1);
      steps += other->second.steps;
    }
  }
  node.open = false;
  node.chain = chain;
  node.steps = steps;
  if (chain > kLongestChain) return fmt::format("has values of more than {} nodes in a row", kLongestChain);
  return steps > kMostSteps
             ? fmt::format("has a node \"{}\" that takes more than {:g} steps", name.substr(0, 64), kMostSteps)
             : "";
}

std::optional<std::uint64_t> hexadecimal(std::string_view text) {
  if (text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X')) text.remove_prefix(2);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
  return error == std::errc{} && end != text.data() ? std::optional(number) : std::nullopt;
}

bool begins_with_word(std::string_view text, std::string_view word) {
  return text.size() >= word.size() && std::equal(word.begin(), word.end(), text.begin(), [](char a, char b) {
           return a == std::tolower(static_cast<unsigned char>(b));
         });
}

}  // namespace

std::string url_problem(std::string_view url) {
  if (url.empty()) return "";
  if (!begins_with_word(url, "local:"))
    return fmt::format("lies elsewhere than in the camera (\"{}\"), and such places are not followed",
                       url.substr(0, 64));
  const auto address = url.find(';');
  const auto size = address == std::string_view::npos ? address : url.find(';', address + 1);
  const auto bytes = size == std::string_view::npos ? std::nullopt : hexadecimal(url.substr(size + 1));
  if (!bytes) return fmt::format("lies at no place that can be read (\"{}\")", url.substr(0, 64));
  const bool zipped = begins_with_word(url.substr(address < 4 ? 0 : address - 4), ".zip");
  const auto most = zipped ? kMostZippedBytes : kMostBytes;
  return *bytes > most ? fmt::format("claims to be {} bytes long; {} is the most", *bytes, most) : "";
}

std::string description_problem(std::string_view xml) {
  if (xml.size() > kMostBytes) return fmt::format("is {} bytes long; {} is the most", xml.size(), kMostBytes);
  Nodes nodes;
  if (auto problem = DescriptionReader(xml).read(nodes); !problem.empty()) return problem;
  std::vector<std::string> names;
  for (const auto& [name, node] : nodes) names.push_back(name);
  std::sort(names.begin(), names.end());  // the same problem every time
  for (const auto& name : names)
    if (auto problem = evaluate(nodes, name, 0); !problem.empty()) return problem;
  return "";
}

}  // namespace rotunda::capture
