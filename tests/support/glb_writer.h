#pragma once
// Writes small glTF files for tests: arrays go into one buffer, the JSON stays open to whatever a test wants to break.
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace rotunda {

class GlbWriter {
 public:
  nlohmann::json json = {{"asset", {{"version", "2.0"}}},
                         {"bufferViews", nlohmann::json::array()},
                         {"accessors", nlohmann::json::array()}};
  std::string binary;

  int view(const void* bytes, std::size_t size) {
    binary.resize((binary.size() + 3) / 4 * 4);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", size}});
    binary.append(static_cast<const char*>(bytes), size);
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }
  // Component type by T; `type` "VEC3" and so on.
  template <class T>
  int accessor(const std::vector<T>& values, const char* type, bool normalised = false) {
    const std::string_view name(type);
    const std::size_t width = name == "SCALAR" ? 1 : name == "MAT4" ? 16 : static_cast<std::size_t>(name[3] - '0');
    json["accessors"].push_back({{"bufferView", view(values.data(), values.size() * sizeof(T))},
                                 {"componentType", component_type<T>()},
                                 {"count", values.size() / width},
                                 {"type", type}});
    if (normalised) json["accessors"].back()["normalized"] = true;
    return static_cast<int>(json["accessors"].size()) - 1;
  }

  std::string glb() const {
    auto whole = json;
    auto chunk = binary;
    chunk.resize((chunk.size() + 3) / 4 * 4);
    whole["buffers"] = {{{"byteLength", chunk.size()}}};
    auto text = whole.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    return "glTF" + word(2) + word(28 + text.size() + chunk.size()) + word(text.size()) + "JSON" + text +
           word(chunk.size()) + std::string("BIN\0", 4) + chunk;
  }
  static void write(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
  }

 private:
  static std::string word(std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &number, 4);
    return bytes;
  }
  template <class T>
  static constexpr int component_type() {
    if (std::is_same_v<T, std::uint8_t>) return 5121;
    if (std::is_same_v<T, std::int16_t>) return 5122;
    if (std::is_same_v<T, std::uint16_t>) return 5123;
    if (std::is_same_v<T, std::uint32_t>) return 5125;
    static_assert(sizeof(T) <= 4);
    return 5126;
  }
};

}  // namespace rotunda
