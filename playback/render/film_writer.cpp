#include "playback/render/film_writer.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "capture/picture.h"
#include "config/errors.h"
#include "recon/video/media_file.h"

namespace rotunda::playback {
namespace {

void check_size(const cv::Mat& rgba, const FilmOptions& options) {
  if (rgba.type() != CV_8UC4 || rgba.cols != options.width || rgba.rows != options.height)
    throw InvalidInput(fmt::format("a picture of {} x {} does not fit a film of {} x {}", rgba.cols, rgba.rows,
                                   options.width, options.height));
}

recon::MediaFileOptions media_options(const FilmOptions& options) {
  if (options.width < 2 || options.height < 2 || options.width % 2 != 0 || options.height % 2 != 0)
    throw InvalidInput(
        fmt::format("a film of {} x {} pixels cannot be: both must be even", options.width, options.height));
  recon::VideoStream stream{.title = "film",
                            .codec = "libx264",
                            .pixel_format = "yuv420p",
                            .width = options.width,
                            .height = options.height,
                            .codec_options = {{"crf", std::to_string(options.quality)}, {"preset", "veryfast"}}};
  return {.container = "mp4",
          .fps = options.fps,
          .streams = {std::move(stream)},
          .attachments = {},
          .container_options = {{"movflags", "+faststart"}}};
}

class Mp4Writer : public FilmWriter {
 public:
  Mp4Writer(const std::filesystem::path& file, const FilmOptions& options)
      : options_(options), media_(file, media_options(options)) {}

  void write(const cv::Mat& rgba) override {
    check_size(rgba, options_);
    cv::Mat yuv;  // the three planes below one another
    cv::cvtColor(over_background(rgba, options_.background), yuv, cv::COLOR_RGB2YUV_I420);
    const int w = options_.width, h = options_.height;
    const cv::Mat y = yuv.rowRange(0, h);
    const cv::Mat u(h / 2, w / 2, CV_8UC1, yuv.ptr(h)), v(h / 2, w / 2, CV_8UC1, yuv.ptr(h) + w / 2 * (h / 2));
    const cv::Mat planes[] = {y, u, v};
    media_.write(0, planes);
  }

  void finish() override { media_.finish(); }

 private:
  FilmOptions options_;
  recon::MediaWriter media_;
};

class PngSequenceWriter : public FilmWriter {
 public:
  PngSequenceWriter(std::filesystem::path folder, const FilmOptions& options)
      : folder_(std::move(folder)), options_(options) {
    std::filesystem::create_directories(folder_);
  }

  void write(const cv::Mat& rgba) override {
    check_size(rgba, options_);
    const auto file = folder_ / fmt::format("frame{:06}.png", written_);
    const auto unfinished = folder_ / fmt::format(".frame{:06}.part.png", written_);
    capture::write_png(unfinished, rgba);
    std::filesystem::rename(unfinished, file);
    ++written_;
  }

  void finish() override {}

 private:
  std::filesystem::path folder_;
  FilmOptions options_;
  int written_ = 0;
};

}  // namespace

std::unique_ptr<FilmWriter> make_film_writer(const std::filesystem::path& path, const FilmOptions& options) {
  if (path.extension() == ".mp4") return std::make_unique<Mp4Writer>(path, options);
  if (path.extension().empty()) return std::make_unique<PngSequenceWriter>(path, options);
  throw InvalidInput(
      fmt::format("{}: films are NAME.mp4, or a folder's name without extension for PNG pictures", path.string()));
}

cv::Mat over_background(const cv::Mat& rgba, const recon::Colour& background) {
  cv::Mat rgb(rgba.size(), CV_8UC3);
  for (int row = 0; row < rgba.rows; ++row) {
    const std::uint8_t* from = rgba.ptr(row);
    std::uint8_t* to = rgb.ptr(row);
    for (int column = 0; column < rgba.cols; ++column, from += 4)
      for (std::size_t i = 0; i < 3; ++i)
        *to++ = static_cast<std::uint8_t>((from[i] * from[3] + background[i] * (255 - from[3]) + 127) / 255);
  }
  return rgb;
}

}  // namespace rotunda::playback
