#include "capture/calibration/board_video.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cmath>
#include <limits>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <set>

#include "capture/base/av_objects.h"
#include "capture/picture.h"
#include "config/errors.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::array kEndings = {".mp4", ".mkv", ".avi", ".mov", ".webm", ".m4v", ".mpg", ".ts"};
constexpr double kStretch = 0.5;          // seconds
constexpr std::size_t kMostStills = 150;  // of one video: more boards add time and hardly accuracy
constexpr int kSmallWidth = 48;           // pixels of a frame's small copy, in which motion is looked for
constexpr double kMovingShare = 0.02;     // of the picture: a board in the distance
constexpr double kQuietShare = 0.1;       // of the frames: their change is taken for noise
constexpr double kStillEnough = 3.0;      // noises, the mean of all cameras
constexpr double kNewShown = 4.0;         // noises
constexpr double kLeastNoise = 0.2;       // levels: compressed videos stand perfectly still at times

using Small = cv::Mat;  // CV_8UC1

// One video's frames one after the other as RGB.
class VideoFrames {
 public:
  explicit VideoFrames(const fs::path& file) : file_(file), input_(open_input(file)), packet_(make_packet()) {
    check(avformat_find_stream_info(input_.get(), nullptr), file.string());
    const AVCodec* decoder = nullptr;
    stream_ = check(av_find_best_stream(input_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0),
                    file.string() + " holds no video");
    codec_ = make_decoder(decoder->name);
    const AVStream& stream = *input_->streams[stream_];
    check(avcodec_parameters_to_context(codec_.get(), stream.codecpar), file.string());
    check(avcodec_open2(codec_.get(), decoder, nullptr), file.string());
    frame_ = make_frame();
    rate_ = av_q2d(av_guess_frame_rate(input_.get(), input_->streams[stream_], nullptr));
  }

  double rate() const { return rate_; }  // frames a second; 0: not told
  bool is_damaged() const { return damaged_; }
  // The next frame; empty at the end.
  cv::Mat next() {
    while (true) {
      const int result = avcodec_receive_frame(codec_.get(), frame_.get());
      if (result >= 0) return as_rgb();
      if (result != AVERROR(EAGAIN)) return {};
      if (!send_more()) return {};
    }
  }

 private:
  bool send_more() {
    while (!at_end_) {
      const int read = av_read_frame(input_.get(), packet_.get());
      if (read < 0) {
        at_end_ = true;
        damaged_ = damaged_ || read != AVERROR_EOF;
        return avcodec_send_packet(codec_.get(), nullptr) >= 0;
      }
      const bool ours = packet_->stream_index == stream_;
      const int sent = ours ? avcodec_send_packet(codec_.get(), packet_.get()) : 0;
      av_packet_unref(packet_.get());
      damaged_ = damaged_ || sent < 0;
      if (ours && sent >= 0) return true;
    }
    return false;
  }

  cv::Mat as_rgb() {
    const auto format = static_cast<AVPixelFormat>(frame_->format);
    scaler_.reset(sws_getCachedContext(scaler_.release(), frame_->width, frame_->height, format, frame_->width,
                                       frame_->height, AV_PIX_FMT_RGB24, SWS_BICUBIC | SWS_ACCURATE_RND, nullptr,
                                       nullptr, nullptr));
    if (!scaler_) throw CorruptData(file_, 0, "has frames in a format that cannot be converted");
    cv::Mat rgb(frame_->height, frame_->width, CV_8UC3);
    std::array<std::uint8_t*, 4> planes = {rgb.data};
    const std::array<int, 4> strides = {static_cast<int>(rgb.step)};
    sws_scale(scaler_.get(), frame_->data, frame_->linesize, 0, frame_->height, planes.data(), strides.data());
    return rgb;
  }

  fs::path file_;
  AvInput input_;
  AvCodec codec_;
  AvPacket packet_;
  AvFrame frame_;
  AvScaler scaler_;
  int stream_ = 0;
  double rate_ = 0.0;
  bool at_end_ = false, damaged_ = false;
};

Small small_of(const cv::Mat& rgb) {
  cv::Mat green, small;
  cv::extractChannel(rgb, green, 1);
  const int height = std::max(1, static_cast<int>(std::lround(kSmallWidth * rgb.rows / static_cast<double>(rgb.cols))));
  cv::resize(green, small, {kSmallWidth, height}, 0, 0, cv::INTER_AREA);
  return small;
}

// How much the part of the picture changed that changed most, in levels.
double change(const Small& a, const Small& b) {
  cv::Mat off;
  cv::absdiff(a, b, off);
  std::vector<std::uint8_t> all(off.begin<std::uint8_t>(), off.end<std::uint8_t>());
  const auto moving =
      std::max<std::size_t>(1, static_cast<std::size_t>(kMovingShare * static_cast<double>(all.size())));
  std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(moving), all.end(), std::greater<>());
  double sum = 0.0;
  for (std::size_t i = 0; i < moving; ++i) sum += all[i];
  return sum / static_cast<double>(moving);
}

struct Watched {
  std::vector<Small> small = {};     // a frame
  std::vector<double> changes = {};  // against the frame before
  double noise = kLeastNoise;
  double rate = 0.0;
  bool damaged = false;
};

