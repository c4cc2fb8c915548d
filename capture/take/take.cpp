#include "capture/take/take.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "capture/take/atomic_file.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr int kFormatVersion = 1;
constexpr int kLargestSide = 65536;  // pixels; a larger number is a damaged file, not a camera

constexpr std::array<std::pair<TakeState, std::string_view>, 3> kStates{{
    {TakeState::recording, "recording"},
    {TakeState::complete, "complete"},
    {TakeState::recovered, "recovered"},
}};

std::optional<TakeState> state_from(std::string_view name) {
  for (const auto& [state, word] : kStates)
    if (word == name) return state;
  return std::nullopt;
}

// One mapping of take.yaml; collects what is wrong with it.
class Fields {
 public:
  Fields(const YAML::Node& map, std::string path, std::vector<ConfigProblem>& problems)
      : map_(map), path_(std::move(path)), problems_(problems) {}

  template <class T>
  T get(const char* key, const char* expected) const {
    const YAML::Node node = map_[key];
    if (!node) return problem(map_, key, fmt::format("is missing, expected {}", expected)), T{};
    try {
      return node.as<T>();
    } catch (const YAML::Exception&) {
      return problem(node, key, fmt::format("expected {}", expected)), T{};
    }
  }

  template <class T>
  T get_or(const char* key, const char* expected, T otherwise) const {
    return map_[key] ? get<T>(key, expected) : otherwise;
  }

  void demand(bool fine, const char* key, const std::string& message) const {
    if (!fine && map_[key]) problem(map_[key], key, message);
  }

 private:
  void problem(const YAML::Node& place, const char* key, const std::string& message) const {
    const YAML::Mark mark = place.Mark();
    problems_.push_back({.line = mark.line + 1, .column = mark.column + 1, .key = path_ + key, .message = message});
  }

  YAML::Node map_;
  std::string path_;
  std::vector<ConfigProblem>& problems_;
};

TakeCamera read_camera(const Fields& fields) {
  TakeCamera camera;
  camera.name = fields.get<std::string>("name", "the camera's name");
  camera.width = fields.get<int>("width", "pixels");
  camera.height = fields.get<int>("height", "pixels");
  camera.frames = fields.get_or<std::size_t>("frames", "a count", 0);
  camera.missing = fields.get_or<std::size_t>("missing", "a count", 0);
  for (const auto reason : hole_reasons()) {
    const auto count = fields.get_or<std::size_t>(std::string(to_string(reason)).c_str(), "a count", 0);
    if (count > 0) camera.missing_because[reason] = count;
  }
  const auto name = fields.get<std::string>("format", "a pixel format such as BayerRG8");
  const auto format = pixel_format_from(name);
  fields.demand(format.has_value(), "format", fmt::format("'{}' is not a pixel format this version knows", name));
  camera.format = format.value_or(PixelFormat::mono8);
  const auto coding = fields.get_or<std::string>("ycbcr", "a coding such as bt601-limited", "bt601-limited");
  fields.demand(ycbcr_coding_from(coding).has_value(), "ycbcr",
                fmt::format("'{}' is not bt601-limited, bt601-full, bt709-limited or bt709-full", coding));
  camera.ycbcr = ycbcr_coding_from(coding).value_or(YcbcrCoding::bt601_limited);
  fields.demand(valid_take_name(camera.name), "name", "cannot be a file name");
  fields.demand(camera.width > 0 && camera.width <= kLargestSide, "width", "expected 1 to 65536 pixels");
  fields.demand(camera.height > 0 && camera.height <= kLargestSide, "height", "expected 1 to 65536 pixels");
  return camera;
}

