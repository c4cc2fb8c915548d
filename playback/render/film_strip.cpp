#include "playback/render/film_strip.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "capture/picture.h"
#include "config/errors.h"

namespace rotunda::playback {
namespace {

constexpr int kLongestRow = 10;

class FilmStrip : public FilmWriter {
 public:
  FilmStrip(std::filesystem::path file, const FilmStripOptions& options)
      : file_(std::move(file)), options_(options), moments_(moments_of(options.pictures, options.moments)) {
    const int count = static_cast<int>(moments_.size());
    const int rows = (count + kLongestRow - 1) / kLongestRow;
    columns_ = (count + rows - 1) / rows;
    const auto& [r, g, b] = options_.background;
    sheet_.create(rows * options_.height, columns_ * options_.width, CV_8UC3);
    sheet_.setTo(cv::Scalar(r, g, b));
  }

  void write(const cv::Mat& rgba) override {
    if (rgba.type() != CV_8UC4 || rgba.cols != options_.width || rgba.rows != options_.height)
      throw InvalidInput(fmt::format("a picture of {} x {} does not fit a strip of {} x {}", rgba.cols, rgba.rows,
                                     options_.width, options_.height));
    if (next_ < moments_.size() && moments_[next_] == written_) {
      const int place = static_cast<int>(next_++);
      const cv::Rect at(place % columns_ * options_.width, place / columns_ * options_.height, rgba.cols, rgba.rows);
      over_background(rgba, options_.background).copyTo(sheet_(at));
    }
    ++written_;
  }

  void finish() override {
    auto unfinished = file_;
    unfinished.replace_extension(".part.png");
    capture::write_png(unfinished, sheet_);
    std::filesystem::rename(unfinished, file_);
  }

 private:
  std::filesystem::path file_;
  FilmStripOptions options_;
  std::vector<int> moments_;
  cv::Mat sheet_;  // RGB
  int columns_ = 1, written_ = 0;
  std::size_t next_ = 0;
};

}  // namespace

std::vector<int> moments_of(int pictures, int moments) {
  const int count = std::clamp(moments, 0, std::max(pictures, 0));
  std::vector<int> chosen;
  for (int i = 0; i < count; ++i) chosen.push_back(count > 1 ? i * (pictures - 1) / (count - 1) : 0);
  return chosen;
}

std::unique_ptr<FilmWriter> make_film_strip(const std::filesystem::path& file, const FilmStripOptions& options) {
  if (options.moments < 1 || options.pictures < 1 || options.width < 1 || options.height < 1)
    throw InvalidInput("a strip shows at least one moment of at least one picture");
  return std::make_unique<FilmStrip>(file, options);
}

}  // namespace rotunda::playback
