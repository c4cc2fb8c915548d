#pragma once
// The arrays of a glTF file as plain vectors: any component type, normalised or not, strided, sparse. Private to the
// room. Every function throws CorruptData naming file, accessor and use if a number in them leads outside of what is
// there.
#include <cstdint>
#include <string>
#include <vector>

#include "recon/gltf/gltf_file.h"

namespace rotunda::recon {

class GltfAccessors {
 public:
  explicit GltfAccessors(const GltfFile& file) : file_(file) {}

  // Elements one after another, `components` numbers each; normalised integers become 0 to 1 or -1 to 1. All finite.
  std::vector<float> numbers(int accessor, std::size_t components, const std::string& use);
  // 3 or 4 components alike; a missing fourth is 1.
  std::vector<float> colours(int accessor, const std::string& use);
  std::vector<std::uint32_t> integers(int accessor, std::size_t components, const std::string& use);
  std::size_t count(int accessor, const std::string& use) const;

 private:
  const tinygltf::Accessor& at(int accessor, const std::string& use) const;
  std::vector<double> read(int accessor, std::size_t components, const std::string& use, bool integers_only);
  const unsigned char* bytes(int view, std::size_t offset, std::size_t stride, std::size_t count, std::size_t size,
                             const std::string& use) const;
  void lay_sparse(const tinygltf::Accessor& accessor, std::size_t components, const std::string& use,
                  std::vector<double>& values) const;
  [[noreturn]] void refuse(const std::string& use, const std::string& what) const;

  const GltfFile& file_;
  std::size_t budget_ = 50'000'000;  // numbers read in all: a small file can name one array a thousand times
};

}  // namespace rotunda::recon