std::vector<TakeCamera> read_cameras(const YAML::Node& list, std::vector<ConfigProblem>& problems) {
  std::vector<TakeCamera> cameras;
  std::set<CameraId> names;
  if (!list || !list.IsSequence() || list.size() == 0) {
    problems.push_back({.line = list ? list.Mark().line + 1 : 0,
                        .column = list ? list.Mark().column + 1 : 0,
                        .key = "cameras",
                        .message = "expected a list of cameras"});
    return cameras;
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Fields fields(list[i], fmt::format("cameras[{}].", i), problems);
    if (!list[i].IsMap()) {
      problems.push_back({.line = list[i].Mark().line + 1,
                          .column = list[i].Mark().column + 1,
                          .key = fmt::format("cameras[{}]", i),
                          .message = "expected name, width, height and format"});
      continue;
    }
    cameras.push_back(read_camera(fields));
    fields.demand(names.insert(cameras.back().name).second, "name", "is there twice");
  }
  return cameras;
}

std::chrono::nanoseconds microseconds(const Fields& fields, const char* key) {
  const auto us = fields.get_or<double>(key, "microseconds", 0.0);
  fields.demand(std::abs(us) < 1e12, key, "expected microseconds");
  return std::chrono::nanoseconds(std::llround(std::abs(us) < 1e12 ? us * 1e3 : 0.0));
}

SyncSummary read_sync(const YAML::Node& map, std::size_t cameras, std::vector<ConfigProblem>& problems) {
  SyncSummary sync;
  if (!map.IsMap()) return sync;
  const Fields fields(map, "sync.", problems);
  sync.sets = fields.get_or<std::uint64_t>("sets", "a count", 0);
  sync.spread_median = microseconds(fields, "spread_median_us");
  sync.spread_p99 = microseconds(fields, "spread_p99_us");
  sync.spread_max = microseconds(fields, "spread_max_us");
  const YAML::Node list = map["cameras"];
  for (std::size_t i = 0; list && list.IsSequence() && i < std::min(list.size(), cameras); ++i) {
    const Fields camera(list[i], fmt::format("sync.cameras[{}].", i), problems);
    if (!list[i].IsMap()) break;
    sync.cameras.push_back({.offset = microseconds(camera, "offset_us"),
                            .jitter = microseconds(camera, "jitter_us"),
                            .drift_ppm = camera.get_or<double>("drift_ppm", "a number", 0.0)});
  }
  return sync;
}

TakeInfo read_info(const YAML::Node& root, std::vector<ConfigProblem>& problems) {
  const Fields fields(root, "", problems);
  TakeInfo info;
  const int version = fields.get<int>("version", "the format's version, 1");
  fields.demand(version == kFormatVersion, "version", fmt::format("is {}; this program reads 1", version));
  const auto state = fields.get<std::string>("state", "recording, complete or recovered");
  fields.demand(state_from(state).has_value(), "state", "expected recording, complete or recovered");
  info.state = state_from(state).value_or(TakeState::recording);
  info.fps = fields.get<double>("fps", "frame sets a second");
  fields.demand(std::isfinite(info.fps) && info.fps > 0.0, "fps", "expected a number above 0");
  info.start = Timestamp(std::chrono::nanoseconds(fields.get<std::int64_t>("start_tai_ns", "nanoseconds")));
  info.recorded = fields.get_or<std::string>("recorded", "a date", "");
  info.slate = fields.get_or<std::string>("slate", "text", "");
  info.scene = fields.get_or<std::string>("scene", "text", "");
  info.shot = fields.get_or<std::string>("shot", "text", "");
  info.take_number = fields.get_or<int>("take", "a number", 0);
  info.circled = fields.get_or<bool>("circled", "true or false", false);
  info.note = fields.get_or<std::string>("note", "text", "");
  info.rig = fields.get_or<std::string>("rig", "the rig's name", "");
  info.first_trigger = fields.get_or<std::uint64_t>("first_trigger", "a trigger number", 0);
  info.frame_sets = fields.get_or<std::size_t>("frame_sets", "a count", 0);
  info.complete_sets = fields.get_or<std::size_t>("complete_sets", "a count", 0);
  info.cameras = read_cameras(root["cameras"], problems);
  if (root["sync"]) info.sync = read_sync(root["sync"], info.cameras.size(), problems);
  return info;
}

