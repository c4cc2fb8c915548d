#include "recon/hull/photo_fit.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "recon/mesh/vertex_rings.h"

namespace rotunda::recon {
namespace {

constexpr float kNever = 1e6F;  // a cost

// Vertices of which no two are neighbours, as many as their order allows.
std::vector<char> every_other(const VertexRings& rings) {
  std::vector<char> chosen(rings.size(), 0);
  for (std::size_t v = 0; v < chosen.size(); ++v)
    chosen[v] = std::none_of(rings[v].begin(), rings[v].end(), [&](std::uint32_t n) { return chosen[n] != 0; }) ? 1 : 0;
  return chosen;
}

class PhotoFit {
 public:
  PhotoFit(const TriangleMesh& mesh, std::span<const float> rim_distance, std::span<const PhotoView> views,
           const PhotoFitOptions& options)
      : mesh_(mesh),
        rings_(mesh),
        rim_distance_(rim_distance),
        options_(options),
        labels_(static_cast<std::size_t>(2 * options.steps + 1)),
        step_(options.reach / options.steps),
        cost_(mesh.positions.size() * labels_, 0.0F),
        weight_(mesh.positions.size(), 0.0F) {
    ask(views);
    even(options.even_rounds);
    price();
  }

  std::vector<float> offsets() const {
    const std::size_t count = mesh_.positions.size();
    std::vector<float> smooth(count, 0.0F), found(count, 0.0F);
    constexpr int kRounds = 12, kSweeps = 4;
    float coupling = 0.02F;  // of a step's difference between what was found and the smooth field, squared
    for (int round = 0; round < kRounds; ++round, coupling *= 1.7F) {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1024),
                        [&](const tbb::blocked_range<std::size_t>& range) {
                          for (auto v = range.begin(); v != range.end(); ++v)
                            found[v] = best_near(v, smooth[v], coupling);
                        });
      for (int sweep = 0; sweep < kSweeps; ++sweep)
        for (std::size_t v = 0; v < count; ++v) smooth[v] = evened(v, smooth, found[v], coupling);
    }
    for (auto& offset : smooth) offset *= static_cast<float>(step_);
    return nowhere_steep(smooth);
  }

