#include "recon/gltf/gltf_character.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "recon/gltf/gltf_accessor.h"
#include "recon/gltf/gltf_file.h"
#include "recon/gltf/gltf_parts.h"

namespace rotunda::recon {
namespace {

[[noreturn]] void refuse(const GltfFile& file, const std::string& what) {
  throw broken(file.path, what);
}

bool is_index(int index, std::size_t size) {
  return index >= 0 && static_cast<std::size_t>(index) < size;
}

// The nodes of the scene shown, parents first; refuses nodes that have two parents or are their own ancestor.
class NodeOrder {
 public:
  explicit NodeOrder(const GltfFile& file) : place(file.model.nodes.size(), -1), file_(file) {
    for (const int root : roots()) add(root, -1, "the scene");
    for (std::size_t next = 0; next < order.size(); ++next)
      for (const int child : node(order[next]).children)
        add(child, static_cast<int>(next), fmt::format("nodes[{}]", order[next]));
  }
  std::vector<std::size_t> order;  // of the file's nodes
  std::vector<int> parent;         // places in `order`
  std::vector<int> place;          // of a node of the file in `order`, -1 if it is not in the scene

 private:
  const tinygltf::Node& node(std::size_t i) const { return file_.model.nodes[i]; }
  std::vector<int> roots() const {
    const auto& model = file_.model;
    if (!model.scenes.empty()) {
      const int scene = std::max(model.defaultScene, 0);
      if (!is_index(scene, model.scenes.size())) refuse(file_, fmt::format("there is no scenes[{}]", scene));
      return model.scenes[static_cast<std::size_t>(scene)].nodes;
    }
    std::vector<bool> is_child(model.nodes.size(), false);
    for (const auto& any : model.nodes)
      for (const int child : any.children)
        if (is_index(child, is_child.size())) is_child[static_cast<std::size_t>(child)] = true;
    std::vector<int> found;
    for (std::size_t i = 0; i < is_child.size(); ++i)
      if (!is_child[i]) found.push_back(static_cast<int>(i));
    return found;
  }
  void add(int index, int under, const std::string& whose) {
    if (!is_index(index, place.size())) refuse(file_, fmt::format("{}: there is no nodes[{}]", whose, index));
    auto& here = place[static_cast<std::size_t>(index)];
    if (here >= 0) refuse(file_, fmt::format("nodes[{}] has two parents or is its own ancestor", index));
    here = static_cast<int>(order.size());
    order.push_back(static_cast<std::size_t>(index));
    parent.push_back(under);
  }
  const GltfFile& file_;
};

// As many finite numbers as there must be, or none.
std::vector<double> checked(const GltfFile& file, const std::vector<double>& numbers, std::size_t count,
                            const std::string& what) {
  const bool fits = (numbers.empty() || numbers.size() == count) &&
                    std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::abs(n) <= 1e9; });
  if (!fits) refuse(file, what + ": is not as it must be");
  return numbers;
}

CharacterNode node_from(const GltfFile& file, std::size_t index, int parent) {
  const auto& found = file.model.nodes[index];
  const auto what = [&](const char* key) { return fmt::format("nodes[{}].{}", index, key); };
  CharacterNode node;
  node.name = found.name.empty() ? fmt::format("node{}", index) : found.name;
  node.parent = parent;
  if (const auto t = checked(file, found.translation, 3, what("translation")); !t.empty())
    node.translation = {t[0], t[1], t[2]};
  if (const auto s = checked(file, found.scale, 3, what("scale")); !s.empty()) node.scale = {s[0], s[1], s[2]};
  if (const auto r = checked(file, found.rotation, 4, what("rotation")); !r.empty()) {
    node.rotation = {r[3], r[0], r[1], r[2]};
    if (node.rotation.norm() < 1e-6) refuse(file, what("rotation") + ": is zero");
    node.rotation.normalize();
  }
  if (const auto m = checked(file, found.matrix, 16, what("matrix")); !m.empty())
    node.matrix = Eigen::Map<const Eigen::Matrix4d>(m.data());
  for (const double weight : found.weights) node.morph_weights.push_back(static_cast<float>(weight));
  return node;
}

