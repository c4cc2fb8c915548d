// tinygltf trusts a few things that it should not (the length of the binary chunk, where an image lies in its buffer,
// files of any kind and size behind a URI): those are checked or done here, and it only sees what has been checked.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include "recon/gltf/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>

#include "config/errors.h"
#include "recon/mesh/picture_file.h"

namespace rotunda::recon {
namespace {

using nlohmann::json;
static_assert(std::endian::native == std::endian::little, "glTF's numbers are taken as they lie in memory");

constexpr int kDeepestJson = 64;  // tinygltf descends into extensions by recursion
constexpr std::array kKnownExtensions = {
    "KHR_materials_unlit",    "KHR_texture_transform",     "KHR_mesh_quantization",
    "KHR_materials_specular", "KHR_materials_ior",         "KHR_materials_clearcoat",
    "KHR_materials_sheen",    "KHR_lights_punctual",       "KHR_materials_emissive_strength",
    "KHR_materials_volume",   "KHR_materials_transmission"};

std::uint32_t word_at(const Bytes& bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

// The two chunks of a .glb; of a .gltf all of it is JSON.
struct Chunks {
  std::string json;
  Bytes binary;
  bool has_binary = false;
};

constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

void take_chunk(const std::filesystem::path& path, const Bytes& bytes, std::size_t& at, Chunks& chunks) {
  if (bytes.size() - at < 8) throw CorruptData(path, at, "the file ends within a chunk's header");
  const std::size_t length = word_at(bytes, at);
  const std::uint32_t kind = word_at(bytes, at + 4);
  if (length > bytes.size() - at - 8)
    throw CorruptData(path, at,
                      fmt::format("a chunk of {} bytes with {} left: the file is cut", length, bytes.size() - at - 8));
  const auto* begin = bytes.data() + at + 8;
  if (at == 12 && kind != kJsonChunk) throw CorruptData(path, at, "the first chunk is not JSON");
  if (at == 12) chunks.json.assign(reinterpret_cast<const char*>(begin), length);
  if (at != 12 && kind == kBinaryChunk && !chunks.has_binary) {
    chunks.binary.assign(begin, begin + length);
    chunks.has_binary = true;
  }
  at += 8 + length;
}

Chunks chunks_of(const std::filesystem::path& path, const Bytes& bytes) {
  Chunks chunks;
  if (bytes.size() >= 4 && word_at(bytes, 0) == kMagic) {
    if (bytes.size() < 12) throw broken(path, "the file ends within its header");
    if (word_at(bytes, 4) != 2)
      throw InvalidInput(
          fmt::format("{}: binary glTF version {}; version 2 is read", path.string(), word_at(bytes, 4)));
    if (word_at(bytes, 8) != bytes.size())
      throw CorruptData(path, 8,
                        fmt::format("the header promises {} bytes, the file has {}", word_at(bytes, 8), bytes.size()));
    for (std::size_t at = 12; at < bytes.size() || at == 12;) take_chunk(path, bytes, at, chunks);
    return chunks;
  }
  const auto first = std::find_if(bytes.begin(), bytes.end(), [](unsigned char c) { return c > ' ' && c < 0x80; });
  if (first == bytes.end() || *first != '{')
    throw broken(path, "is no glTF: it begins neither with 'glTF' nor with '{'");
  chunks.json.assign(bytes.begin(), bytes.end());
  return chunks;
}

json parse_json(const std::filesystem::path& path, const std::string& text) {
  const auto guard = [&](int depth, json::parse_event_t, json&) {
    if (depth > kDeepestJson) throw broken(path, fmt::format("its JSON nests deeper than {}", kDeepestJson));
    return true;
  };
  try {
    auto root = json::parse(text, guard);
    if (!root.is_object()) throw broken(path, "its JSON is no object");
    return root;
  } catch (const json::parse_error& error) {
    throw CorruptData(path, error.byte, fmt::format("its JSON is broken: {}", error.what()));
  } catch (const json::exception& error) {  // a number that no double holds
    throw broken(path, fmt::format("its JSON is broken: {}", error.what()));
  }
}

// tinygltf casts any integer to int, or to size_t: what would not survive that is refused wherever it stands.
void check_numbers(const std::filesystem::path& path, const json& value, const std::string& where) {
  if (value.is_number_integer()) {
    const bool fits = value.is_number_unsigned() ? value.get<std::uint64_t>() <= kLargestInput
                                                 : value.get<std::int64_t>() >= -std::int64_t{kLargestInput};
    if (!fits) throw broken(path, fmt::format("{}: {} is absurd", where, value.dump()));
  }
  if (value.is_structured() && !where.ends_with("/extras"))
    for (const auto& item : value.items()) check_numbers(path, item.value(), where + "/" + item.key());
}

void check_version(const std::filesystem::path& path, const json& root) {
  const auto asset = root.find("asset");
  if (asset == root.end() || !asset->is_object() || !asset->contains("version") || !(*asset)["version"].is_string())
    throw broken(path, "asset.version is missing");
  const auto version = (*asset)["version"].get<std::string>();
  if (!version.starts_with("2."))
    throw InvalidInput(fmt::format("{}: glTF version {}; version 2.0 is read", path.string(), version.substr(0, 20)));
  const auto required = root.find("extensionsRequired");
  if (required == root.end() || !required->is_array()) return;
  for (const auto& extension : *required)
    if (extension.is_string() && std::find(kKnownExtensions.begin(), kKnownExtensions.end(),
                                           extension.get<std::string>()) == kKnownExtensions.end())
      throw InvalidInput(fmt::format("{}: needs the extension {}, which is not read here; export it without",
                                     path.string(), extension.get<std::string>()));
}

// glTF's URIs are relative and may be percent-encoded.
std::filesystem::path beside(const std::filesystem::path& path, const std::string& uri) {
  return path.parent_path() / tinygltf::dlib::urldecode(uri);
}

bool is_missing(const std::filesystem::path& file) {
  std::error_code error;
  return !std::filesystem::is_regular_file(file, error);
}

bool is_data(const std::string& uri) {
  return uri.starts_with("data:");
}

Bytes bytes_of_uri(const std::filesystem::path& path, const std::string& what, const std::string& uri) {
  if (!is_data(uri)) {
    const auto file = beside(path, uri);
    if (is_missing(file))
      throw InvalidInput(fmt::format("{}: {}: its file {} is missing", path.string(), what, file.string()));
    return read_whole(file);
  }
  const auto comma = uri.find(";base64,");
  if (comma == std::string::npos) throw broken(path, what + ": a data URI that is not base64");
  const auto data = tinygltf::base64_decode(uri.substr(comma + 8));
  return Bytes(data.begin(), data.end());
}

std::string string_in(const json& object, const char* key) {
  const auto it = object.find(key);
  return it != object.end() && it->is_string() ? it->get<std::string>() : std::string();
}

// Buffers come in whole here, so that tinygltf opens no files.
void fill_buffers(const std::filesystem::path& path, const json& buffers, Chunks& chunks, tinygltf::Model& model) {
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const auto what = fmt::format("buffers[{}]", i);
    if (!buffers[i].is_object() || !buffers[i].contains("byteLength") || !buffers[i]["byteLength"].is_number_unsigned())
      throw broken(path, what + ": byteLength is missing");
    const auto length = buffers[i]["byteLength"].get<std::uint64_t>();
    const auto uri = string_in(buffers[i], "uri");
    auto& buffer = model.buffers.emplace_back();
    if (!uri.empty()) {
      buffer.data = bytes_of_uri(path, what, uri);
    } else if (i == 0 && chunks.has_binary) {
      buffer.data = std::move(chunks.binary);
    } else {
      throw broken(path, what + ": has neither a URI nor the file's binary chunk");
    }
    if (buffer.data.size() < length)
      throw broken(path, fmt::format("{}: {} of {} bytes are there", what, buffer.data.size(), length));
  }
}

Bytes bytes_of_view(const GltfFile& file, const std::string& what, std::int64_t index) {
  const auto& views = file.model.bufferViews;
  if (index < 0 || static_cast<std::size_t>(index) >= views.size())
    throw broken(file.path, fmt::format("{}: there is no bufferViews[{}]", what, index));
  const auto& view = views[static_cast<std::size_t>(index)];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= file.model.buffers.size())
    throw broken(file.path, fmt::format("bufferViews[{}]: there is no buffers[{}]", index, view.buffer));
  const auto& data = file.model.buffers[static_cast<std::size_t>(view.buffer)].data;
  if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
    throw broken(file.path, fmt::format("bufferViews[{}]: reaches beyond its buffer", index));
  const auto* begin = data.data() + view.byteOffset;
  return Bytes(begin, begin + view.byteLength);
}

void decode_pictures(const json& images, GltfFile& file) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto what = fmt::format("images[{}]", i);
    if (!images[i].is_object()) throw broken(file.path, what + ": is no object");
    const auto uri = string_in(images[i], "uri");
    const auto view = images[i].find("bufferView");
    if (uri.empty() && (view == images[i].end() || !view->is_number_integer()))
      throw broken(file.path, what + ": has neither a URI nor a bufferView");
    if (!uri.empty() && !is_data(uri) && is_missing(beside(file.path, uri))) {
      file.notes.push_back(fmt::format("its picture {} is missing", beside(file.path, uri).string()));
      file.pictures.emplace_back();
      continue;
    }
    const auto bytes =
        uri.empty() ? bytes_of_view(file, what, view->get<std::int64_t>()) : bytes_of_uri(file.path, what, uri);
    file.pictures.push_back(decode_picture(file.path, what, bytes));
  }
}

