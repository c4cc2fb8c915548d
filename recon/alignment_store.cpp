#include "recon/alignment_store.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "config/errors.h"
#include "recon/geometry_image_file.h"
#include "recon/mesh/mesh_file.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/whole_file.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json json_of(const BodyTemplate& body) {
  json measures;
  for (std::size_t m = 0; m < kBodyMeasures; ++m)
    measures[std::string(to_string(static_cast<BodyMeasure>(m)))] = body.measures[m];
  return {{"measures", measures}};
}

std::optional<BodyTemplate> body_of(const fs::path& file) {
  try {
    const auto document = json::parse(read_text(file));
    if (!document.contains("measures")) return std::nullopt;
    BodyMeasures measures{};
    for (std::size_t m = 0; m < kBodyMeasures; ++m)
      measures[m] = document["measures"].at(std::string(to_string(static_cast<BodyMeasure>(m)))).get<double>();
    return make_template(measures);
  } catch (const json::exception& e) {
    throw CorruptData(file.string() + ": is no reference that rotunda wrote: " + e.what());
  } catch (const InvalidInput& e) {
    throw CorruptData(file.string() + ": " + e.what());
  }
}

void check(const AlignmentReference& reference, const fs::path& folder) {
  const auto samples = reference.lattice.size();
  const bool lattice = samples >= lattice_size(kMinLatticeLevel) && samples <= lattice_size(kMaxLatticeLevel) &&
                       lattice_size(lattice_level(samples)) == samples;
  if (!lattice || reference.surface.map.points.size() != reference.surface.mesh.positions.size() ||
      flipped_triangles(reference.surface.mesh, reference.surface.map) > 0)
    throw CorruptData(folder.string() + ": the reference is damaged; delete the folder and align again");
}

}  // namespace

fs::path AlignmentStore::folder_of(const fs::path& take) {
  return take / "recon" / "aligned";
}

AlignmentStore::AlignmentStore(fs::path folder, const std::string& settings) : folder_(std::move(folder)) {
  const auto settings_file = folder_ / "settings.json";
  if (fs::exists(folder_) && read_text(settings_file) != settings) fs::remove_all(folder_);
  fs::create_directories(folder_);
  write_text(settings_file, settings);
}

fs::path AlignmentStore::path(std::size_t frame, const char* ending) const {
  return folder_ / fmt::format("frame{:06}{}", frame, ending);
}

std::optional<AlignmentReference> AlignmentStore::reference() const {
  if (!fs::exists(folder_ / "reference.json")) return std::nullopt;
  AlignmentReference reference{.surface = {.mesh = read_ply(folder_ / "reference.ply"),
                                           .map = {read_directions(folder_ / "reference.sphere.tiff")}},
                               .lattice = read_directions(folder_ / "reference.lattice.tiff"),
                               .body = body_of(folder_ / "reference.json")};
  check(reference, folder_);
  compute_normals(reference.surface.mesh);
  return reference;
}

void AlignmentStore::save_reference(const AlignmentReference& reference) const {
  write_ply(folder_ / "reference.ply", reference.surface.mesh);
  write_directions(folder_ / "reference.sphere.tiff", reference.surface.map.points);
  write_directions(folder_ / "reference.lattice.tiff", reference.lattice);
  write_text(folder_ / "reference.json", (reference.body ? json_of(*reference.body) : json::object()).dump());
}

bool AlignmentStore::finished(std::size_t frame) const {
  return fs::exists(path(frame, ".colour.png"));
}

GeometryImage AlignmentStore::image(std::size_t frame) const {
  return read_geometry_image(path(frame, ".tiff"), path(frame, ".colour.png"));
}

std::string AlignmentStore::report(std::size_t frame) const {
  return read_text(path(frame, ".json"));
}

void AlignmentStore::save(std::size_t frame, const GeometryImage& image, const std::string& report) const {
  write_text(path(frame, ".json"), report + "\n");
  const auto unfinished = path(frame, ".unfinished.png");
  write_geometry_image(path(frame, ".tiff"), unfinished, image);
  fs::rename(unfinished, path(frame, ".colour.png"));
}

}  // namespace rotunda::recon