std::string name_of(const fs::path& folder) {
  const auto path = fs::absolute(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

void emit_camera(YAML::Emitter& out, const TakeCamera& camera) {
  out << YAML::Flow << YAML::BeginMap;
  out << YAML::Key << "name" << YAML::Value << camera.name;
  out << YAML::Key << "width" << YAML::Value << camera.width;
  out << YAML::Key << "height" << YAML::Value << camera.height;
  out << YAML::Key << "format" << YAML::Value << std::string(to_string(camera.format));
  if (is_ycbcr(camera.format)) out << YAML::Key << "ycbcr" << YAML::Value << std::string(to_string(camera.ycbcr));
  out << YAML::Key << "frames" << YAML::Value << camera.frames;
  out << YAML::Key << "missing" << YAML::Value << camera.missing;
  for (const auto& [reason, count] : camera.missing_because)
    out << YAML::Key << std::string(to_string(reason)) << YAML::Value << count;
  out << YAML::EndMap;
}

using Microseconds = std::chrono::duration<double, std::micro>;

void emit_sync(YAML::Emitter& out, const SyncSummary& sync) {
  out << YAML::Key << "sync" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "sets" << YAML::Value << sync.sets;
  out << YAML::Key << "spread_median_us" << YAML::Value << Microseconds(sync.spread_median).count();
  out << YAML::Key << "spread_p99_us" << YAML::Value << Microseconds(sync.spread_p99).count();
  out << YAML::Key << "spread_max_us" << YAML::Value << Microseconds(sync.spread_max).count();
  out << YAML::Key << "cameras" << YAML::Value << YAML::BeginSeq;
  for (const auto& camera : sync.cameras) {
    out << YAML::Flow << YAML::BeginMap;
    out << YAML::Key << "offset_us" << YAML::Value << Microseconds(camera.offset).count();
    out << YAML::Key << "jitter_us" << YAML::Value << Microseconds(camera.jitter).count();
    out << YAML::Key << "drift_ppm" << YAML::Value << camera.drift_ppm << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
}

std::string to_yaml(const TakeInfo& info) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  out << YAML::Key << "version" << YAML::Value << kFormatVersion;
  out << YAML::Key << "slate" << YAML::Value << info.slate;
  if (info.take_number > 0) {
    out << YAML::Key << "scene" << YAML::Value << info.scene;
    out << YAML::Key << "shot" << YAML::Value << info.shot;
    out << YAML::Key << "take" << YAML::Value << info.take_number;
  }
  if (info.circled) out << YAML::Key << "circled" << YAML::Value << true;
  out << YAML::Key << "note" << YAML::Value << info.note;
  out << YAML::Key << "rig" << YAML::Value << info.rig;
  out << YAML::Key << "state" << YAML::Value << std::string(to_string(info.state));
  out << YAML::Key << "recorded" << YAML::Value << info.recorded;
  out << YAML::Key << "start_tai_ns" << YAML::Value << info.start.time_since_epoch().count();
  out << YAML::Key << "fps" << YAML::Value << info.fps;
  out << YAML::Key << "first_trigger" << YAML::Value << info.first_trigger;
  out << YAML::Key << "frame_sets" << YAML::Value << info.frame_sets;
  out << YAML::Key << "complete_sets" << YAML::Value << info.complete_sets;
  out << YAML::Key << "cameras" << YAML::Value << YAML::BeginSeq;
  for (const auto& camera : info.cameras) emit_camera(out, camera);
  out << YAML::EndSeq;
  if (info.sync.sets > 0) emit_sync(out, info.sync);
  out << YAML::EndMap;
  return std::string(out.c_str()) + '\n';
}

YAML::Node load(const fs::path& file) {
  if (!fs::is_regular_file(file))
    throw InvalidInput(file.parent_path().string() +
                       " has no take.yaml; if it is a take, `rotunda take recover` makes the file anew");
  try {
    YAML::Node root = YAML::LoadFile(file.string());
    if (root.IsMap()) return root;
  } catch (const YAML::ParserException& error) {
    throw ConfigError(file, {{.line = error.mark.line + 1,
                              .column = error.mark.column + 1,
                              .key = "",
                              .message = error.msg + "; `rotunda take recover` makes the file anew"}});
  } catch (const YAML::Exception& error) {
    throw ConfigError(file, {{.line = 0, .column = 0, .key = "", .message = error.msg}});
  }
  throw ConfigError(file, {{.line = 1,
                            .column = 1,
                            .key = "",
                            .message = "expected keys and values; `rotunda take recover` makes the file anew"}});
}

// Cameras' files are enough: take.yaml can be made anew.
bool holds_take(const fs::path& folder) {
  if (fs::exists(folder / "take.yaml")) return true;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    if (entry.path().extension() == ".mkv") return true;
  return false;
}

}  // namespace

std::string_view to_string(TakeState state) {
  return std::find_if(kStates.begin(), kStates.end(), [&](const auto& row) { return row.first == state; })->second;
}

TakeInfo read_take_info(const fs::path& folder) {
  const fs::path file = folder / "take.yaml";
  std::vector<ConfigProblem> problems;
  TakeInfo info = read_info(load(file), problems);
  if (!problems.empty()) throw ConfigError(file, std::move(problems));
  info.name = name_of(folder);
  return info;
}

void write_take_info(const fs::path& folder, const TakeInfo& info) {
  replace_file(folder / "take.yaml", to_yaml(info));
}

bool valid_take_name(std::string_view name) {
  constexpr std::size_t longest = 100;
  if (name.empty() || name.size() > longest || name.front() == '.' || name.front() == '-') return false;
  if (name.front() == ' ' || name.back() == ' ' || name.back() == '.') return false;
  return std::none_of(name.begin(), name.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7F || std::string_view("/\\:*?\"<>|").find(c) != std::string_view::npos;
  });
}

