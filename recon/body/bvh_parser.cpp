// The reading half of bvh.h: tokens, then the hierarchy with a stack of its own (a file may nest as it likes), then
// one line a frame.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "config/errors.h"
#include "recon/body/bvh.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kMostJoints = 4096, kDeepest = 512;
constexpr double kLargest = 1e7;  // of any number: ten kilometres in millimetres, or as many degrees

bool same_word(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

// Takes words and lines off the front of the text, counting lines from 1.
class Scanner {
 public:
  Scanner(std::string_view text, const std::filesystem::path& file) : rest_(text), file_(file) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw CorruptData(fmt::format("{}:{}: {}", file_.string(), line_, what));
  }

  // The next word or brace; empty at the end of the file.
  std::string_view word() {
    skip_blanks(true);
    if (!rest_.empty() && (rest_.front() == '{' || rest_.front() == '}')) return take(1);
    return take(word_length());
  }
  // The rest of this line up to a brace, blanks trimmed: names may hold spaces.
  std::string_view name() {
    skip_blanks(false);
    const auto end = std::min(rest_.find_first_of("\n{}"), rest_.size());
    auto found = take(end);
    while (!found.empty() && is_blank(found.back())) found.remove_suffix(1);
    return found;
  }
  // The next word of this line; empty at its end.
  std::string_view word_in_line() {
    skip_blanks(false);
    return take(word_length());
  }
  void end_line(std::string_view after) {
    if (const auto more = word_in_line(); !more.empty()) refuse(fmt::format("{} goes on with {}", after, shown(more)));
  }
  bool at_end() {
    skip_blanks(true);
    return rest_.empty();
  }

  void expect(std::string_view wanted) {
    const auto found = word();
    if (!same_word(found, wanted)) refuse(fmt::format("expected '{}', found {}", wanted, shown(found)));
  }
  double number(std::string_view text, std::string_view what) const {
    auto digits = text;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || digits.empty())
      refuse(fmt::format("expected a number ({}), found {}", what, shown(text)));
    if (!(std::abs(value) <= kLargest)) refuse(fmt::format("{} is no sensible {}", shown(text), what));
    return value;
  }
  std::size_t count(std::string_view what, std::size_t most) {
    const auto text = word();
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value > most)
      refuse(fmt::format("expected {} (0 to {}), found {}", what, most, shown(text)));
    return value;
  }
  std::size_t bytes_left() const { return rest_.size(); }

  static std::string shown(std::string_view word) {
    if (word.empty()) return "the end";
    std::string text(word.substr(0, 40));
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return std::isprint(c) == 0; }, '?');
    return "'" + text + "'";
  }

 private:
  std::string_view take(std::size_t length) {
    const auto taken = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return taken;
  }
  std::size_t word_length() const { return std::min(rest_.find_first_of(" \t\r\v\f\n{}"), rest_.size()); }
  void skip_blanks(bool lines_too) {
    while (!rest_.empty() && (is_blank(rest_.front()) || (lines_too && rest_.front() == '\n'))) {
      if (rest_.front() == '\n') ++line_;
      rest_.remove_prefix(1);
    }
  }

  std::string_view rest_;
  const std::filesystem::path& file_;
  std::size_t line_ = 1;
};

Eigen::Vector3d read_offset(Scanner& scan) {
  Eigen::Vector3d offset;
  for (int i = 0; i < 3; ++i) offset[i] = scan.number(scan.word(), "offset");
  return offset;
}

BvhChannel channel_named(const Scanner& scan, std::string_view name) {
  for (std::size_t i = 0; i < kBvhChannelNames.size(); ++i)
    if (same_word(name, kBvhChannelNames[i])) return static_cast<BvhChannel>(i);
  scan.refuse(fmt::format("there is no channel {}; channels are Xposition to Zrotation", Scanner::shown(name)));
}

std::vector<BvhChannel> read_channels(Scanner& scan) {
  std::vector<BvhChannel> channels;
  const std::size_t number = scan.count("a number of channels", 6);
  for (std::size_t i = 0; i < number; ++i) {
    channels.push_back(channel_named(scan, scan.word()));
    if (std::count(channels.begin(), channels.end(), channels.back()) > 1 && channels.back() < BvhChannel::x_rotation)
      scan.refuse("a position channel stands twice");
  }
  return channels;
}

// A joint whose braces are open, and what of it has been read.
struct Open {
  std::size_t joint;
  bool has_offset = false, has_channels = false;
};

class Hierarchy {
 public:
  explicit Hierarchy(Scanner& scan) : scan_(scan) {}

  std::vector<BvhJoint> read() {
    scan_.expect("HIERARCHY");
    for (auto word = scan_.word(); !same_word(word, "MOTION"); word = scan_.word()) take(word);
    if (!open_.empty()) scan_.refuse(fmt::format("'MOTION' inside the braces of {}", name_of(open_.back())));
    if (joints_.empty()) scan_.refuse("the hierarchy has no ROOT");
    return std::move(joints_);
  }

