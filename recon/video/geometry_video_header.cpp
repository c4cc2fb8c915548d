#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/base/crc32c.h"
#include "config/errors.h"
#include "recon/video/geometry_video.h"
#include "recon/video/geometry_video_streams.h"

namespace rotunda::recon {
namespace {

constexpr int kFinestLevel = 12;        // 4097 samples a side
constexpr double kLargestExtent = 1e4;  // metres; footage from elsewhere may have its own unit
constexpr std::size_t kMostFrames = 10'000'000;
constexpr const char* kFormat = "rotunda geometry video";

using nlohmann::json;

[[noreturn]] void corrupt(const std::string& what) {
  throw CorruptData("geometry video header: " + what);
}

json json_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Eigen::Vector3d vector_of(const json& j, const char* what) {
  Eigen::Vector3d v(j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>());
  if (!v.allFinite() || v.cwiseAbs().maxCoeff() > kLargestExtent)
    corrupt(fmt::format("{} ({}, {}, {}) is no place", what, v.x(), v.y(), v.z()));
  return v;
}

Eigen::AlignedBox3d box_of(const json& j, const std::string& key) {
  const Eigen::AlignedBox3d box(vector_of(j.at(key).at("min"), "box min"), vector_of(j.at(key).at("max"), "box max"));
  if ((box.min().array() > box.max().array()).any()) corrupt("the " + key + " is inside out");
  return box;
}

json json_of(const Eigen::AlignedBox3d& box) {
  return {{"min", json_of(Eigen::Vector3d(box.min()))}, {"max", json_of(Eigen::Vector3d(box.max()))}};
}

VideoProfile profile_of(const std::string& name) {
  for (const auto profile : {VideoProfile::float32, VideoProfile::stream})
    if (name == to_string(profile)) return profile;
  corrupt("unknown profile \"" + name + "\"");
}

int level_of(const json& j, const char* key) {
  const auto level = j.at(key).get<std::int64_t>();
  if (level < 1 || level > kFinestLevel) corrupt(fmt::format("{} is {}, expected 1 to {}", key, level, kFinestLevel));
  return static_cast<int>(level);
}

void read_frames(const json& frames, GeometryVideoHeader& header) {
  if (!frames.is_array() || frames.empty() || frames.size() > kMostFrames)
    corrupt(fmt::format("{} frames, expected 1 to {}", frames.size(), kMostFrames));
  for (const json& frame : frames) {
    header.root_path.push_back(vector_of(frame.at("root"), "a root"));
    const auto status = frame.at("status").get<std::string>();
    if (status != "mapped" && status != "interpolated") corrupt("unknown frame status \"" + status + "\"");
    header.statuses.push_back({status == "interpolated", frame.value("reason", "")});
    if (header.version >= kColourChecksumVersion)
      header.colour_checksums.push_back(frame.at("colour_crc32c").get<std::uint32_t>());
  }
}

GeometryVideoHeader parse(const json& j) {
  if (j.at("format").get<std::string>() != kFormat) corrupt("this is no geometry video");
  GeometryVideoHeader header;
  header.version = j.at("version").get<int>();
  if (header.version < 1 || header.version > kColourChecksumVersion)
    corrupt(fmt::format("version {}, this program reads versions 1 to {}; use the program that wrote it",
                        header.version, kColourChecksumVersion));
  header.from_mean = header.version >= 3;
  if (header.version == 2) header.profile = profile_of(j.at("profile").get<std::string>());
  if (j.at("unit").get<std::string>() != "m") corrupt("unit is not \"m\"");
  header.level = level_of(j, "level");
  header.colour_level = level_of(j, "colour_level");
  if (header.colour_level < header.level) corrupt("colours are coarser than positions");
  header.fps = j.at("fps").get<double>();
  if (!(header.fps > 0.0 && header.fps <= 1000.0)) corrupt(fmt::format("rate of {} frames/s", header.fps));
  header.first_frame = j.at("first_frame").get<std::int64_t>();
  header.aligned = j.value("aligned", false);
  header.box = box_of(j, "box");
  header.from_mean = header.from_mean || header.profile == VideoProfile::stream;
  if (header.from_mean) header.difference_box = box_of(j, "difference_box");
  read_frames(j.at("frames"), header);
  return header;
}

}  // namespace

int version_of(const GeometryVideoHeader& header) {
  if (header.profile != VideoProfile::master) return 2;
  return header.from_mean ? kColourChecksumVersion : 1;
}

std::uint32_t checksum_of(const std::vector<Colour>& colours) {
  return capture::crc32c({reinterpret_cast<const std::uint8_t*>(colours.data()), colours.size() * sizeof(Colour)});
}

std::string_view to_string(VideoProfile profile) {
  if (profile == VideoProfile::master) return "master";
  return profile == VideoProfile::float32 ? "float" : "stream";
}

std::string to_json(const GeometryVideoHeader& header) {
  json frames = json::array();
  for (std::size_t i = 0; i < header.root_path.size(); ++i) {
    const FrameStatus& status = header.statuses.at(i);
    json frame = {{"root", json_of(header.root_path[i])}, {"status", status.interpolated ? "interpolated" : "mapped"}};
    if (!status.reason.empty()) frame["reason"] = status.reason;
    if (version_of(header) >= kColourChecksumVersion) frame["colour_crc32c"] = header.colour_checksums.at(i);
    frames.push_back(std::move(frame));
  }
  json j = {{"format", kFormat},
            {"version", version_of(header)},
            {"unit", "m"},
            {"level", header.level},
            {"colour_level", header.colour_level},
            {"fps", header.fps},
            {"first_frame", header.first_frame},
            {"box", json_of(header.box)},
            {"frames", std::move(frames)}};
  if (header.aligned) j["aligned"] = true;
  if (header.profile != VideoProfile::master) j["profile"] = to_string(header.profile);
  if (header.from_mean) j["difference_box"] = json_of(header.difference_box);
  return j.dump(1, ' ', false, json::error_handler_t::replace);
}

GeometryVideoHeader header_from_json(const std::string& text) {
  try {
    return parse(json::parse(text));
  } catch (const json::exception& error) {
    corrupt(error.what());
  }
}

Eigen::Vector3d root_of(const GeometryImage& image) {
  const int side = image.side();
  Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
  double area = 0.0;
  const auto at = [&](int row, int column) -> const Eigen::Vector3f& {
    return image
        .positions[static_cast<std::size_t>(row) * static_cast<std::size_t>(side) + static_cast<std::size_t>(column)];
  };
  for (int row = 0; row + 1 < side; ++row)
    for (int column = 0; column + 1 < side; ++column) {
      const Eigen::Vector3d a = at(row, column).cast<double>(), b = at(row, column + 1).cast<double>();
      const Eigen::Vector3d c = at(row + 1, column).cast<double>(), d = at(row + 1, column + 1).cast<double>();
      const double quad = 0.5 * (d - a).cross(c - b).norm();
      weighted += quad * 0.25 * (a + b + c + d);
      area += quad;
    }
  if (area > 0.0) return weighted / area;
  return at(side / 2, side / 2).cast<double>();
}

void add_frame(GeometryVideoHeader& header, const GeometryImage& image, FrameStatus status) {
  if (header.root_path.empty()) {
    header.level = image.level;
    header.colour_level = image.colour_level;
  }
  const auto side = static_cast<std::size_t>(image.side());
  if (image.level != header.level || image.colour_level != header.colour_level || image.positions.size() != side * side)
    throw InvalidInput(fmt::format("frame {} of the geometry video has level {} and {} positions, expected level {}",
                                   header.frame_count(), image.level, image.positions.size(), header.level));
  const auto finite = [](const Eigen::Vector3f& position) { return position.allFinite(); };
  if (!std::all_of(image.positions.begin(), image.positions.end(), finite))
    throw InvalidInput(
        fmt::format("frame {} of the geometry video has a position that is not finite", header.frame_count()));
  const Eigen::Vector3d root = root_of(image);
  for (const Eigen::Vector3f& position : image.positions) header.box.extend(position.cast<double>() - root);
  header.root_path.push_back(root);
  header.statuses.push_back(std::move(status));
  header.colour_checksums.push_back(checksum_of(image.colours));
}

}  // namespace rotunda::recon
