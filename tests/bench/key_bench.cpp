// How good the key is on the simulated people with every flaw of studio, lens and sensor, beside a plain threshold and
// OpenCV's MOG2, and what it costs.
//   key_bench [--development] [--keep DIR] [--pictures DIR] [--person NAME] [--no-baselines]
// Mattes: overlap (IoU) mean and worst, distance between the outlines both ways, its signed mean (positive: ours is too
// large). Colours: the rim's four pixels against the truth, by person and of all. Cost: CPU and wall time of ten
// pictures.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/background_segm.hpp>

#include "capture/matte/chroma_key.h"
#include "capture/matte/despill.h"
#include "capture/matte/learnt_plate.h"
#include "capture/matte/live_key.h"
#include "capture/matte/stage_mask.h"
#include "capture/picture.h"
#include "config/exit_code.h"
#include "recon/hull/matte_support.h"
#include "simulator/studio/camera_layout.h"
#include "tests/bench/key_score.h"
#include "tests/bench/key_study.h"

namespace rotunda::bench {
namespace {

using capture::Matte;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// All there is to key one moment with.
struct Given {
  const KeyMoment& moment;
  const std::vector<cv::Mat>&plates, &stages;
  std::vector<cv::Mat> pictures;  // RGB
};
using Method = std::function<std::vector<Matte>(const Given&)>;
using NamedMethods = std::vector<std::pair<std::string, Method>>;

std::vector<Matte> each(const Given& given, const std::function<cv::Mat(std::size_t)>& alpha_of) {
  std::vector<Matte> mattes;
  for (std::size_t i = 0; i < given.pictures.size(); ++i) mattes.push_back({alpha_of(i)});
  return mattes;
}

// By how much blue leads.
cv::Mat blue_lead(const cv::Mat& rgb) {
  cv::Mat channels[3], most, lead;
  cv::split(rgb, channels);
  cv::max(channels[0], channels[1], most);
  cv::subtract(channels[2], most, lead);
  return lead;
}

// Half of what the empty studio has in the median.
cv::Mat blue_difference(const cv::Mat& rgb, const cv::Mat& plate, const cv::Mat& stage) {
  cv::Mat lead = blue_lead(plate).clone().reshape(1, 1);
  std::nth_element(lead.begin<std::uint8_t>(), lead.begin<std::uint8_t>() + lead.cols / 2, lead.end<std::uint8_t>());
  return (blue_lead(rgb) < lead.at<std::uint8_t>(0, lead.cols / 2) / 2) & stage;
}

// Learns from the plate under fresh noise of two grey levels; its shadows count as background.
cv::Mat mog2(const cv::Mat& rgb, const cv::Mat& plate, const cv::Mat& stage) {
  constexpr int kLearnt = 8;  // pictures
  const auto model = cv::createBackgroundSubtractorMOG2(kLearnt, 16.0, true);
  cv::RNG random(5);
  cv::Mat found;
  for (int i = 0; i < kLearnt; ++i) {
    cv::Mat noise(plate.size(), CV_16SC3), noisy;
    random.fill(noise, cv::RNG::NORMAL, 0.0, 2.0);
    cv::add(plate, noise, noisy, cv::noArray(), CV_8U);
    model->apply(noisy, found);
  }
  model->apply(rgb, found, 0.0);
  return (found == 255) & stage;
}

NamedMethods methods(bool baselines) {
  NamedMethods all;
  all.emplace_back("key, plate", [](const Given& given) {
    return each(given, [&](std::size_t i) {
      return capture::chroma_key(given.pictures[i], {.backdrop = {}, .stage = given.stages[i]}, given.plates[i]).alpha;
    });
  });
  all.emplace_back("key, all views", [](const Given& given) {
    std::vector<capture::CameraModel> cameras;
    std::vector<Matte> mattes;
    for (std::size_t i = 0; i < given.pictures.size(); ++i) {
      cameras.push_back(given.moment.views[i].camera);
      mattes.push_back(
          capture::chroma_key(given.pictures[i], {.backdrop = {}, .stage = given.stages[i]}, given.plates[i]));
    }
    return recon::supported_mattes(cameras, mattes, {.bounds = simulator::kStageVolume}).mattes;
  });
  all.emplace_back("key, no plate", [](const Given& given) {
    return each(given, [&](std::size_t i) {
      return capture::chroma_key(given.pictures[i], {.backdrop = {}, .stage = given.stages[i]}).alpha;
    });
  });
  all.emplace_back("live key, plate", [](const Given& given) {
    return each(given, [&](std::size_t i) {
      const auto& image = given.moment.views[i].image;
      return capture::LiveKey(given.plates[i], image.format, {{}, given.stages[i]})(image).alpha;
    });
  });
  if (!baselines) return all;
  all.emplace_back("blue difference", [](const Given& given) {
    return each(given,
                [&](std::size_t i) { return blue_difference(given.pictures[i], given.plates[i], given.stages[i]); });
  });
  all.emplace_back("OpenCV MOG2", [](const Given& given) {
    return each(given, [&](std::size_t i) { return mog2(given.pictures[i], given.plates[i], given.stages[i]); });
  });
  return all;
}

void print(const std::string& who, const std::string& method, const MatteTotals& totals) {
  fmt::print("{:14} {:18} {:4} pictures  IoU {:.4f} worst {:.4f}  edge {:.3f} px p95 {:.2f}  bias {:+.3f} px\n", who,
             method, totals.pictures(), totals.overlap(), totals.worst_overlap(), totals.edge(),
             totals.edge_quantile(0.95), totals.bias());
}

cv::Mat side_by_side(const cv::Mat& rgb, const cv::Mat& found, const cv::Mat& truth) {
  cv::Mat both, out;
  cv::merge(std::vector<cv::Mat>{found, truth, truth}, both);  // red: too much, cyan: too little
  cv::hconcat(rgb, both, out);
  return out;
}

struct Mean {
  double sum = 0.0;
  int count = 0;
  void add(double value) { sum += value, ++count; }
  double value() const { return count ? sum / count : 0.0; }
};

// Rim colours: as they are and without spill, against the performer's own as lit by the blue studio and by a grey one.
struct RimErrors {
  Mean plain_own, plain_unspilt, own, unspilt;
};

void add_rim_errors(const KeyView& view, const cv::Mat& rgb, const cv::Mat& clean, RimErrors& errors) {
  errors.plain_own.add(rim_colour_error(rgb, view.own, view.truth));
  errors.plain_unspilt.add(rim_colour_error(rgb, view.unspilt, view.truth));
  errors.own.add(rim_colour_error(clean, view.own, view.truth));
  errors.unspilt.add(rim_colour_error(clean, view.unspilt, view.truth));
}

void print(const std::string& who, const RimErrors& errors) {
  fmt::print(
      "{:14} rim colours, of 255: against the performer's own {:.2f} (as they are {:.2f}), in a grey studio {:.2f} "
      "(as they are {:.2f})\n",
      who, errors.own.value(), errors.plain_own.value(), errors.unspilt.value(), errors.plain_unspilt.value());
}

// Cleaned, truth, and eight times the rim's difference: above mid-grey where ours is too bright.
cv::Mat rim_picture(const KeyView& view, const cv::Mat& clean) {
  cv::Mat off, out;
  cv::subtract(clean, view.own, off, cv::noArray(), CV_16S);
  off.convertTo(off, CV_8U, 8.0, 128.0);
  off.setTo(cv::Scalar::all(128), rim_mask(view.truth) == 0);
  cv::hconcat(std::vector<cv::Mat>{clean, view.own, off}, out);
  return out;
}

struct Options {
  bool development = false, no_baselines = false;
  std::string keep, pictures, person;
};

// The worst of a method or person so far.
struct Worst {
  double score = 2.0;  // the greater the better
  std::string what;
  cv::Mat picture;
  void hear(double of, const std::string& name, const std::function<cv::Mat()>& draw) {
    if (of < score) score = of, what = name, picture = draw();
  }
};

void write_worst(const Options& options, const std::string& kind, const std::map<std::string, Worst>& all) {
  if (options.pictures.empty()) return;
  for (const auto& [name, worst] : all)
    capture::write_png(std::filesystem::path(options.pictures) / fmt::format("{}{}, {}.png", kind, name, worst.what),
                       worst.picture);
}

class KeyBench {
 public:
  explicit KeyBench(Options options) : options_(std::move(options)), methods_(methods(!options_.no_baselines)) {}