Watched watch(const fs::path& file) {
  VideoFrames video(file);
  Watched watched{.rate = video.rate()};
  for (cv::Mat rgb = video.next(); !rgb.empty(); rgb = video.next()) {
    watched.small.push_back(small_of(rgb));
    const auto n = watched.small.size();
    watched.changes.push_back(n > 1 ? change(watched.small[n - 2], watched.small[n - 1]) : 0.0);
  }
  if (watched.small.empty()) throw CorruptData(file, 0, "holds no frame that can be decoded");
  watched.damaged = video.is_damaged();
  auto sorted = watched.changes;
  const auto quiet = sorted.begin() + static_cast<std::ptrdiff_t>(kQuietShare * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), quiet, sorted.end());
  watched.noise = std::max(kLeastNoise, *quiet);
  return watched;
}

double one_rate(const std::vector<Watched>& all, const std::vector<fs::path>& videos) {
  for (std::size_t i = 1; i < all.size(); ++i)
    if (std::abs(all[i].rate - all[0].rate) > 0.01 * all[0].rate)
      throw InvalidInput(
          fmt::format("{} has {:g} frames a second, {} has {:g}: videos of boards run at one rate and "
                      "begin together, so that their frames show the same moments",
                      videos[0].string(), all[0].rate, videos[i].string(), all[i].rate));
  return all[0].rate > 0.0 ? all[0].rate : 25.0;
}

// Towards the frame after as well: a board that is about to move is blurred already.
double motion_at(const std::vector<Watched>& all, std::size_t frame) {
  double sum = 0.0, count = 0.0;
  for (const auto& video : all)
    for (const std::size_t i : {frame, frame + 1})
      if (i < video.changes.size()) sum += video.changes[i] / video.noise, count += 1.0;
  return sum / std::max(1.0, count);
}

bool shows_something_new(const std::vector<Watched>& all, std::size_t frame, std::size_t before) {
  return std::any_of(all.begin(), all.end(), [&](const auto& video) {
    return frame < video.small.size() && before < video.small.size() &&
           change(video.small[before], video.small[frame]) > kNewShown * video.noise;
  });
}

std::vector<std::size_t> still_frames(const std::vector<Watched>& all, double rate) {
  std::size_t frames = 0;
  for (const auto& video : all) frames = std::max(frames, video.small.size());
  const auto stretch = std::max({std::size_t{1}, static_cast<std::size_t>(std::lround(kStretch * rate)),
                                 (frames + kMostStills - 1) / kMostStills});
  std::vector<std::size_t> kept;
  for (std::size_t begin = 0; begin < frames; begin += stretch) {
    std::size_t stillest = begin;
    double least = std::numeric_limits<double>::max();
    for (std::size_t frame = begin; frame < std::min(frames, begin + stretch); ++frame)
      if (const double motion = motion_at(all, frame); motion < least) least = motion, stillest = frame;
    if (least > kStillEnough) continue;
    if (kept.empty() || shows_something_new(all, stillest, kept.back())) kept.push_back(stillest);
  }
  return kept;
}

void write_frames(const fs::path& file, const std::vector<std::size_t>& frames, const fs::path& folder) {
  fs::create_directories(folder);
  VideoFrames video(file);
  const std::set<std::size_t> wanted(frames.begin(), frames.end());
  for (std::size_t frame = 0; frame <= frames.back(); ++frame) {
    const cv::Mat rgb = video.next();
    if (rgb.empty()) return;
    if (wanted.contains(frame)) write_png(folder / fmt::format("frame{:06}.png", frame), rgb);
  }
}

}  // namespace

std::vector<fs::path> videos_in(const fs::path& folder) {
  std::vector<fs::path> videos;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (entry.is_regular_file() && std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end())
      videos.push_back(entry.path());
  }
  std::sort(videos.begin(), videos.end());
  const auto twice = std::adjacent_find(videos.begin(), videos.end(),
                                        [](const auto& a, const auto& b) { return a.stem() == b.stem(); });
  if (twice != videos.end())
    throw InvalidInput(
        fmt::format("{} and {} would be one camera: leave one of them", twice->string(), std::next(twice)->string()));
  return videos;
}

BoardStills write_board_stills(const std::vector<fs::path>& videos, const fs::path& out,
                               const std::function<void(std::size_t, std::size_t)>& progress) {
  std::vector<Watched> watched(videos.size());
  std::atomic<std::size_t> done = 0;
  std::mutex telling;
  const auto tell = [&] {
    const std::size_t now = ++done;
    if (!progress) return;
    const std::scoped_lock lock(telling);
    progress(now, 2 * videos.size());
  };
  tbb::parallel_for(std::size_t{0}, videos.size(), [&](std::size_t i) {
    watched[i] = watch(videos[i]);
    tell();
  });
  BoardStills stills{.frames = still_frames(watched, one_rate(watched, videos)), .troubles = {}};
  for (std::size_t i = 0; i < videos.size(); ++i)
    if (watched[i].damaged)
      stills.troubles.push_back(
          fmt::format("{} is damaged: its {} whole frames are used", videos[i].string(), watched[i].small.size()));
  tbb::parallel_for(std::size_t{0}, videos.size(), [&](std::size_t i) {
    write_frames(videos[i], stills.frames, out / videos[i].stem());
    tell();
  });
  return stills;
}

}  // namespace rotunda::capture
