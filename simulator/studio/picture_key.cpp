#include "simulator/studio/picture_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "simulator/people/fingerprint.h"
#include "simulator/people/person.h"

namespace rotunda::simulator {
namespace {

std::string digest_of(std::string_view text) {
  Fingerprint print;
  print.add(text);
  return print.text();
}

// The renderer's version: the whole program that holds it.
std::string digest_of_this_program() {
  std::ifstream file("/proc/self/exe", std::ios::binary);
  Fingerprint print;
  std::vector<char> block(1 << 20);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
    print.add_bytes(block.data(), static_cast<std::size_t>(file.gcount()));
  if (file.bad()) throw std::system_error(errno, std::generic_category(), "/proc/self/exe");
  return print.text();
}

template <class Matrix>
std::vector<double> numbers_of(const Matrix& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

nlohmann::json describe(const capture::CameraModel& camera) {
  return {{"name", camera.name},       {"size", {camera.width, camera.height}},
          {"K", numbers_of(camera.K)}, {"distortion", numbers_of(camera.distortion)},
          {"R", numbers_of(camera.R)}, {"t", numbers_of(camera.t)}};
}

// Each field determines pixels: a new one must enter here, or this does not compile.
nlohmann::json describe(const CameraSettings& settings) {
  const auto& [exposure_s, gain_db, red_balance, blue_balance] = settings;
  return {exposure_s, gain_db, red_balance, blue_balance};
}

nlohmann::json describe(const SensorOptions& sensor) {
  const auto& [full_well, read_noise, vignetting, gain_spread, balance_spread, pixel_spread, hot_pixels, lens_blur,
               lens_blur_spread, lateral_colour, cameras, seed] = sensor;
  nlohmann::json described{{"full_well", full_well},
                           {"read_noise", read_noise},
                           {"vignetting", vignetting},
                           {"gain_spread", gain_spread},
                           {"balance_spread", balance_spread},
                           {"pixel_spread", pixel_spread},
                           {"hot_pixels", hot_pixels},
                           {"lens_blur", lens_blur},
                           {"lens_blur_spread", lens_blur_spread},
                           {"lateral_colour", lateral_colour},
                           {"cameras", nlohmann::json::array()},
                           {"seed", seed}};
  for (const auto& settings : cameras) described["cameras"].push_back(describe(settings));
  return described;
}

nlohmann::json describe(const BackdropOptions& backdrop) {
  const auto& [paint, unevenness, wear, gloss, wall_radius, wall_height, seed] = backdrop;
  return {paint == ScreenPaint::blue ? "blue" : "green", unevenness, wear, gloss, wall_radius, wall_height, seed};
}

}  // namespace

PictureKey picture_key(const std::string& performance, const std::vector<capture::CameraModel>& cameras,
                       const SensorOptions& sensor, capture::PixelFormat format, const BackdropOptions& backdrop) {
  static const std::string program = digest_of_this_program();
  nlohmann::json key{{"performance", performance},
                     {"sensor", describe(sensor)},
                     {"format", capture::to_string(format)},
                     {"act_step_s", kActStep},
                     {"program", program},
                     {"backdrop", describe(backdrop)},
                     {"cameras", nlohmann::json::array()}};
  for (const auto& camera : cameras) key["cameras"].push_back(describe(camera));
  PictureKey made{key.dump(1), {}};
  made.digest = digest_of(made.text);
  return made;
}

std::optional<std::string> fingerprint_of(const PerformanceOptions& options) {
  const auto names = person_names();
  if (std::find(names.begin(), names.end(), options.person) == names.end()) return std::nullopt;
  const auto& [person, act, motion, travel, seed, coarseness, texels] = options;  // as above: all have a say
  if (motion) return std::nullopt;  // what the file holds counts, not its name
  return fmt::format("{} {} travel {} seed {} coarseness {} texels {}", person, act, travel, seed, coarseness,
                     texels.value_or(0));
}

}  // namespace rotunda::simulator