// What stands under a key of the root, taken out of it; an empty array if nothing does.
json taken_out(const std::filesystem::path& path, json& root, const char* key) {
  json taken = json::array();
  if (const auto it = root.find(key); it != root.end()) {
    taken = std::move(*it);
    root.erase(it);
  }
  if (!taken.is_array()) throw broken(path, std::string(key) + ": is no array");
  return taken;
}

// tinygltf notices this too, but does not say where.
void check_indices(const std::filesystem::path& path, const json& root) {
  const auto list = [](const json& object, const char* key) {
    const auto it = object.is_object() ? object.find(key) : object.end();
    return it != object.end() && it->is_array() ? *it : json::array();
  };
  const std::size_t accessors = list(root, "accessors").size();
  const auto meshes = list(root, "meshes");
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const auto primitives = list(meshes[m], "primitives");
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      const auto indices = primitives[p].is_object() ? primitives[p].value("indices", json(0)) : json(0);
      if (indices.is_number_unsigned() && indices.get<std::size_t>() >= std::max<std::size_t>(accessors, 1))
        throw broken(path, fmt::format("meshes[{}].primitives[{}].indices: there is no accessors[{}]", m, p,
                                       indices.get<std::size_t>()));
    }
  }
}

void load_model(const std::filesystem::path& path, const json& root, tinygltf::Model& model) {
  const auto text = root.dump(-1, ' ', false, json::error_handler_t::replace);
  tinygltf::TinyGLTF loader;
  std::string error, warning;
  bool is_loaded = false;
  try {
    is_loaded = loader.LoadASCIIFromString(&model, &error, &warning, text.data(), static_cast<unsigned>(text.size()),
                                           "", tinygltf::REQUIRE_VERSION);
  } catch (const std::exception& thrown) {
    error += thrown.what();
  }
  if (is_loaded) return;
  std::replace(error.begin(), error.end(), '\n', ' ');
  throw broken(path, error.empty() ? "is no glTF" : error.substr(0, 300));
}

}  // namespace

CorruptData broken(const std::filesystem::path& path, const std::string& what) {
  return CorruptData(path.string() + ": " + what);
}

GltfFile open_gltf(const std::filesystem::path& path) {
  auto chunks = chunks_of(path, read_whole(path));
  auto root = parse_json(path, chunks.json);
  chunks.json.clear();
  check_version(path, root);
  check_numbers(path, root, "");
  check_indices(path, root);
  const auto buffers = taken_out(path, root, "buffers"), images = taken_out(path, root, "images");
  GltfFile file{path, {}, {}, {}};
  load_model(path, root, file.model);
  fill_buffers(path, buffers, chunks, file.model);
  decode_pictures(images, file);
  return file;
}

}  // namespace rotunda::recon
