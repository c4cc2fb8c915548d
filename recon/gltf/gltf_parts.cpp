#include "recon/gltf/gltf_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kMostVertices = 4'000'000, kMostTriangles = 4'000'000;

void add_note(GltfCharacter& character, const std::string& note) {
  auto& notes = character.notes;
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
}

// Reads one primitive; everything in it speaks of `what_`.
class PrimitiveReader {
 public:
  PrimitiveReader(const GltfFile& file, const tinygltf::Primitive& from, std::string what, GltfAccessors& accessors,
                  GltfCharacter& character)
      : file_(file), from_(from), what_(std::move(what)), accessors_(accessors), character_(character) {}

  CharacterPart read(std::size_t node, int skin) {
    part_.node = node;
    part_.skin = skin;
    part_.material = from_.material;
    if (part_.material >= static_cast<int>(character_.materials.size()))
      refuse(fmt::format("there is no materials[{}]", part_.material));
    part_.positions = vectors<Eigen::Vector3f>(attribute("POSITION"), "POSITION");
    read_triangles();
    read_colours();
    read_uv();
    if (skin >= 0) read_influences();
    read_morphs();
    return std::move(part_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { throw broken(file_.path, what_ + ": " + what); }
  int attribute(const std::string& name) const {
    const auto it = from_.attributes.find(name);
    return it == from_.attributes.end() ? -1 : it->second;
  }
  std::string use(const std::string& name) const { return what_ + "." + name; }

  template <class Vector>
  std::vector<Vector> vectors(int accessor, const std::string& name) {
    const auto numbers = accessors_.numbers(accessor, static_cast<std::size_t>(Vector::SizeAtCompileTime), use(name));
    std::vector<Vector> result(numbers.size() / static_cast<std::size_t>(Vector::SizeAtCompileTime));
    std::copy(numbers.begin(), numbers.end(), result.empty() ? nullptr : result.front().data());
    check_count(result.size(), name);
    return result;
  }
  void check_count(std::size_t count, const std::string& name) const {
    if (name != "POSITION" && count != part_.positions.size())
      refuse(fmt::format("{} has {} elements for {} vertices", name, count, part_.positions.size()));
  }

  void read_triangles() {
    std::vector<std::uint32_t> corners;
    if (from_.indices >= 0) {
      corners = accessors_.integers(from_.indices, 1, use("indices"));
    } else {
      corners.resize(part_.positions.size());
      for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::uint32_t>(i);
    }
    for (std::size_t i = 0; i < corners.size(); ++i)
      if (corners[i] >= part_.positions.size())
        refuse(fmt::format("indices[{}] is {}, there are {} vertices", i, corners[i], part_.positions.size()));
    const bool is_strip = from_.mode == TINYGLTF_MODE_TRIANGLE_STRIP, is_fan = from_.mode == TINYGLTF_MODE_TRIANGLE_FAN;
    if (!is_strip && !is_fan && corners.size() % 3 != 0)
      refuse(fmt::format("{} indices are no triangles", corners.size()));
    for (std::size_t i = 0; i + 2 < corners.size(); i += is_strip || is_fan ? 1 : 3) {
      const bool is_turned = is_strip && i % 2 == 1;  // every other triangle of a strip
      const auto a = is_fan ? corners[0] : corners[i];
      const auto b = corners[i + 1], c = corners[i + 2];
      part_.triangles.push_back(is_turned ? std::array{b, a, c} : std::array{a, b, c});
    }
  }

  void read_colours() {
    const int accessor = attribute("COLOR_0");
    if (accessor < 0) return;
    const auto numbers = accessors_.colours(accessor, use("COLOR_0"));
    check_count(numbers.size() / 4, "COLOR_0");
    for (std::size_t i = 0; i < numbers.size(); i += 4)
      part_.colours.emplace_back(Eigen::Map<const Eigen::Vector4f>(numbers.data() + i));
  }

  // Which set, and KHR_texture_transform, u' = offset + R(rotation) (scale u).
  void read_uv() {
    if (part_.material < 0 || character_.materials[static_cast<std::size_t>(part_.material)].picture < 0) return;
    const auto& info =
        file_.model.materials[static_cast<std::size_t>(part_.material)].pbrMetallicRoughness.baseColorTexture;
    int set = info.texCoord;
    Eigen::Affine2f transform = Eigen::Affine2f::Identity();
    if (const auto it = info.extensions.find("KHR_texture_transform"); it != info.extensions.end()) {
      const auto& extension = it->second;
      if (extension.Has("texCoord")) set = extension.Get("texCoord").GetNumberAsInt();
      const float turn =
          extension.Has("rotation") ? static_cast<float>(extension.Get("rotation").GetNumberAsDouble()) : 0.0F;
      transform = Eigen::Translation2f(pair(extension, "offset", 0.0F)) * Eigen::Rotation2Df(-turn) *
                  Eigen::Scaling(pair(extension, "scale", 1.0F));
      if (!transform.matrix().allFinite()) refuse("its KHR_texture_transform is not finite");
    }
    const int accessor = attribute(fmt::format("TEXCOORD_{}", set));
    if (accessor < 0)
      return add_note(character_, what_ + " has a texture but no coordinates: its first pixel colours it");
    part_.uv = vectors<Eigen::Vector2f>(accessor, fmt::format("TEXCOORD_{}", set));
    for (auto& uv : part_.uv) uv = transform * uv;
  }
  static Eigen::Vector2f pair(const tinygltf::Value& extension, const char* key, float otherwise) {
    Eigen::Vector2f result(otherwise, otherwise);
    if (!extension.Has(key) || !extension.Get(key).IsArray() || extension.Get(key).ArrayLen() != 2) return result;
    for (int i = 0; i < 2; ++i) result[i] = static_cast<float>(extension.Get(key).Get(i).GetNumberAsDouble());
    return result;
  }

  void read_influences() {
    const std::size_t joints = character_.skins[static_cast<std::size_t>(part_.skin)].joints.size();
    part_.influences.resize(part_.positions.size());
    for (std::size_t set = 0; set < 2; ++set) read_influence_set(set, joints);
    if (attribute("JOINTS_2") >= 0)
      add_note(character_, "more than eight joints a vertex: the further ones are left out");
    for (std::size_t v = 0; v < part_.influences.size(); ++v) normalise(part_.influences[v]);
  }
  void read_influence_set(std::size_t set, std::size_t joints) {
    const auto joints_name = fmt::format("JOINTS_{}", set), weights_name = fmt::format("WEIGHTS_{}", set);
    if (attribute(joints_name) < 0) {
      if (set == 0) refuse("has a skin but no JOINTS_0");
      return;
    }
    const auto joint = accessors_.integers(attribute(joints_name), 4, use(joints_name));
    const auto weight = accessors_.numbers(attribute(weights_name), 4, use(weights_name));
    check_count(joint.size() / 4, joints_name);
    check_count(weight.size() / 4, weights_name);
    for (std::size_t i = 0; i < joint.size(); ++i) {
      if (weight[i] == 0.0F) continue;  // its joint may be anything
      if (joint[i] >= joints) refuse(fmt::format("vertex {}: joint {} of {}", i / 4, joint[i], joints));
      if (weight[i] < 0.0F) refuse(fmt::format("vertex {}: a weight of {}", i / 4, weight[i]));
      part_.influences[i / 4][4 * set + i % 4] = {joint[i], weight[i]};
    }
  }
  // A vertex that nothing carries follows the skin's first joint.
  static void normalise(Influences& influences) {
    float sum = 0.0F;
    for (const auto& influence : influences) sum += influence.weight;
    if (sum <= 0.0F) influences[0].weight = sum = 1.0F;
    for (auto& influence : influences) influence.weight /= sum;
  }

  void read_morphs() {
    for (std::size_t t = 0; t < from_.targets.size(); ++t) {
      const auto it = from_.targets[t].find("POSITION");
      if (it == from_.targets[t].end())
        part_.morphs.emplace_back(part_.positions.size(), Eigen::Vector3f::Zero());
      else
        part_.morphs.push_back(vectors<Eigen::Vector3f>(it->second, fmt::format("targets[{}]", t)));
    }
  }

  const GltfFile& file_;
  const tinygltf::Primitive& from_;
  std::string what_;
  GltfAccessors& accessors_;
  GltfCharacter& character_;
  CharacterPart part_;
};

bool is_drawn(const tinygltf::Primitive& primitive) {
  return primitive.mode == -1 || primitive.mode == TINYGLTF_MODE_TRIANGLES ||
         primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP || primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

void read_mesh(const GltfFile& file, std::size_t node, const tinygltf::Node& from, GltfAccessors& accessors,
               GltfCharacter& character) {
  const auto& model = file.model;
  if (static_cast<std::size_t>(from.mesh) >= model.meshes.size())
    throw broken(file.path, fmt::format("'{}': there is no meshes[{}]", character.nodes[node].name, from.mesh));
  if (from.skin >= static_cast<int>(character.skins.size()))
    throw broken(file.path, fmt::format("'{}': there is no skins[{}]", character.nodes[node].name, from.skin));
  const auto& mesh = model.meshes[static_cast<std::size_t>(from.mesh)];
  auto& resting = character.nodes[node].morph_weights;
  if (resting.empty())
    for (const double weight : mesh.weights) resting.push_back(static_cast<float>(weight));
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
    const auto what = fmt::format("meshes[{}].primitives[{}]", from.mesh, p);
    if (!is_drawn(mesh.primitives[p])) {
      add_note(character, what + ": points and lines are left out");
      continue;
    }
    auto part = PrimitiveReader(file, mesh.primitives[p], what, accessors, character).read(node, from.skin);
    if (!part.triangles.empty()) character.parts.push_back(std::move(part));
  }
}

CharacterTrack track_from(const GltfFile& file, const tinygltf::AnimationSampler& sampler, TrackPath path,
                          std::size_t width, const std::string& what, GltfAccessors& accessors) {
  CharacterTrack track;
  track.path = path;
  track.width = width;
  if (sampler.interpolation == "STEP") track.interpolation = TrackInterpolation::step;
  if (sampler.interpolation == "CUBICSPLINE") track.interpolation = TrackInterpolation::cubic_spline;
  track.times = accessors.numbers(sampler.input, 1, what + ".input");
  const std::size_t components = path == TrackPath::rotation ? 4 : path == TrackPath::morph_weights ? 1 : 3;
  track.values = accessors.numbers(sampler.output, components, what + ".output");
  const std::size_t values_a_key = width * (track.interpolation == TrackInterpolation::cubic_spline ? 3 : 1);
  if (track.times.empty() || track.values.size() != track.times.size() * values_a_key)
    throw broken(file.path, fmt::format("{}: {} keys with {} values", what, track.times.size(), track.values.size()));
  for (std::size_t k = 1; k < track.times.size(); ++k)
    if (track.times[k] < track.times[k - 1])
      throw broken(file.path, fmt::format("{}: key {} lies before key {}", what, k, k - 1));
  return track;
}

std::size_t morphs_of(const GltfCharacter& character, std::size_t node) {
  std::size_t morphs = 0;
  for (const auto& part : character.parts)
    if (part.node == node) morphs = std::max(morphs, part.morphs.size());
  return morphs;
}

void read_channel(const GltfFile& file, const tinygltf::Animation& from, std::size_t channel,
                  const std::vector<int>& place, const std::string& clip_name, GltfAccessors& accessors,
                  GltfCharacter& character, CharacterClip& clip) {
  const auto& found = from.channels[channel];
  const auto what = fmt::format("{}.channels[{}]", clip_name, channel);
  if (found.sampler < 0 || static_cast<std::size_t>(found.sampler) >= from.samplers.size())
    throw broken(file.path, fmt::format("{}: there is no samplers[{}]", what, found.sampler));
  if (found.target_node < 0) return;  // of an extension
  if (static_cast<std::size_t>(found.target_node) >= place.size())
    throw broken(file.path, fmt::format("{}: there is no nodes[{}]", what, found.target_node));
  const int node = place[static_cast<std::size_t>(found.target_node)];
  if (node < 0) return;
  const auto target = static_cast<std::size_t>(node);
  TrackPath path = TrackPath::translation;
  std::size_t width = 3;
  if (found.target_path == "rotation") {
    path = TrackPath::rotation;
    width = 4;
  } else if (found.target_path == "scale") {
    path = TrackPath::scale;
  } else if (found.target_path == "weights") {
    path = TrackPath::morph_weights;
    width = morphs_of(character, target);
    if (width == 0) return;
  } else if (found.target_path != "translation") {
    return add_note(character, fmt::format("{} moves '{}', which is left out", what, found.target_path.substr(0, 40)));
  }
  auto track = track_from(file, from.samplers[static_cast<std::size_t>(found.sampler)], path, width, what, accessors);
  track.node = target;
  clip.tracks.push_back(std::move(track));
}

}  // namespace

void read_parts(const GltfFile& file, const std::vector<std::size_t>& order, GltfAccessors& accessors,
                GltfCharacter& character) {
  std::size_t vertices = 0, triangles = 0, read = 0;
  for (std::size_t node = 0; node < order.size(); ++node) {
    const auto& from = file.model.nodes[order[node]];
    if (from.mesh < 0) continue;
    read_mesh(file, node, from, accessors, character);
    for (; read < character.parts.size(); ++read) {
      vertices += character.parts[read].positions.size();
      triangles += character.parts[read].triangles.size();
    }
    if (vertices > kMostVertices || triangles > kMostTriangles)
      throw InvalidInput(fmt::format("{}: more than {} vertices or triangles", file.path.string(), kMostVertices));
  }
  if (triangles == 0) throw InvalidInput(file.path.string() + ": its scene shows no surface");
}

void read_clips(const GltfFile& file, const std::vector<int>& place, GltfAccessors& accessors,
                GltfCharacter& character) {
  constexpr double kLongest = 3600.0;  // seconds
  for (std::size_t a = 0; a < file.model.animations.size(); ++a) {
    const auto& from = file.model.animations[a];
    const auto name = fmt::format("animations[{}]", a);
    CharacterClip clip;
    clip.name = from.name.empty() ? fmt::format("clip{}", a) : from.name;
    for (std::size_t c = 0; c < from.channels.size(); ++c)
      read_channel(file, from, c, place, name, accessors, character, clip);
    if (clip.tracks.empty()) continue;
    clip.begin = clip.tracks.front().times.front();
    clip.end = clip.begin;
    for (const auto& track : clip.tracks) {
      clip.begin = std::min<double>(clip.begin, track.times.front());
      clip.end = std::max<double>(clip.end, track.times.back());
    }
    if (clip.end - clip.begin > kLongest)
      throw InvalidInput(fmt::format("{}: {} ('{}') lasts {:.0f} s; an hour at most", file.path.string(), name,
                                     clip.name, clip.end - clip.begin));
    character.clips.push_back(std::move(clip));
  }
}

}  // namespace rotunda::recon
