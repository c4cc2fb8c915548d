#pragma once
// Where edited markers are kept: saved when asked for, and every step that is not saved in FILE.unsaved beside it, so
// that a closed window or a power cut loses nothing. Both are whole or not there.
#include <filesystem>
#include <optional>
#include <string>

#include "recon/deform/marker_editor.h"

namespace rotunda::recon {

class MarkerKeeper {
 public:
  // `scan`: the name to write of the scan they belong to.
  MarkerKeeper(std::filesystem::path file, std::string scan);

  const std::filesystem::path& file() const { return file_; }
  const std::filesystem::path& unsaved() const { return unsaved_; }
  // What was left unsaved the last time. Throws what read_markers throws.
  std::optional<Markers> left() const;

  // After every step. Throws std::system_error once for a step that cannot be kept.
  void keep(const MarkerEditor& editor);
  void save(MarkerEditor& editor);  // throws std::system_error; then what was unsaved is unsaved still

 private:
  std::filesystem::path file_, unsaved_;
  std::string scan_;
  long kept_ = 0;  // revision
};

}  // namespace rotunda::recon
