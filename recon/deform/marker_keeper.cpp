#include "recon/deform/marker_keeper.h"

namespace rotunda::recon {

MarkerKeeper::MarkerKeeper(std::filesystem::path file, std::string scan)
    : file_(std::move(file)), unsaved_(file_.string() + ".unsaved"), scan_(std::move(scan)) {}

std::optional<Markers> MarkerKeeper::left() const {
  if (!std::filesystem::exists(unsaved_)) return std::nullopt;
  return read_markers(unsaved_);
}

void MarkerKeeper::keep(const MarkerEditor& editor) {
  if (editor.revision() == kept_) return;
  kept_ = editor.revision();
  if (editor.changed())
    write_markers(unsaved_, editor.markers(), scan_);
  else
    std::filesystem::remove(unsaved_);
}

void MarkerKeeper::save(MarkerEditor& editor) {
  write_markers(file_, editor.markers(), scan_);
  editor.saved();
  kept_ = editor.revision();
  std::filesystem::remove(unsaved_);
}

}  // namespace rotunda::recon