CharacterSkin skin_from(const GltfFile& file, std::size_t index, const NodeOrder& nodes, GltfAccessors& accessors) {
  const auto& found = file.model.skins[index];
  const auto what = fmt::format("skins[{}]", index);
  CharacterSkin skin;
  for (const int joint : found.joints) {
    if (!is_index(joint, nodes.place.size())) refuse(file, fmt::format("{}: there is no nodes[{}]", what, joint));
    const int place = nodes.place[static_cast<std::size_t>(joint)];
    if (place < 0) refuse(file, fmt::format("{}: its joint nodes[{}] is not in the scene", what, joint));
    skin.joints.push_back(static_cast<std::size_t>(place));
  }
  if (skin.joints.empty()) refuse(file, what + ": has no joints");
  skin.inverse_bind.assign(skin.joints.size(), Eigen::Matrix4d::Identity());
  if (found.inverseBindMatrices < 0) return skin;
  const auto numbers = accessors.numbers(found.inverseBindMatrices, 16, what + ".inverseBindMatrices");
  if (numbers.size() < 16 * skin.joints.size()) refuse(file, what + ": has fewer inverse bind matrices than joints");
  for (std::size_t j = 0; j < skin.joints.size(); ++j)
    skin.inverse_bind[j] = Eigen::Map<const Eigen::Matrix4f>(numbers.data() + 16 * j).cast<double>();
  return skin;
}

PictureWrap wrap_from(int wrap) {
  if (wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return PictureWrap::clamp;
  return wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? PictureWrap::mirrored : PictureWrap::repeat;
}

SurfaceMaterial material_from(const GltfFile& file, std::size_t index) {
  const auto& model = file.model;
  const auto& found = model.materials[index].pbrMetallicRoughness;
  const auto what = fmt::format("materials[{}]", index);
  SurfaceMaterial material;
  const auto factor = checked(file, found.baseColorFactor, 4, what + ".baseColorFactor");
  for (std::size_t i = 0; i < 3 && !factor.empty(); ++i)
    material.factor[static_cast<Eigen::Index>(i)] = static_cast<float>(std::clamp(factor[i], 0.0, 1.0));
  const int texture = found.baseColorTexture.index;
  if (texture < 0) return material;
  if (!is_index(texture, model.textures.size()))
    refuse(file, fmt::format("{}: there is no textures[{}]", what, texture));
  const auto& named = model.textures[static_cast<std::size_t>(texture)];
  if (!is_index(named.source, file.pictures.size()))
    refuse(file, fmt::format("textures[{}]: there is no images[{}]", texture, named.source));
  if (!file.pictures[static_cast<std::size_t>(named.source)].empty()) material.picture = named.source;
  if (is_index(named.sampler, model.samplers.size())) {
    const auto& sampler = model.samplers[static_cast<std::size_t>(named.sampler)];
    material.wrap = {wrap_from(sampler.wrapS), wrap_from(sampler.wrapT)};
  }
  return material;
}

std::vector<std::string> names_of(const std::vector<CharacterClip>& clips) {
  std::vector<std::string> names;
  for (const auto& clip : clips) names.push_back(clip.name);
  return names;
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

void take_pictures(GltfFile& file, GltfCharacter& character) {
  const auto is_cut_out = [](const auto& material) {
    return material.alphaMode == "MASK" || material.alphaMode == "BLEND";
  };
  if (std::any_of(file.model.materials.begin(), file.model.materials.end(), is_cut_out))
    character.notes.emplace_back("transparency is left out: cut-outs and glass show as solid");
  for (const auto& rgba : file.pictures) {
    auto& rgb = character.pictures.emplace_back();
    if (!rgba.empty()) cv::cvtColor(rgba, rgb, cv::COLOR_RGBA2RGB);
  }
  file.pictures.clear();
}

}  // namespace

const CharacterClip& GltfCharacter::clip(std::string_view name) const {
  const CharacterClip* near = nullptr;
  int fitting = 0;
  for (const auto& clip : clips) {
    if (clip.name == name) return clip;
    if (lower(clip.name) != lower(name)) continue;
    near = &clip;
    ++fitting;
  }
  if (fitting == 1) return *near;
  throw InvalidInput(
      fmt::format("{} has no clip '{}'; its clips: {}", file.string(), name, fmt::join(names_of(clips), ", ")));
}

GltfCharacter read_gltf_character(const std::filesystem::path& path) {
  auto file = open_gltf(path);
  GltfAccessors accessors(file);
  GltfCharacter character;
  character.file = path;
  character.notes = file.notes;
  const NodeOrder nodes(file);
  for (std::size_t i = 0; i < nodes.order.size(); ++i)
    character.nodes.push_back(node_from(file, nodes.order[i], nodes.parent[i]));
  for (std::size_t i = 0; i < file.model.skins.size(); ++i)
    character.skins.push_back(skin_from(file, i, nodes, accessors));
  for (std::size_t i = 0; i < file.model.materials.size(); ++i) character.materials.push_back(material_from(file, i));
  read_parts(file, nodes.order, accessors, character);
  read_clips(file, nodes.place, accessors, character);
  take_pictures(file, character);
  return character;
}

}  // namespace rotunda::recon
