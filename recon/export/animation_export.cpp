#include "recon/export/animation_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include "config/errors.h"
#include "recon/export/clip_surface.h"
#include "recon/export/glb_file.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3f;

// Frames in memory at a time: a few batches of any vector unit.
constexpr std::size_t kChunk = 32;

class Frames {
 public:
  Frames(ScanAnimation& animation, std::span<const HandlePose> poses, const AnimationExportOptions& options)
      : animation_(animation), poses_(poses), options_(options), rest_volume_(signed_volume(animation.rest())) {
    report.frames = poses.size() / kBodySegments;
    report.vertices = animation.rest().positions.size();
    report.triangles = animation.rest().triangles.size();
    report.has_volume = topology_of(animation.rest()).closed;
  }

  // take(frame, positions) for every frame in order.
  template <class Take>
  void each(const Take& take) {
    std::vector<Vector3f> positions;
    TriangleMesh posed = animation_.rest();
    for (std::size_t first = 0; first < report.frames; first += kChunk) {
      if (options_.stop.stop_requested())
        throw std::system_error(std::make_error_code(std::errc::operation_canceled), "the export was stopped");
      const std::size_t count = std::min(kChunk, report.frames - first);
      const auto poses = poses_.subspan(first * kBodySegments, count * kBodySegments);
      positions.resize(count * report.vertices);
      const auto start = std::chrono::steady_clock::now();
      animation_.deform(poses, positions);
      report.deform_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      report.drift = std::max(report.drift, animation_.drift(poses, positions));
      for (std::size_t f = 0; f < count; ++f) {
        const std::span<const Vector3f> frame(positions.data() + f * report.vertices, report.vertices);
        posed.positions.assign(frame.begin(), frame.end());
        const double volume = !report.has_volume ? 1.0 : signed_volume(posed) / rest_volume_;
        report.least_volume = std::min(report.least_volume, volume);
        report.most_volume = std::max(report.most_volume, volume);
        take(first + f, frame);
        if (options_.progress) options_.progress(first + f + 1, report.frames);
      }
    }
  }

  AnimationExportReport report;

 private:
  ScanAnimation& animation_;
  std::span<const HandlePose> poses_;
  const AnimationExportOptions& options_;
  double rest_volume_;
};

std::vector<float> times_of(std::size_t frames, double frame_time) {
  std::vector<float> times;
  for (std::size_t f = 0; f < frames; ++f) times.push_back(static_cast<float>(static_cast<double>(f) * frame_time));
  return times;
}

nlohmann::json scan_primitive(GlbFile& glb, const TriangleMesh& scan) {
  std::vector<std::uint32_t> indices;
  for (const auto& t : scan.triangles) indices.insert(indices.end(), t.begin(), t.end());
  nlohmann::json attributes{{"POSITION", glb.add_positions(y_up(scan.positions))}};
  attributes["NORMAL"] = glb.add_normals(y_up(scan.normals));
  if (!scan.colours.empty()) attributes["COLOR_0"] = glb.add_colours(scan.colours);
  return {{"attributes", attributes}, {"indices", glb.add_indices(indices)}, {"material", glb.add_plain_material()}};
}

// The four handles that turn a vertex most.
struct Skin {
  std::vector<std::array<std::uint8_t, 4>> joints;
  std::vector<Eigen::Vector4f> weights;
};

Skin skin_of(const HandleShares& shares) {
  Skin skin;
  for (Eigen::Index v = 0; v < shares.rows(); ++v) {
    std::array<std::uint8_t, kBodySegments> order;
    for (std::size_t s = 0; s < kBodySegments; ++s) order[s] = static_cast<std::uint8_t>(s);
    std::partial_sort(order.begin(), order.begin() + 4, order.end(),
                      [&](auto a, auto b) { return shares(v, a) > shares(v, b); });
    Eigen::Vector4f weight;
    for (std::size_t i = 0; i < 4; ++i) weight[static_cast<Eigen::Index>(i)] = shares(v, order[i]);
    weight /= weight.sum();
    std::array<std::uint8_t, 4> joints = {order[0], order[1], order[2], order[3]};
    for (std::size_t i = 0; i < 4; ++i)
      if (weight[static_cast<Eigen::Index>(i)] <= 0.0F) joints[i] = 0;  // glTF wants 0 where nothing weighs
    skin.joints.push_back(joints);
    skin.weights.push_back(weight);
  }
  return skin;
}

