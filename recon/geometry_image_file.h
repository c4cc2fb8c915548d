#pragma once
// Private to recon: a geometry image as two files, float positions (TIFF) and colours with coverage as alpha (PNG);
// and matrices of numbers as TIFF.
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "recon/sphere/geometry_image.h"

namespace rotunda::recon {

// Throw std::system_error; those that read CorruptData if a file is missing or damaged.
void write_geometry_image(const std::filesystem::path& positions, const std::filesystem::path& colours,
                          const GeometryImage& image);
GeometryImage read_geometry_image(const std::filesystem::path& positions, const std::filesystem::path& colours);

// A row of three doubles a direction.
void write_directions(const std::filesystem::path& file, const std::vector<Eigen::Vector3d>& directions);
std::vector<Eigen::Vector3d> read_directions(const std::filesystem::path& file);

}  // namespace rotunda::recon