std::vector<TakeInfo> list_takes(const fs::path& root, std::vector<std::string>* problems) {
  std::vector<TakeInfo> takes;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(root, none)) {
    if (!fs::exists(entry.path() / "take.yaml")) continue;
    if (!valid_take_name(entry.path().filename().string())) continue;  // an import under way
    try {
      takes.push_back(read_take_info(entry.path()));
    } catch (const std::exception& error) {
      if (problems != nullptr) problems->emplace_back(error.what());
    }
  }
  std::sort(takes.begin(), takes.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return takes;
}

int next_take_number(const fs::path& root, std::string_view scene, std::string_view shot) {
  int last = 0;
  for (const auto& take : list_takes(root))
    if (take.scene == scene && take.shot == shot) last = std::max(last, take.take_number);
  return last + 1;
}

std::string slate_text(std::string_view scene, std::string_view shot, int take_number) {
  if (take_number <= 0) return "";
  return fmt::format("{}{}{} {}", scene, scene.empty() || shot.empty() ? "" : " ", shot, take_number);
}

fs::path resolve_take(const std::string& name_or_path, const fs::path& root) {
  if (valid_take_name(name_or_path) && holds_take(root / name_or_path)) return root / name_or_path;
  if (holds_take(name_or_path)) return name_or_path;
  std::string known;
  for (const auto& take : list_takes(root)) known += (known.empty() ? "" : ", ") + take.name;
  throw InvalidInput(fmt::format("there is no take '{}': {} holds {}", name_or_path, root.string(),
                                 known.empty() ? "no takes" : known));
}

fs::path camera_file(const fs::path& folder, const CameraId& camera) {
  return folder / (camera + ".mkv");
}
fs::path calibration_file(const fs::path& folder) {
  return folder / "calibration.yaml";
}
fs::path background_file(const fs::path& folder, const CameraId& camera) {
  return folder / "background" / (camera + ".png");
}
fs::path matte_file(const fs::path& folder, const CameraId& camera, std::size_t frame) {
  return folder / "mattes" / camera / frame_file_name(frame);
}

std::string frame_file_name(std::size_t frame, std::string_view extension) {
  return fmt::format("frame{:06}.{}", frame, extension);
}

}  // namespace rotunda::capture