Vector3f skinned(const Skin& skin, std::size_t v, const Vector3f& rest, std::span<const HandlePose> poses) {
  Vector3f sum = Vector3f::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& pose = poses[skin.joints[v][i]];
    sum += skin.weights[v][static_cast<Eigen::Index>(i)] * (pose.rotation * rest + pose.translation);
  }
  return sum;
}

// From the world's z up to glTF's y up: (x, y, z) is (x, z, -y).
Eigen::Quaternionf y_up(const Eigen::Quaternionf& q) {
  return {q.w(), q.x(), q.z(), -q.y()};
}

// Each joint stands at the origin at rest, so that its transform is the handle's own and bind matrices are identities:
// a child of the scan's node, not of its parent joint, for handles already hold the whole of the way.
void add_skin(GlbFile& glb, const Skin& skin, std::span<const HandlePose> poses, double frame_time) {
  auto& json = glb.json;
  auto& primitive = json["meshes"][0]["primitives"][0];
  primitive["attributes"]["JOINTS_0"] = glb.add_joints(skin.joints);
  primitive["attributes"]["WEIGHTS_0"] = glb.add_weights(skin.weights);
  const std::size_t frames = poses.size() / kBodySegments;
  const auto times = glb.add_scalars(times_of(frames, frame_time));
  auto& animation = json["animations"][0];
  animation = {{"name", "motion"}};
  nlohmann::json joints = nlohmann::json::array();
  for (std::size_t s = 0; s < kBodySegments; ++s) {
    const std::size_t node = 2 + s;
    json["nodes"][node] = {{"name", segment_name(s)}};
    json["nodes"][1]["children"].push_back(node);
    joints.push_back(node);
    std::vector<Eigen::Vector4f> turns;
    std::vector<Vector3f> shifts;
    for (std::size_t f = 0; f < frames; ++f) {
      const auto& pose = poses[f * kBodySegments + s];
      auto turn = y_up(pose.rotation);
      if (f > 0 && turn.coeffs().dot(turns.back()) < 0.0F) turn.coeffs() = -turn.coeffs();
      turns.push_back(turn.coeffs());
      shifts.push_back(recon::y_up(pose.translation));
    }
    const auto add = [&](const char* path, std::size_t values) {
      animation["samplers"].push_back({{"input", times}, {"interpolation", "LINEAR"}, {"output", values}});
      animation["channels"].push_back(
          {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
    };
    add("rotation", glb.add_rotations(turns));
    add("translation", glb.add_values(shifts));
  }
  const std::vector<Eigen::Matrix4f> at_origin(kBodySegments, Eigen::Matrix4f::Identity());
  json["skins"] = {{{"joints", joints}, {"skeleton", 1}, {"inverseBindMatrices", glb.add_matrices(at_origin)}}};
  json["nodes"][0]["skin"] = 0;
}

void export_skin(ScanAnimation& animation, std::span<const HandlePose> poses, const AnimationExportOptions& options,
                 Frames& frames) {
  const auto& rest = animation.rest();
  const auto skin = skin_of(animation.shares());
  double square = 0.0, worst = 0.0;
  frames.each([&](std::size_t f, std::span<const Vector3f> positions) {
    const auto own = poses.subspan(f * kBodySegments, kBodySegments);
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const double off = static_cast<double>((skinned(skin, v, rest.positions[v], own) - positions[v]).norm());
      square += off * off;
      worst = std::max(worst, off);
    }
  });
  frames.report.skin_rms = std::sqrt(square / static_cast<double>(frames.report.frames * frames.report.vertices));
  frames.report.skin_worst = worst;
  GlbFile glb;
  glb.json["meshes"] = {{{"name", "scan"}, {"primitives", {scan_primitive(glb, rest)}}}};
  glb.json["nodes"] = {{{"name", "scan"}, {"mesh", 0}}, {{"name", "body"}}};
  glb.json["scenes"] = {{{"nodes", {0, 1}}}};
  glb.json["scene"] = 0;
  add_skin(glb, skin, poses, options.frame_time);
  glb.write(options.output);
}

void export_morph(ScanAnimation& animation, const AnimationExportOptions& options, Frames& frames) {
  const auto& rest = animation.rest();
  constexpr double kMost = 4e9;  // a .glb's length has 32 bits
  const double size = 12.0 * static_cast<double>(frames.report.vertices * frames.report.frames);
  if (size > kMost)
    throw InvalidInput(
        fmt::format("{} frames of {} vertices are {:.1f} GB as morph targets, and a .glb holds 4: export "
                    "a skin or PC2, or fewer frames (--frames A:B)",
                    frames.report.frames, frames.report.vertices, size / 1e9));
  GlbFile glb;
  auto primitive = scan_primitive(glb, rest);
  std::vector<Vector3f> shifts(rest.positions.size());
  frames.each([&](std::size_t, std::span<const Vector3f> positions) {
    for (std::size_t v = 0; v < positions.size(); ++v) shifts[v] = recon::y_up(positions[v] - rest.positions[v]);
    primitive["targets"].push_back({{"POSITION", glb.add_positions(shifts)}});
  });
  const std::size_t count = frames.report.frames;
  std::vector<float> weights(count * count, 0.0F);
  for (std::size_t f = 0; f < count; ++f) weights[f * count + f] = 1.0F;
  glb.json["meshes"] = {{{"name", "scan"}, {"primitives", {primitive}}, {"weights", std::vector<float>(count, 0.0F)}}};
  glb.json["nodes"] = {{{"name", "scan"}, {"mesh", 0}}};
  glb.json["scenes"] = {{{"nodes", {0}}}};
  glb.json["scene"] = 0;
  const auto times = glb.add_scalars(times_of(count, options.frame_time));
  glb.json["animations"] = {
      {{"name", "motion"},
       {"samplers", {{{"input", times}, {"interpolation", "LINEAR"}, {"output", glb.add_scalars(weights)}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
  glb.write(options.output);
}

std::string obj_text(const TriangleMesh& scan) {
  std::string text = "# Rotunda: the scan at rest; its motion lies beside it as .pc2\n";
  for (std::size_t v = 0; v < scan.positions.size(); ++v) {
    const Vector3f p = recon::y_up(scan.positions[v]);
    text += fmt::format("v {:.6f} {:.6f} {:.6f}", p.x(), p.y(), p.z());
    if (!scan.colours.empty())
      for (const auto channel : scan.colours[v]) text += fmt::format(" {:.4f}", channel / 255.0);
    text += '\n';
  }
  for (const auto& [a, b, c] : scan.triangles) text += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
  return text;
}

void put_word(std::ofstream& out, const auto& value) {
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

void export_pc2(ScanAnimation& animation, const AnimationExportOptions& options, Frames& frames) {
  auto cache = options.output;
  cache.replace_extension(".pc2");
  write_text(options.output, obj_text(animation.rest()));
  write_whole(cache, [&](const std::filesystem::path& part) {
    errno = 0;
    std::ofstream out(part, std::ios::binary);
    out.write("POINTCACHE2\0", 12);
    put_word(out, std::int32_t{1});
    put_word(out, static_cast<std::int32_t>(frames.report.vertices));
    put_word(out, 0.0F);  // the first frame
    put_word(out, 1.0F);  // frames a sample
    put_word(out, static_cast<std::int32_t>(frames.report.frames));
    std::vector<Vector3f> turned(frames.report.vertices);
    frames.each([&](std::size_t, std::span<const Vector3f> positions) {
      std::transform(positions.begin(), positions.end(), turned.begin(),
                     [](const Vector3f& p) { return recon::y_up(p); });
      out.write(reinterpret_cast<const char*>(turned.data()),
                static_cast<std::streamsize>(turned.size() * sizeof turned[0]));
    });
    out.flush();
    if (!out) throw std::system_error(errno ? errno : EIO, std::generic_category(), "writing " + cache.string());
  });
  frames.report.bytes = std::filesystem::file_size(cache);
}

}  // namespace

AnimationExportReport export_animation(ScanAnimation& animation, std::span<const HandlePose> poses,
                                       const AnimationExportOptions& options) {
  if (poses.empty()) throw InvalidInput("the motion to export has no frame");
  Frames frames(animation, poses, options);
  switch (options.format) {
    case AnimationFormat::skin:
      export_skin(animation, poses, options, frames);
      break;
    case AnimationFormat::morph:
      export_morph(animation, options, frames);
      break;
    case AnimationFormat::pc2:
      export_pc2(animation, options, frames);
      break;
  }
  frames.report.bytes += std::filesystem::file_size(options.output);
  return frames.report;
}

}  // namespace rotunda::recon