 private:
  void ask(std::span<const PhotoView> views) {
    const auto asked = options_.thinned ? every_other(rings_) : std::vector<char>(mesh_.positions.size(), 1);
    std::vector<double> offsets;
    for (std::size_t l = 0; l < labels_; ++l) offsets.push_back(offset_of(l));
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh_.positions.size(), 256),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (auto v = range.begin(); v != range.end(); ++v) {
                          if (asked[v] == 0) continue;
                          const SurfacePlace place{mesh_.positions[v].cast<double>(), mesh_.normals[v].cast<double>()};
                          const std::span<float> agreement(&cost_[v * labels_], labels_);
                          weight_[v] =
                              photo_agreement(views, place, offsets, options_.agreement, agreement) ? 1.0F : 0.0F;
                        }
                      });
  }

  // Normalised convolution over the surface.
  void even(int rounds) {
    std::vector<float> next(cost_.size()), next_weight(weight_.size());
    for (int round = 0; round < rounds; ++round) {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, weight_.size(), 256),
                        [&](const tbb::blocked_range<std::size_t>& range) {
                          for (auto v = range.begin(); v != range.end(); ++v) {
                            const float beside = 0.5F / static_cast<float>(rings_[v].size());
                            float weight = 0.5F * weight_[v];
                            for (const auto n : rings_[v]) weight += beside * weight_[n];
                            next_weight[v] = weight;
                            if (weight <= 0.0F) continue;
                            float* to = &next[v * labels_];
                            const float own = 0.5F * weight_[v] / weight;
                            for (std::size_t l = 0; l < labels_; ++l) to[l] = own * cost_[v * labels_ + l];
                            for (const auto n : rings_[v]) {
                              const float share = beside * weight_[n] / weight;
                              if (share > 0.0F)
                                for (std::size_t l = 0; l < labels_; ++l) to[l] += share * cost_[n * labels_ + l];
                            }
                          }
                        });
      cost_.swap(next);
      weight_.swap(next_weight);
    }
  }

  void price() {
    for (std::size_t v = 0; v < weight_.size(); ++v) {
      const double sigma = options_.prior_sigma + options_.prior_slope * static_cast<double>(rim_distance_[v]);
      const std::span<float> cost(&cost_[v * labels_], labels_);
      const bool asked = options_.farthest_sigmas * sigma >= options_.least_reach;
      const float photo = asked ? static_cast<float>(options_.photo_weight) * sureness(v, cost) : 0.0F;
      for (std::size_t l = 0; l < labels_; ++l) {
        const double off = offset_of(l) / sigma;
        const bool likely = std::abs(off) <= options_.farthest_sigmas;
        cost[l] = likely ? static_cast<float>(0.5 * off * off) + photo * (1.0F - cost[l]) : kNever;
      }
    }
  }

  // 0 where nobody sees the vertex, or another offset is as good as the best (a pattern that repeats), or the best is
  // what noise makes: correlations of n pixels deviate by 1 / sqrt(n). 1: trust it.
  float sureness(std::size_t v, std::span<const float> agreement) const {
    constexpr float kEnough = 0.5F;  // of the neighbourhood is seen
    const auto best =
        static_cast<std::size_t>(std::max_element(agreement.begin(), agreement.end()) - agreement.begin());
    float rival = -1.0F;
    for (std::size_t l = 0; l < labels_; ++l)
      if (std::abs(offset_of(l) - offset_of(best)) >= options_.rival_distance) rival = std::max(rival, agreement[l]);
    const float margin = std::clamp((agreement[best] - rival) / static_cast<float>(options_.sure_margin), 0.0F, 1.0F);
    const float deviations = agreement[best] * static_cast<float>(options_.agreement.patch);
    const float significance = std::clamp((deviations - 1.0F) / 2.0F, 0.0F, 1.0F);
    return std::min(1.0F, weight_[v] / kEnough) * margin * significance;
  }

  double offset_of(std::size_t label) const { return (static_cast<double>(label) - options_.steps) * step_; }

  std::vector<float> nowhere_steep(const std::vector<float>& field) const {
    auto below = envelope(field, 1.0F);
    const auto above = envelope(field, -1.0F);
    for (std::size_t v = 0; v < below.size(); ++v) below[v] = 0.5F * (below[v] + above[v]);
    return below;
  }

  // The largest field below this one (side 1), the smallest above it (-1), that is nowhere too steep (McShane 1934).
  std::vector<float> envelope(std::vector<float> field, float side) const {
    constexpr float kRounding = 1.0001F;
    const auto steepest = static_cast<float>(options_.steepest);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t v = 0; v < field.size(); ++v)
        for (const auto n : rings_[v]) {
          const float step = steepest * (mesh_.positions[v] - mesh_.positions[n]).norm();
          const float most = field[n] + side * step * kRounding;
          if (side * field[v] <= side * most) continue;
          field[v] = field[n] + side * step;
          changed = true;
        }
    }
    return field;
  }

  // In steps.
  float best_near(std::size_t v, float smooth, float coupling) const {
    const float* cost = &cost_[v * labels_];
    float best = 0.0F, least = 1e30F;
    for (std::size_t l = 0; l < labels_; ++l) {
      const float at = static_cast<float>(l) - static_cast<float>(options_.steps);
      const float energy = cost[l] + coupling * (at - smooth) * (at - smooth);
      if (energy < least) {
        least = energy;
        best = at;
      }
    }
    return best;
  }

  float evened(std::size_t v, const std::vector<float>& smooth, float found, float coupling) const {
    float sum = 0.0F;
    for (const auto n : rings_[v]) sum += smooth[n];
    const auto count = static_cast<float>(rings_[v].size());
    const float pull = static_cast<float>(options_.smoothness) / count;
    return (pull * sum + coupling * found) / (pull * count + coupling);
  }

  const TriangleMesh& mesh_;
  VertexRings rings_;
  std::span<const float> rim_distance_;
  PhotoFitOptions options_;
  std::size_t labels_;
  double step_;
  std::vector<float> cost_;    // by vertex, then by offset: the views' agreement, then what it costs
  std::vector<float> weight_;  // of what the views say, by vertex
};

}  // namespace

std::vector<float> photo_offsets(const TriangleMesh& mesh, std::span<const float> rim_distance,
                                 std::span<const PhotoView> views, const PhotoFitOptions& options) {
  return PhotoFit(mesh, rim_distance, views, options).offsets();
}

}  // namespace rotunda::recon
