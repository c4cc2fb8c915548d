// The file half of markers.h.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <system_error>

#include "config/checked_yaml.h"
#include "config/errors.h"
#include "recon/deform/markers.h"
#include "recon/whole_file.h"

namespace rotunda::recon {
namespace {

using config::CheckedMap;
using config::Problems;

// What a file's mapping says of a body: metres, and quaternions w x y z.
class FitReader {
 public:
  FitReader(const YAML::Node& node, Problems& problems) : problems_(problems), body_(node, "body", problems) {}

  std::optional<TemplateFit> read() {
    const std::size_t before = problems_.size();
    CheckedMap measures(body_.find("measures"), "body.measures", problems_);
    BodyMeasures lengths = measures_of_height(1.75);
    for (std::size_t i = 0; i < kBodyMeasures; ++i) {
      const std::string key(to_string(static_cast<BodyMeasure>(i)));
      measures.require(key, "metres");
      measures.read<double>(key, lengths[i], "metres, 0.005 to 3", config::between(0.005, 3.0));
    }
    measures.refuse_unknown_keys();
    const Pose pose = read_pose();
    body_.refuse_unknown_keys();
    if (problems_.size() > before) return std::nullopt;
    return TemplateFit{.body = make_template(lengths), .pose = pose};
  }

 private:
  Pose read_pose() {
    Pose pose = rest_pose();
    CheckedMap turns(body_.find("pose"), "body.pose", problems_);
    std::vector<double> root(3);
    turns.require("root", "[x, y, z], metres");
    turns.read<std::vector<double>>("root", root, "[x, y, z], metres", of_size(3));
    pose.root = Eigen::Vector3d(root[0], root[1], root[2]);
    for (std::size_t j = 0; j < kBodyJoints; ++j) {
      std::vector<double> q{1, 0, 0, 0};
      turns.read<std::vector<double>>(std::string(to_string(body_joint(j))), q, "a quaternion [w, x, y, z]",
                                      of_size(4));
      pose.rotation[j] = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
    }
    turns.refuse_unknown_keys();
    return pose;
  }
  static std::function<bool(const std::vector<double>&)> of_size(std::size_t size) {
    return [size](const std::vector<double>& values) {
      double square = 0.0;
      for (const double value : values) square += value * value;
      return values.size() == size && square < 1e6 && (size != 4 || square > 0.5);
    };
  }

  Problems& problems_;
  CheckedMap body_;
};

class MarkersReader {
 public:
  explicit MarkersReader(const std::filesystem::path& file) : file_(file) {}

  Markers read() {
    YAML::Node root;
    try {
      root = YAML::LoadFile(file_.string());
    } catch (const YAML::BadFile&) {
      throw std::system_error(ENOENT, std::generic_category(), file_.string() + ": cannot be opened");
    } catch (const YAML::Exception& error) {
      throw ConfigError(file_, {{error.mark.line + 1, error.mark.column + 1, "", error.msg}});
    }
    CheckedMap map(root, "", problems_);
    Markers markers;
    std::string scan;
    map.read<std::string>("scan", scan, "the scan's file name");
    double radius_mm = 1000.0 * markers.radius;
    map.read<double>("radius_mm", radius_mm, "millimetres, 0 to 100", config::between(0.0, 100.0));
    markers.radius = 0.001 * radius_mm;
    if (const auto body = map.find("body")) markers.fit = FitReader(body, problems_).read();
    map.require("markers", "a list of pairs");
    if (const auto pairs = map.find("markers")) read_pairs(pairs, map, markers);
    map.refuse_unknown_keys();
    if (!problems_.empty()) throw ConfigError(file_, problems_);
    return markers;
  }

 private:
  void read_pairs(const YAML::Node& pairs, CheckedMap& map, Markers& markers) {
    if (!pairs.IsSequence() || pairs.size() == 0) return map.wrong(pairs, "markers", "a list of pairs, one at least");
    for (std::size_t i = 0; i < pairs.size(); ++i) read_pair(pairs[i], fmt::format("markers[{}]", i), markers);
  }
  void read_pair(const YAML::Node& node, const std::string& path, Markers& markers) {
    CheckedMap map(node, path, problems_);
    const auto triangles = kBodySegments * segment_triangles().size();
    Marker marker;
    std::string segment;
    for (const char* key : {"number", "template", "scan"}) map.require(key, "a number");
    map.read<int>("number", marker.number, "a number from 1", config::between(1, 1'000'000));
    map.read<std::uint32_t>("template", marker.template_triangle,
                            fmt::format("a triangle of the template, 0 to {}", triangles - 1),
                            config::between(0U, static_cast<std::uint32_t>(triangles - 1)));
    map.read<std::uint32_t>("scan", marker.scan_triangle, "a triangle of the scan");
    map.read<std::string>("segment", segment, "the name of the template triangle's segment");
    map.refuse_unknown_keys();
    if (!node.IsMap()) return;
    const std::size_t own = segment_of_triangle(marker.template_triangle);
    if (!segment.empty() && segment != segment_name(own))
      map.wrong(node["segment"], "segment",
                fmt::format("{}, to which template triangle {} belongs", segment_name(own), marker.template_triangle));
    for (const auto& [key, expected] : rules_.admit(marker)) map.wrong(node[key], key, expected);
    markers.pairs.push_back(marker);
  }

  std::filesystem::path file_;
  Problems problems_;
  MarkerRules rules_;
};

std::string text_of(const Eigen::Quaterniond& q) {
  return fmt::format("[{:.6f}, {:.6f}, {:.6f}, {:.6f}]", q.w(), q.x(), q.y(), q.z());
}

std::string quoted(const std::string& text) {
  YAML::Emitter out;
  out << YAML::DoubleQuoted << text;
  return out.c_str();
}

std::string text_of(const TemplateFit& fit) {
  std::string text =
      "# The template as it stands in the scan: lengths and widths, metres; turns of its joints, w x y z.\nbody:\n  "
      "measures:\n";
  for (std::size_t i = 0; i < kBodyMeasures; ++i)
    text += fmt::format("    {}: {:.4f}\n", to_string(static_cast<BodyMeasure>(i)), fit.body.measures[i]);
  const auto& root = fit.pose.root;
  text += fmt::format("  pose:\n    root: [{:.4f}, {:.4f}, {:.4f}]\n", root.x(), root.y(), root.z());
  for (std::size_t j = 0; j < kBodyJoints; ++j)
    text += fmt::format("    {}: {}\n", to_string(body_joint(j)), text_of(fit.pose.rotation[j]));
  return text;
}

}  // namespace

Markers read_markers(const std::filesystem::path& file) {
  return MarkersReader(file).read();
}

void write_markers(const std::filesystem::path& file, const Markers& markers, const std::string& scan) {
  std::string text = fmt::format(
      "# Pairs of triangles: of the body template and of the scan, counted from 0 as their files list them. Change,\n"
      "# add or take away; numbers are for people. About each the scan is held within radius_mm over its surface.\n"
      "scan: {}\nradius_mm: {:g}\n",
      quoted(scan), 1000.0 * markers.radius);
  if (markers.fit) text += text_of(*markers.fit);
  text += "markers:\n";
  for (const auto& marker : markers.pairs)
    text += fmt::format("  - {{number: {}, segment: {}, template: {}, scan: {}}}\n", marker.number,
                        segment_name(segment_of_triangle(marker.template_triangle)), marker.template_triangle,
                        marker.scan_triangle);
  write_text(file, text);
}

}  // namespace rotunda::recon
