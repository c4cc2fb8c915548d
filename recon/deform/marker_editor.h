#pragma once
// A set of markers under a person's hands: pairs are made, moved and taken away, on both sides of the body at once if
// wanted; every step can be undone, without end. What markers.yaml would refuse is refused here, in a sentence.
// Triangles of the scan come as the prepared scan numbers them, and are kept as its file does.
#include <optional>
#include <string>
#include <vector>

#include "recon/deform/body_mirror.h"
#include "recon/deform/markers.h"
#include "recon/deform/scan_preparation.h"

namespace rotunda::recon {

// What came of a step, for people.
struct MarkerEdit {
  bool done = false;
  std::string told;
};

class MarkerEditor {
 public:
  // Keeps a reference to the scan. `markers`: with the fit they belong to. Throws InvalidInput if they name triangles
  // that the scan does not have.
  MarkerEditor(const PreparedScan& scan, Markers markers);
  MarkerEditor(const MarkerEditor&) = delete;
  MarkerEditor& operator=(const MarkerEditor&) = delete;

  const Markers& markers() const { return markers_; }
  std::uint32_t on_prepared(const Marker& marker) const;  // the scan's triangle as the prepared scan numbers it

  const Marker* selected() const;            // nothing: null
  const Marker* mirror_of_selected() const;  // the pair that goes along with it; null: none, or one side is edited
  void select(std::optional<int> number) { selected_ = number; }
  void select_next(int step);  // round and round, in the order of the list

  bool symmetric() const { return symmetric_; }
  void set_symmetric(bool symmetric) { symmetric_ = symmetric; }

  MarkerEdit add(std::uint32_t template_triangle, std::uint32_t scan_triangle);
  MarkerEdit move_on_template(std::uint32_t template_triangle);  // of the selected pair
  MarkerEdit move_on_scan(std::uint32_t scan_triangle);
  MarkerEdit remove();
  MarkerEdit replace(const std::vector<Marker>& pairs);  // all of them, as one step; throws as the constructor
  MarkerEdit undo();
  MarkerEdit redo();

  long revision() const { return revision_; }  // another after each step, undone or done
  bool changed() const { return markers_.pairs != saved_; }
  void saved() { saved_ = markers_.pairs; }

 private:
  using Pairs = std::vector<Marker>;

  std::optional<std::size_t> place_of_selected() const;
  // The pair on the other side whose template triangle is where the pair's mirrored one is.
  std::optional<std::size_t> twin_of(const Marker& marker) const;
  bool on_midline(std::uint32_t template_triangle) const;
  MarkerEdit move(const Marker& to);
  std::optional<Marker> moved_twin(const Marker& to) const;
  std::optional<std::string> refusal(const Pairs& pairs, const Marker& marker) const;
  std::optional<Marker> mirrored_of(const Marker& marker, int number) const;
  void check(const Pairs& pairs) const;
  MarkerEdit take(Pairs pairs, std::string told);
  void put(Pairs pairs);

  const PreparedScan& scan_;
  Markers markers_;
  const TriangleMesh posed_;  // the template as the scan stands
  const BodyMirror mirror_;
  Pairs saved_;
  std::vector<Pairs> before_, after_;
  std::optional<int> selected_;
  bool symmetric_ = true;
  long revision_ = 0;
};

}  // namespace rotunda::recon
