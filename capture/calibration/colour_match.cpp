#include "capture/calibration/colour_match.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "capture/srgb.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kDarkness = 0.02;  // linear; keeps the relative error of dark places from ruling
constexpr double kOffDiagonal =
    0.10;  // how far a camera's matrix departs from gains, by experience of sensors' filters
constexpr double kNoiseCounts = 10.0;  // how much more than noise colours must differ to tell what mixes
constexpr double kFewestSamples = 6;   // for a matrix
constexpr double kFirm = 1e3;          // of the samples: greys say nothing against gains
constexpr int kRounds = 8;             // of reweighting
constexpr double kHuber = 1.5;         // standard deviations
constexpr double kLeftOut = 0.1;       // of the residuals, when they are told
constexpr double kTied = 1e-9;         // of the normal matrix' scale

using Group = std::vector<const ColourSample*>;  // one place's, of two cameras or more

std::vector<Group> shared_places(std::span<const ColourSample> samples, std::size_t cameras) {
  std::map<std::size_t, Group> places;
  for (const auto& sample : samples) {
    if (sample.camera >= cameras)
      throw InvalidInput(fmt::format("a colour of camera {}, of {}", sample.camera, cameras));
    places[sample.place].push_back(&sample);
  }
  std::vector<Group> shared;
  for (auto& [place, group] : places)
    if (std::any_of(group.begin(), group.end(), [&](const auto* s) { return s->camera != group[0]->camera; }))
      shared.push_back(std::move(group));
  return shared;
}

// Cameras that are tied to the most others by places in common, directly or through others.
std::vector<bool> tied_cameras(const std::vector<Group>& places, std::size_t cameras) {
  std::vector<std::size_t> root(cameras);
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const auto& group : places)
    for (const auto* sample : group) root[find(sample->camera)] = find(group[0]->camera);
  std::vector<std::size_t> size(cameras);
  for (std::size_t i = 0; i < cameras; ++i) ++size[find(i)];
  const auto largest = static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
  std::vector<bool> tied(cameras);
  for (std::size_t i = 0; i < cameras; ++i) tied[i] = size[largest] > 1 && find(i) == largest;
  return tied;
}

double brightness_of(const Group& group) {
  double sum = 0.0;
  for (const auto* sample : group) sum += sample->linear.mean();
  return sum / static_cast<double>(group.size()) + kDarkness;
}

// One pass over the places with fixed weights: the matrices that minimise, under a pull towards `towards`.
class Solver {
 public:
  Solver(const std::vector<Group>& places, const std::vector<bool>& tied) : places_(places), tied_(tied) {}

  // `gains`: one number a camera and channel; else whole rows. `pull`: the weight of towards, a camera each.
  std::vector<Eigen::Matrix3d> solve(const std::vector<std::vector<double>>& weights, bool gains,
                                     const std::vector<Eigen::Matrix3d>& towards,
                                     const std::vector<double>& pull) const;

 private:
  const std::vector<Group>& places_;
  const std::vector<bool>& tied_;
};