  void run(const std::vector<KeyStudy>& studies) {
    for (const auto& study : studies)
      if (options_.person.empty() || options_.person == study.person) run(study);
    for (const auto& [person, by_method] : totals_)
      for (const auto& [name, method] : methods_) print(person, name, by_method.at(name));
    for (const auto& [name, method] : methods_) {
      MatteTotals all;
      for (const auto& [person, by_method] : totals_)
        if (person != "dan") all.add(by_method.at(name));
      print("all but dan", name, all);
    }
    for (const auto& [person, errors] : rims_) print(person, errors);
    print("all", all_rims_);
    write_worst(options_, "", worst_);
    write_worst(options_, "rim, ", worst_rims_);
    for (const auto& [name, cost] : costs_) fmt::print("{:18} {:.2f} ms CPU a picture\n", name, cost.value());
  }

 private:
  void run(const KeyStudy& study) {
    const auto rendered = render(study, options_.keep);
    std::vector<cv::Mat> stages;
    for (const auto& camera : study.cameras) stages.push_back(capture::stage_mask(camera, simulator::kStageVolume));
    for (std::size_t m = 0; m < rendered.moments.size(); ++m) {
      Given given{rendered.moments[m], rendered.plates, stages, {}};
      for (const auto& view : given.moment.views) given.pictures.push_back(capture::to_rgb(view.image));
      for (const auto& [name, method] : methods_) {
        const double begun = cpu_ms();
        const auto mattes = method(given);
        costs_[name].add((cpu_ms() - begun) / static_cast<double>(mattes.size()));
        score(fmt::format("{}-{}-{}", study.person, study.act, study.frames[m]), name, given, mattes, study.person);
      }
    }
  }

