#pragma once
// Pictures to judge the simulated studio by: everybody who comes with it, whole and near, and every act at four moments
// from two cameras, each with its true matte.
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace rotunda::simulator {

struct GalleryOptions {
  std::vector<std::string> people, acts;  // in this order
  double coarseness = 1.0;                // of the people's surfaces
  double scale = 1.0;                     // of what is rendered; the sheets keep their size
};

// DIR/people.jpg, DIR/<act>.jpg and DIR/gallery.md, which shows them. `progress` is told of each person that is done.
// Throws InvalidInput for people or acts that are not there, std::system_error if a file cannot be written.
void write_gallery(const std::filesystem::path& directory, const GalleryOptions& options,
                   const std::function<void(const std::string& person)>& progress = {});

}  // namespace rotunda::simulator