std::vector<Eigen::Matrix3d> Solver::solve(const std::vector<std::vector<double>>& weights, bool gains,
                                           const std::vector<Eigen::Matrix3d>& towards,
                                           const std::vector<double>& pull) const {
  const auto n = static_cast<Eigen::Index>(tied_.size());
  const Eigen::Index width = gains ? 1 : 3;
  std::vector<Eigen::Matrix3d> result(tied_.size(), Eigen::Matrix3d::Identity());
  for (Eigen::Index channel = 0; channel < 3; ++channel) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n * width, n * width);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n * width);
    // w_i |y_i - sum_j w_j y_j / W|^2 summed over i is sum_i w_i y_i^2 - (sum_i w_i y_i)^2 / W, y_i = c_i . x_i.
    for (std::size_t p = 0; p < places_.size(); ++p) {
      const auto& group = places_[p];
      const double scale = 1.0 / std::pow(brightness_of(group), 2);
      const double total = std::accumulate(weights[p].begin(), weights[p].end(), 0.0);
      if (total <= 0.0) continue;
      for (std::size_t i = 0; i < group.size(); ++i)
        for (std::size_t j = 0; j < group.size(); ++j) {
          const double w = scale * weights[p][i] * ((i == j ? 1.0 : 0.0) - weights[p][j] / total);
          const auto a = static_cast<Eigen::Index>(group[i]->camera) * width,
                     b = static_cast<Eigen::Index>(group[j]->camera) * width;
          if (gains)
            normal(a, b) += w * group[i]->linear[channel] * group[j]->linear[channel];
          else
            normal.block<3, 3>(a, b) += w * group[i]->linear * group[j]->linear.transpose();
        }
    }
    for (Eigen::Index i = 0; i < n * width; ++i) {
      const auto camera = static_cast<std::size_t>(i / width);
      const Eigen::Index column = gains ? channel : i % 3;
      const double hold = tied_[camera] ? pull[camera] : 1.0;  // who is tied to nobody keeps what it has
      normal(i, i) += hold;
      right[i] += hold * towards[camera](channel, column);
    }
    // The gauge: the tied cameras' mean is the identity, held as firmly as all places together.
    const double firm = normal.trace();
    for (Eigen::Index column = 0; column < width; ++column) {
      Eigen::VectorXd mean = Eigen::VectorXd::Zero(n * width);
      double tied = 0.0;
      for (Eigen::Index i = 0; i < n; ++i)
        if (tied_[static_cast<std::size_t>(i)]) mean[i * width + column] = 1.0, tied += 1.0;
      mean /= tied;
      const double wanted = gains || column == channel ? 1.0 : 0.0;
      normal += firm * mean * mean.transpose();
      right += firm * wanted * mean;
    }
    const Eigen::VectorXd solution = normal.ldlt().solve(right);
    for (Eigen::Index i = 0; i < n * width; ++i)
      result[static_cast<std::size_t>(i / width)](channel, gains ? channel : i % 3) = solution[i];
  }
  return result;
}

Eigen::Vector3d mean_of(const Group& group, const std::vector<double>& weights,
                        const std::vector<Eigen::Matrix3d>& matrices) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < group.size(); ++i) {
    sum += weights[i] * (matrices[group[i]->camera] * group[i]->linear);
    total += weights[i];
  }
  return total > 0.0 ? Eigen::Vector3d(sum / total) : sum;
}

// Of each sample to its place's mean, relative to the place's brightness.
std::vector<std::vector<double>> residuals(const std::vector<Group>& places,
                                           const std::vector<std::vector<double>>& weights,
                                           const std::vector<Eigen::Matrix3d>& matrices) {
  std::vector<std::vector<double>> all;
  for (std::size_t p = 0; p < places.size(); ++p) {
    const auto& group = places[p];
    const Eigen::Vector3d mean = mean_of(group, weights[p], matrices);
    auto& of_place = all.emplace_back();
    for (const auto* sample : group)
      of_place.push_back((matrices[sample->camera] * sample->linear - mean).norm() / brightness_of(group));
  }
  return all;
}

// A norm of three equal normal deviations has its median at 1.54 of them.
double scale_of(const std::vector<std::vector<double>>& all) {
  std::vector<double> flat;
  for (const auto& of_place : all) flat.insert(flat.end(), of_place.begin(), of_place.end());
  const auto middle = flat.begin() + static_cast<std::ptrdiff_t>(flat.size() / 2);
  std::nth_element(flat.begin(), middle, flat.end());
  return std::max(1e-4, *middle / 1.54);
}

// Huber's weights; returns the residuals' scale.
double reweigh(const std::vector<Group>& places, const std::vector<Eigen::Matrix3d>& matrices,
               std::vector<std::vector<double>>& weights) {
  const auto all = residuals(places, weights, matrices);
  const double scale = scale_of(all), limit = kHuber * std::sqrt(3.0) * scale;
  for (std::size_t p = 0; p < all.size(); ++p)
    for (std::size_t i = 0; i < all[p].size(); ++i) weights[p][i] = all[p][i] <= limit ? 1.0 : limit / all[p][i];
  return scale;
}

Eigen::Vector3d levels(const Eigen::Vector3d& linear) {
  Eigen::Vector3d result;
  for (int c = 0; c < 3; ++c) result[c] = 255.0 * srgb_of_linear(std::clamp(linear[c], 0.0, 1.0));
  return result;
}