 private:
  void take(std::string_view word) {
    if (word.empty()) scan_.refuse("the file ends within the hierarchy");
    if (same_word(word, "ROOT")) return open_.empty() ? begin(-1, false) : scan_.refuse("a ROOT inside a joint");
    if (open_.empty()) scan_.refuse(fmt::format("expected 'ROOT' or 'MOTION', found {}", Scanner::shown(word)));
    take_inside(word, open_.back());
  }
  void take_inside(std::string_view word, Open& open) {
    BvhJoint& joint = joints_[open.joint];
    if (same_word(word, "JOINT")) return begin(static_cast<int>(open.joint), false);
    if (same_word(word, "End")) {
      scan_.expect("Site");
      return begin(static_cast<int>(open.joint), true);
    }
    if (same_word(word, "OFFSET") && !open.has_offset) {
      joint.offset = read_offset(scan_);
      open.has_offset = true;
    } else if (same_word(word, "CHANNELS") && !open.has_channels && !joint.is_end_site) {
      joint.channels = read_channels(scan_);
      open.has_channels = true;
    } else if (word == "}") {
      end(open);
    } else {
      scan_.refuse(fmt::format("{} does not belong into {}", Scanner::shown(word), name_of(open)));
    }
  }
  void begin(int parent, bool is_end_site) {
    if (parent >= 0 && joints_[static_cast<std::size_t>(parent)].is_end_site)
      scan_.refuse("a joint inside an End Site");
    if (joints_.size() == kMostJoints) scan_.refuse(fmt::format("more than {} joints", kMostJoints));
    if (open_.size() == kDeepest) scan_.refuse(fmt::format("joints nest deeper than {}", kDeepest));
    BvhJoint joint;
    joint.name = scan_.name();
    joint.parent = parent;
    joint.is_end_site = is_end_site;
    if (joint.name.empty() && !is_end_site) scan_.refuse("a joint without a name");
    joints_.push_back(std::move(joint));
    open_.push_back({joints_.size() - 1});
    scan_.expect("{");
  }
  void end(const Open& open) {
    if (!open.has_offset) scan_.refuse(fmt::format("{} has no OFFSET", name_of(open)));
    open_.pop_back();
  }
  std::string name_of(const Open& open) const {
    const auto& joint = joints_[open.joint];
    return joint.is_end_site ? "an End Site" : "joint " + Scanner::shown(joint.name);
  }

  Scanner& scan_;
  std::vector<BvhJoint> joints_;
  std::vector<Open> open_;
};

void read_frame(Scanner& scan, std::size_t frame, std::size_t width, BvhMotion& motion) {
  for (std::size_t c = 0; c < width; ++c) {
    const auto word = scan.word_in_line();
    if (word.empty()) scan.refuse(fmt::format("frame {} has {} numbers instead of {}", frame, c, width));
    motion.values.push_back(scan.number(word, "value"));
  }
  scan.end_line(fmt::format("frame {}, after its {} numbers,", frame, width));
}

void read_frames(Scanner& scan, BvhMotion& motion) {
  const std::size_t width = motion.channels();
  if (width == 0) scan.refuse("no joint has a channel");
  // A number and its blank are two bytes at the least: what the header promises must be able to be there.
  if (motion.frames > (scan.bytes_left() + 1) / (2 * width))
    scan.refuse(fmt::format("{} frames of {} numbers do not fit in the {} bytes left: the file is cut", motion.frames,
                            width, scan.bytes_left()));
  motion.values.reserve(motion.frames * width);
  for (std::size_t frame = 0; frame < motion.frames; ++frame) {
    if (scan.at_end()) scan.refuse(fmt::format("the file ends after {} of {} frames", frame, motion.frames));
    read_frame(scan, frame, width, motion);
  }
  if (const auto more = scan.word(); !more.empty())
    scan.refuse(fmt::format("{} follows the {} frames announced", Scanner::shown(more), motion.frames));
}

}  // namespace

BvhMotion parse_bvh(std::string_view text, const std::filesystem::path& file) {
  Scanner scan(text, file);
  BvhMotion motion;
  motion.joints = Hierarchy(scan).read();
  scan.expect("Frames:");
  motion.frames = scan.count("a number of frames", 100'000'000);
  if (motion.frames == 0) scan.refuse("the motion has no frame");
  scan.expect("Frame");
  scan.expect("Time:");
  motion.frame_time = scan.number(scan.word(), "frame time");
  if (!(motion.frame_time >= 1e-4 && motion.frame_time <= 10.0))
    scan.refuse(fmt::format("a frame time of {} s; 0.0001 to 10 s are possible", motion.frame_time));
  scan.end_line("the frame time");
  read_frames(scan, motion);
  return motion;
}

}  // namespace rotunda::recon
