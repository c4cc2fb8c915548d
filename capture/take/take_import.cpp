#include "capture/take/take_import.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <mutex>
#include <system_error>
#include <utility>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "capture/take/camera_file_writer.h"
#include "capture/take/picture_folders.h"
#include "capture/take/workplace.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewestCameras = 2;
constexpr std::size_t kMostCameras = 64;
constexpr std::size_t kMostTold = 50;  // problems; more would hide the first

void refuse_if_any(const Problems& problems, const std::string& take) {
  if (problems.empty()) return;
  std::string text = fmt::format("cannot import {}:", take);
  for (std::size_t i = 0; i < std::min(problems.size(), kMostTold); ++i) text += "\n  " + problems[i];
  if (problems.size() > kMostTold) text += fmt::format("\n  and {} more", problems.size() - kMostTold);
  throw InvalidInput(text);
}

// What belongs to one camera.
struct CameraSource {
  CameraModel model;
  std::vector<fs::path> images;
  fs::path background;           // empty if none
  std::vector<fs::path> mattes;  // empty if none
};

std::vector<CameraSource> find_sources(const TakeImportOptions& options) {
  const auto models = read_calibration(options.calibration);
  Problems problems;
  if (models.size() < kFewestCameras || models.size() > kMostCameras)
    problems.push_back(fmt::format("{} has {} cameras, expected {} to {}", options.calibration.string(), models.size(),
                                   kFewestCameras, kMostCameras));
  for (const auto& model : models)
    if (!valid_take_name(model.name)) problems.push_back(fmt::format("'{}' cannot be a camera's name", model.name));
  refuse_if_any(problems, options.name);
  const auto images = list_pictures(options.images, models, problems);
  std::vector<CameraSource> sources(models.size());
  for (std::size_t i = 0; i < models.size(); ++i)
    sources[i] = {.model = models[i], .images = images[i], .background = {}, .mattes = {}};
  if (!options.background.empty()) {
    const auto backgrounds = list_backgrounds(options.background, models, problems);
    for (std::size_t i = 0; i < models.size(); ++i) sources[i].background = backgrounds[i];
  }
  if (!options.mattes.empty()) {
    const auto mattes = list_pictures(options.mattes, models, problems);
    for (std::size_t i = 0; i < models.size(); ++i) {
      sources[i].mattes = mattes[i];
      if (!mattes[i].empty() && mattes[i].size() != images[i].size())
        problems.push_back(
            fmt::format("{}: {} mattes for {} images", models[i].name, mattes[i].size(), images[i].size()));
    }
  }
  refuse_if_any(problems, options.name);
  return sources;
}

Image as_image(cv::Mat rgb) {
  const auto owner = std::make_shared<const cv::Mat>(std::move(rgb));
  return {.width = owner->cols,
          .height = owner->rows,
          .format = PixelFormat::rgb8,
          .pixels = std::shared_ptr<const std::uint8_t>(owner, owner->data)};
}

TakeInfo describe(const TakeImportOptions& options, const std::vector<CameraSource>& sources) {
  TakeInfo info;
  info.name = info.slate = options.name;
  info.state = TakeState::complete;
  info.fps = options.fps;
  info.recorded = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  info.note = options.note;
  info.frame_sets = info.complete_sets = sources.front().images.size();
  for (const auto& source : sources)
    info.cameras.push_back({.name = source.model.name,
                            .width = source.model.width,
                            .height = source.model.height,
                            .format = PixelFormat::rgb8,
                            .frames = source.images.size(),
                            .missing = 0});
  return info;
}

// The work of one import, shared by the threads that each do one camera.
class Import {
 public:
  Import(const TakeInfo& info, fs::path folder, const Progress& progress, std::stop_token stop)
      : info_(info), folder_(std::move(folder)), progress_(progress), stop_(std::move(stop)) {
    total_ = info.frame_sets * info.cameras.size();
    problems_.resize(info.cameras.size());
  }

  void camera(std::size_t index, const CameraSource& source) {
    const TakeCamera& camera = info_.cameras[index];
    Problems& problems = problems_[index];
    CameraFileWriter file(camera_file(folder_, camera.name), camera, info_.fps);
    for (std::size_t frame = 0; frame < source.images.size(); ++frame) {
      image(file, source, frame, problems);
      if (!source.mattes.empty()) matte(source, frame, problems);
      step();
    }
    if (!source.background.empty()) background(source, problems);
    file.close();
  }

  Problems problems() const {
    Problems all;
    for (const auto& of_camera : problems_) all.insert(all.end(), of_camera.begin(), of_camera.end());
    return all;
  }

 private:
  // After the first problem the rest is read only to tell what else is wrong.
  void image(CameraFileWriter& file, const CameraSource& source, std::size_t frame, Problems& problems) const {
    cv::Mat rgb = read_fitting_rgb(source.images[frame], source.model, problems);
    if (!problems.empty()) return;
    const std::chrono::nanoseconds time(std::llround(static_cast<double>(frame) / info_.fps * 1e9));
    file.write({.camera = source.model.name,
                .trigger = frame,
                .exposure_start = info_.start + time,
                .exposure = {},
                .image = as_image(std::move(rgb))},
               {.moment = info_.start + time, .in_take = time});
  }

  void matte(const CameraSource& source, std::size_t frame, Problems& problems) const {
    const cv::Mat alpha = read_fitting_matte(source.mattes[frame], source.model, problems);
    const auto file = matte_file(folder_, source.model.name, frame);
    if (frame == 0) fs::create_directories(file.parent_path());
    if (problems.empty()) write_png(file, alpha);
  }

  void background(const CameraSource& source, Problems& problems) const {
    const cv::Mat rgb = read_fitting_rgb(source.background, source.model, problems);
    if (problems.empty()) write_png(background_file(folder_, source.model.name), rgb);
  }

  void step() {
    if (stop_.stop_requested())
      throw std::system_error(std::make_error_code(std::errc::operation_canceled), "importing " + info_.name);
    const std::lock_guard lock(mutex_);
    ++done_;
    if (progress_) progress_(done_, total_);
  }

  const TakeInfo& info_;
  fs::path folder_;
  const Progress& progress_;
  std::stop_token stop_;
  std::size_t total_ = 0;
  std::vector<Problems> problems_;  // by camera, each its own thread's
  std::mutex mutex_;                // guards done_ and progress_
  std::size_t done_ = 0;
};

void require_free_place(const TakeImportOptions& options) {
  if (!valid_take_name(options.name)) throw InvalidInput("'" + options.name + "' cannot be the name of a take");
  if (!(options.fps > 0.0)) throw InvalidInput("a take needs a rate above 0 frame sets a second");
  if (fs::exists(options.takes / options.name))
    throw InvalidInput((options.takes / options.name).string() + " exists already: choose another name for the take");
}

}  // namespace

TakeInfo import_take(const TakeImportOptions& options, const Progress& progress, std::stop_token stop) {
  require_free_place(options);
  const auto sources = find_sources(options);
  const TakeInfo info = describe(options, sources);
  Workplace workplace(options.takes / ("." + options.name + ".importing"));
  if (!options.background.empty()) fs::create_directory(workplace.folder() / "background");
  Import import(info, workplace.folder(), progress, std::move(stop));
  tbb::parallel_for(std::size_t{0}, sources.size(), [&](std::size_t i) { import.camera(i, sources[i]); });
  refuse_if_any(import.problems(), options.name);
  fs::copy_file(options.calibration, calibration_file(workplace.folder()));
  write_take_info(workplace.folder(), info);
  workplace.keep_as(workplace.folder(), options.takes / options.name);
  return info;
}

}  // namespace rotunda::capture