  void score(const std::string& what, const std::string& method, const Given& given, const std::vector<Matte>& mattes,
             const std::string& person) {
    for (std::size_t i = 0; i < mattes.size(); ++i) {
      const auto& view = given.moment.views[i];
      const auto found = matte_score(mattes[i].alpha, view.truth);
      totals_[person][method].add(found);
      if (method == "key, plate" && !view.own.empty()) score_rim(what, view, given.pictures[i], mattes[i], person);
      worst_[method + ", " + person].hear(found.overlap, fmt::format("{} {}", what, view.camera.name),
                                          [&] { return side_by_side(given.pictures[i], mattes[i].alpha, view.truth); });
    }
  }

  void score_rim(const std::string& what, const KeyView& view, const cv::Mat& rgb, const Matte& matte,
                 const std::string& person) {
    const cv::Mat clean = capture::despilled(view.image, matte, capture::Backdrop::blue);
    for (RimErrors* errors : {&rims_[person], &all_rims_}) add_rim_errors(view, rgb, clean, *errors);
    worst_rims_[person].hear(-rim_colour_error(clean, view.own, view.truth), what + " " + view.camera.name,
                             [&] { return rim_picture(view, clean); });
  }

  Options options_;
  NamedMethods methods_;
  std::map<std::string, std::map<std::string, MatteTotals>> totals_;
  std::map<std::string, Mean> costs_;
  std::map<std::string, Worst> worst_, worst_rims_;
  std::map<std::string, RimErrors> rims_;
  RimErrors all_rims_;
};

// Without a picture of the empty studio: the plate learnt from the take whose light drifts, beside the given plate and
// the surface fitted to each picture alone.
void print_learnt_plates(const std::vector<KeyStudy>& studies, const Options& options) {
  constexpr int kTakePictures = 16;
  std::map<std::string, MatteTotals> totals;
  std::map<std::string, Worst> worst;
  std::string last;
  for (const auto& study : studies) {
    if (study.person == last || (!options.person.empty() && study.person != options.person))
      continue;  // one act a person
    last = study.person;
    const auto rendered = render(study, options.keep);
    const auto take = render_drifting_take(study, kTakePictures, options.keep);
    for (std::size_t i = 0; i < study.cameras.size(); ++i) {
      const auto plate = capture::learn_plate(take[i], capture::Backdrop::blue).picture;
      const cv::Mat stage = capture::stage_mask(study.cameras[i], simulator::kStageVolume);
      for (const auto& moment : rendered.moments) {
        const auto& view = moment.views[i];
        const cv::Mat rgb = capture::to_rgb(view.image);
        const auto add = [&](const char* name, const Matte& matte) {
          const auto found = matte_score(matte.alpha, view.truth);
          totals[name].add(found);
          worst[name].hear(found.overlap, fmt::format("{}-{} {}", study.person, study.act, view.camera.name),
                           [&] { return side_by_side(rgb, matte.alpha, view.truth); });
        };
        const capture::ChromaKeyOptions key{.backdrop = {}, .stage = stage};
        add("given plate", capture::chroma_key(rgb, key, rendered.plates[i]));
        add("learnt plate", capture::chroma_key(rgb, key, plate));
        add("no plate", capture::chroma_key(rgb, key));
        add("live, given plate", capture::LiveKey(rendered.plates[i], view.image.format, {{}, stage})(view.image));
        add("live, learnt plate", capture::LiveKey(plate, view.image.format, {{}, stage})(view.image));
      }
    }
  }
  for (const auto& [name, sums] : totals) print("take", name, sums);
  write_worst(options, "take", worst);
}

// Each frame alone, and held by what the frames 40 ms before and after it show.
void print_held_between(const std::vector<KeyStudy>& studies, const Options& options) {
  std::map<std::string, MatteTotals> totals;
  for (auto study : studies) {
    if (!options.person.empty() && study.person != options.person) continue;
    const int middle = study.frames.front();
    study.frames = {middle - 1, middle, middle + 1};
    const auto rendered = render(study, options.keep);
    for (std::size_t i = 0; i < study.cameras.size(); ++i) {
      const cv::Mat stage = capture::stage_mask(study.cameras[i], simulator::kStageVolume);
      std::vector<Matte> alone;
      for (const auto& moment : rendered.moments)
        alone.push_back(capture::chroma_key(capture::to_rgb(moment.views[i].image), {.backdrop = {}, .stage = stage},
                                            rendered.plates[i]));
      const auto& view = rendered.moments[1].views[i];
      const auto held = capture::chroma_key(
          capture::to_rgb(view.image),
          {.backdrop = {}, .stage = stage, .held = capture::held_between(alone[0], alone[2])}, rendered.plates[i]);
      totals["key alone"].add(matte_score(alone[1].alpha, view.truth));
      totals["held between"].add(matte_score(held.alpha, view.truth));
    }
  }
  for (const auto& [name, sums] : totals) print("over time", name, sums);
}

// Ten cameras' images of one moment, as the live way has them.
void print_live_speed(const KeyStudy& study, const std::string& keep) {
  const auto rendered = render(study, keep);
  std::vector<capture::LiveKey> keys;
  std::vector<capture::Image> images;
  for (std::size_t i = 0; i < study.cameras.size(); ++i) {
    images.push_back(rendered.moments.front().views[i].image);
    const auto stage = capture::stage_mask(study.cameras[i], simulator::kStageVolume);
    keys.emplace_back(rendered.plates[i], images.back().format, capture::LiveKeyOptions{{}, stage});
  }
  std::vector<double> wall, cpu;
  for (int run = 0; run < 101; ++run) {
    const auto begun = std::chrono::steady_clock::now();
    const double cpu_begun = cpu_ms();
    capture::key_live(keys, images);
    wall.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count());
    cpu.push_back(cpu_ms() - cpu_begun);
  }
  std::sort(wall.begin(), wall.end());
  std::sort(cpu.begin(), cpu.end());
  fmt::print("live key, {} images: median {:.2f} ms wall, {:.2f} ms CPU (least {:.2f}, {:.2f})\n", images.size(),
             wall[wall.size() / 2], cpu[cpu.size() / 2], wall.front(), cpu.front());
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("The key against the simulator's truth", "key_bench");
  app.add_flag("--development", options.development, "the studies that constants are chosen on, not the held-out ones");
  app.add_option("--keep", options.keep, "keep rendered pictures in this folder for the next time");
  app.add_option("--pictures", options.pictures,
                 "write the worst mattes beside their pictures: red too much, cyan too little");
  app.add_flag("--no-baselines", options.no_baselines, "leave out what it is compared with");
  app.add_option("--person", options.person, "this person only");
  CLI11_PARSE(app, argc, argv);
  try {
    if (!options.pictures.empty()) std::filesystem::create_directories(options.pictures);
    const auto studies = options.development ? development_studies() : held_out_studies();
    print_live_speed(studies.front(), options.keep);
    KeyBench(options).run(studies);
    print_held_between(studies, options);
    print_learnt_plates(studies, options);
    return kDone;
  } catch (...) {
    return report_current_exception("key_bench");
  }
}

}  // namespace
}  // namespace rotunda::bench

int main(int argc, char** argv) {
  return rotunda::bench::run(argc, argv);
}