double trimmed_rms(std::vector<double> squares) {
  if (squares.empty()) return 0.0;
  std::sort(squares.begin(), squares.end());
  const auto kept = static_cast<std::size_t>(std::ceil((1.0 - kLeftOut) * static_cast<double>(squares.size())));
  return std::sqrt(std::accumulate(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(kept), 0.0) /
                   static_cast<double>(kept));
}

// Squared distances, a channel's, to the mean of the other cameras; by camera.
std::vector<std::vector<double>> squared_levels(const std::vector<Group>& places,
                                                const std::vector<Eigen::Matrix3d>& matrices) {
  std::vector<std::vector<double>> by_camera(matrices.size());
  for (const auto& group : places)
    for (const auto* sample : group) {
      Eigen::Vector3d others = Eigen::Vector3d::Zero();
      double count = 0.0;
      for (const auto* other : group)
        if (other->camera != sample->camera) others += levels(matrices[other->camera] * other->linear), count += 1.0;
      const Eigen::Vector3d own = levels(matrices[sample->camera] * sample->linear);
      by_camera[sample->camera].push_back((own - others / count).squaredNorm() / 3.0);
    }
  return by_camera;
}

double over_all(const std::vector<std::vector<double>>& by_camera) {
  std::vector<double> all;
  for (const auto& one : by_camera) all.insert(all.end(), one.begin(), one.end());
  return trimmed_rms(std::move(all));
}

// Whether the colours that this camera saw span more than greys: the share of colour in its samples' spread.
bool is_colourful(const std::vector<Group>& places, std::size_t camera) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  double count = 0.0;
  for (const auto& group : places)
    for (const auto* sample : group)
      if (sample->camera == camera) {
        const Eigen::Vector3d relative = sample->linear / (sample->linear.mean() + kDarkness);
        spread += relative * relative.transpose();
        count += 1.0;
      }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  return count >= kFewestSamples && solver.eigenvalues()[0] > 1e-3 * solver.eigenvalues()[2];
}

}  // namespace

ColourMatch match_colours(std::span<const std::string> names, std::span<const ColourSample> samples) {
  const auto places = shared_places(samples, names.size());
  if (places.empty()) throw InvalidInput("no place was seen by two cameras: their colours cannot be compared");
  const auto tied = tied_cameras(places, names.size());
  const Solver solver(places, tied);
  std::vector<std::vector<double>> weights;
  for (const auto& group : places) weights.emplace_back(group.size(), 1.0);
  const std::vector<Eigen::Matrix3d> identities(names.size(), Eigen::Matrix3d::Identity());

  auto gains = identities;
  double scale = 1.0;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<double> barely(names.size(), kTied * static_cast<double>(samples.size()));
    gains = solver.solve(weights, true, identities, barely);
    scale = reweigh(places, gains, weights);
  }
  auto matrices = gains;
  const double samples_a_camera = static_cast<double>(samples.size()) / static_cast<double>(names.size());
  for (int round = 0; round < kRounds; ++round) {
    // Noise looks like colour to least squares: only what stands out of it may move a matrix away from gains.
    const double pull = scale * scale * (1.0 / (kOffDiagonal * kOffDiagonal) + kNoiseCounts * samples_a_camera);
    std::vector<double> pulls;
    for (std::size_t i = 0; i < names.size(); ++i)
      pulls.push_back(is_colourful(places, i) ? pull : kFirm * static_cast<double>(samples.size()));
    matrices = solver.solve(weights, false, gains, pulls);
    scale = reweigh(places, matrices, weights);
  }

  ColourMatch match;
  const auto before = squared_levels(places, identities), after = squared_levels(places, matrices);
  for (std::size_t i = 0; i < names.size(); ++i) {
    match.cameras.push_back({.matrix = tied[i] ? matrices[i] : Eigen::Matrix3d(Eigen::Matrix3d::Identity()),
                             .samples = before[i].size(),
                             .before = trimmed_rms(before[i]),
                             .after = trimmed_rms(after[i]),
                             .gains_only = !is_colourful(places, i)});
    if (!tied[i])
      match.advice.push_back(
          names[i] + " shares no place with the others: its colours stay as they are; it must see what they see");
  }
  match.before = over_all(before);
  match.after = over_all(after);
  return match;
}

}  // namespace rotunda::capture
