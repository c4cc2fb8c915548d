#pragma once
// A glTF 2.0 file (.glb, or .gltf with its buffers beside it or inside), taken apart by tinygltf behind a guard.
// Private to the room: it brings tinygltf's header with it.
#include <tiny_gltf.h>

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "config/errors.h"

namespace rotunda::recon {

struct GltfFile {
  std::filesystem::path path;
  tinygltf::Model model;           // with all buffers, without images
  std::vector<cv::Mat> pictures;   // one an image: CV_8UC4, sRGB, red first, straight alpha; empty if it is missing
  std::vector<std::string> notes;  // what is missing, for the user
};

// Throws std::system_error if the file cannot be read; CorruptData naming the element that is broken; InvalidInput for
// what a right file may hold but is not supported here: other glTF versions, required extensions, formats of pictures.
GltfFile open_gltf(const std::filesystem::path& path);

// What is thrown for an element of a file: "file: meshes[0].primitives[1].POSITION: ...".
CorruptData broken(const std::filesystem::path& path, const std::string& what);

}  // namespace rotunda::recon
