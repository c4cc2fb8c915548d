#pragma once
// What alignment keeps of a take, in its folder recon/aligned:
//   reference.ply, reference.sphere.tiff   the surface that is carried through the frames, and its sphere map
//   reference.lattice.tiff                 the directions it is sampled at: a row of three doubles a sample
//   reference.json                         the body's measures, if the reference is a person's: {"measures": {...}}
//   frame000012.tiff, frame000012.colour.png, frame000012.json   each frame's image, and how well it fits
// A frame counts as finished once its last file, the picture of colours, is there. settings.json says what all was made
// with.
#include <filesystem>
#include <optional>
#include <string>

#include "recon/sphere/geometry_image.h"
#include "recon/video/sequence_alignment.h"

namespace rotunda::recon {

class AlignmentStore {
 public:
  static std::filesystem::path folder_of(const std::filesystem::path& take);

  // For reading what is there.
  explicit AlignmentStore(std::filesystem::path folder) : folder_(std::move(folder)) {}
  // What was made with other settings (a JSON text) than these is deleted. Throws std::system_error.
  AlignmentStore(std::filesystem::path folder, const std::string& settings);

  // Throw CorruptData if a file is damaged, std::system_error.
  std::optional<AlignmentReference> reference() const;
  void save_reference(const AlignmentReference& reference) const;
  bool finished(std::size_t frame) const;
  GeometryImage image(std::size_t frame) const;  // normals read off the lattice
  std::string report(std::size_t frame) const;   // JSON
  void save(std::size_t frame, const GeometryImage& image, const std::string& report) const;

 private:
  std::filesystem::path path(std::size_t frame, const char* ending) const;

  std::filesystem::path folder_;
};

}  // namespace rotunda::recon
