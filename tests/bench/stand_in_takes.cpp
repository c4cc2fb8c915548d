#include "tests/bench/stand_in_takes.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <random>

#include "recon/video/geometry_video.h"
#include "tests/support/truth_clip.h"

namespace rotunda::bench {
namespace {

// A sum of a few plane waves about as long as a hand is wide, as errors of reconstruction are.
class SmoothNoise {
 public:
  SmoothNoise(double deviation, unsigned seed) : amplitude_(deviation * std::sqrt(2.0 / kWaves)) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (auto& wave : waves_) {
      for (int i = 0; i < 3; ++i) wave.direction[i] = normal(random);
      wave.direction.normalize();
      for (int i = 0; i < 3; ++i) wave.frequency[i] = kFrequency * normal(random);
      wave.phase = 10.0 * normal(random);
    }
  }
  Eigen::Vector3d at(const Eigen::Vector3d& p) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& wave : waves_) sum += amplitude_ * std::sin(wave.frequency.dot(p) + wave.phase) * wave.direction;
    return sum * std::sqrt(3.0);
  }

 private:
  static constexpr int kWaves = 24;
  static constexpr double kFrequency = 40.0;  // radians a metre
  struct Wave {
    Eigen::Vector3d direction, frequency;
    double phase = 0.0;
  };
  double amplitude_;
  std::array<Wave, kWaves> waves_;
};

void disturb(std::vector<recon::GeometryImage>& images, double noise) {
  for (std::size_t frame = 0; frame < images.size(); ++frame) {
    const SmoothNoise field(noise, static_cast<unsigned>(frame) + 1);
    for (auto& position : images[frame].positions) position += field.at(position.cast<double>()).cast<float>();
  }
}

}  // namespace

void write_stand_ins(const std::filesystem::path& folder, const StandInOptions& options) {
  std::filesystem::create_directories(folder);
  std::optional<tests::TruthLattice> lattice;
  for (const auto& act : options.acts) {
    const auto performance = simulator::make_performance({.person = options.person, .act = act});
    if (!lattice) lattice = tests::truth_lattice(*performance, options.level);
    const int repeated = static_cast<int>(std::lround(25.0 * options.seconds));
    const int frames = performance->is_cyclic() ? repeated : performance->frames();
    auto images = tests::truth_clip(*performance, *lattice, 0, frames);
    if (options.noise > 0.0) disturb(images, options.noise);
    recon::write_geometry_video(folder / (act + ".mkv"), images);
    fmt::print("{}: {} frames\n", act, frames);
  }
}

}  // namespace rotunda::bench
