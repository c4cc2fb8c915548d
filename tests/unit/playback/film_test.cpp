#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <fstream>

#include "capture/picture.h"
#include "config/errors.h"
#include "playback/display/headless.h"
#include "playback/render/film_strip.h"
#include "playback/render/orbit_film.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::playback {
namespace {

class Film : public ::testing::Test {
 protected:
  Film() { std::filesystem::create_directories(folder_); }
  ~Film() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("rotunda_film_" + std::to_string(::getpid()));
};

// What the independent reader says of a film: codec, width, height, pixel format, rate, frames.
std::string ffprobe(const std::filesystem::path& film) {
  const std::string command =
      "ffprobe -v error -count_frames -select_streams v:0 -show_entries "
      "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames -of csv=p=0 " +
      film.string();
  std::string text;
  FILE* pipe = ::popen(command.c_str(), "r");
  for (std::array<char, 256> line{}; std::fgets(line.data(), line.size(), pipe);) text += line.data();
  EXPECT_EQ(::pclose(pipe), 0);
  return text;
}

std::filesystem::path ball_video(const std::filesystem::path& folder) {
  std::vector<recon::GeometryImage> images;
  for (int i = 0; i < 6; ++i)
    images.push_back(test::round_geometry_image({.level = 5, .centre = {0.2F * static_cast<float>(i), 0.0F, 1.0F}}));
  recon::write_geometry_video(folder / "geometry.mkv", images);
  return folder / "geometry.mkv";
}

TEST_F(Film, IsReadByOthersWithEveryFrame) {
  const auto file = folder_ / "film.mp4";
  auto film = make_film_writer(file, {.width = 64, .height = 48});
  for (int i = 0; i < 30; ++i) film->write(cv::Mat(48, 64, CV_8UC4, cv::Scalar(8.0 * i, 100, 50, 255)));
  EXPECT_FALSE(std::filesystem::exists(file));
  film->finish();
  EXPECT_EQ(ffprobe(file), "h264,64,48,yuv420p,25/1,30\n");
}

TEST_F(Film, StartsWithItsIndex) {
  const auto file = folder_ / "film.mp4";
  auto film = make_film_writer(file, {.width = 64, .height = 48});
  film->write(cv::Mat(48, 64, CV_8UC4, cv::Scalar::all(255)));
  film->finish();
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST_F(Film, LeavesNothingWhenAbandoned) {
  {
    auto film = make_film_writer(folder_ / "film.mp4", {.width = 64, .height = 48});
    film->write(cv::Mat(48, 64, CV_8UC4, cv::Scalar::all(255)));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST(FilmStrip, TakesTheFirstTheLastAndEvenMomentsBetween) {
  EXPECT_EQ(moments_of(31, 4), (std::vector{0, 10, 20, 30}));
  EXPECT_EQ(moments_of(3, 10), (std::vector{0, 1, 2}));
  EXPECT_EQ(moments_of(50, 1), std::vector{0});
}

// Twelve moments of twelve pictures whose red tells their number: two rows of six.
TEST_F(Film, AStripHasItsMomentsRowByRow) {
  const auto file = folder_ / "strip.png";
  auto strip = make_film_strip(file, {.width = 8, .height = 6, .pictures = 23, .moments = 12});
  for (int i = 0; i < 23; ++i) strip->write(cv::Mat(6, 8, CV_8UC4, cv::Scalar(10.0 * i, 0, 0, 255)));
  EXPECT_FALSE(std::filesystem::exists(file));
  strip->finish();
  const auto picture = capture::read_rgb(file);
  ASSERT_EQ(picture.size(), cv::Size(48, 12));
  for (int place = 0; place < 12; ++place)
    EXPECT_EQ(picture.at<cv::Vec3b>(3 + place / 6 * 6, 4 + place % 6 * 8)[0], 20 * place);
  EXPECT_THROW(strip->write(cv::Mat(6, 9, CV_8UC4)), InvalidInput);
  EXPECT_THROW(make_film_strip(file, {.moments = 0}), InvalidInput);
}

TEST_F(Film, RefusesWhatCannotBe) {
  EXPECT_THROW(make_film_writer(folder_ / "film.mp4", {.width = 63, .height = 48}), InvalidInput);
  EXPECT_THROW(make_film_writer(folder_ / "film.avi", {.width = 64, .height = 48}), InvalidInput);
  EXPECT_THROW(make_film_writer(folder_ / "no" / "film.mp4", {.width = 64, .height = 48}), std::system_error);
  auto film = make_film_writer(folder_ / "film.mp4", {.width = 64, .height = 48});
  EXPECT_THROW(film->write(cv::Mat(48, 66, CV_8UC4)), InvalidInput);
}

TEST_F(Film, ReducedPicturesKeepStraightAlpha) {
  cv::Mat large(2, 4, CV_8UC4, cv::Scalar::all(0));
  large.at<cv::Vec4b>(0, 0) = {200, 100, 50, 255};
  const cv::Mat small = reduce(large, 2);
  EXPECT_EQ(small.at<cv::Vec4b>(0, 0), cv::Vec4b(200, 100, 50, 64));
  EXPECT_EQ(small.at<cv::Vec4b>(0, 1), cv::Vec4b(0, 0, 0, 0));
}

TEST_F(Film, OrbitDrawsEveryFrameOnceRound) {
  const HeadlessDisplay display;
  recon::GeometryVideoReader video(ball_video(folder_));
  int told = 0;
  const OrbitFilmOptions options{.width = 96, .height = 64, .progress = [&](int done, int all) {
                                   EXPECT_EQ(done, ++told);
                                   EXPECT_EQ(all, 6);
                                 }};
  auto film = make_film_writer(folder_ / "pictures", {.width = 96, .height = 64});
  EXPECT_EQ(render_orbit(video, options, *film), 6);
  EXPECT_EQ(told, 6);
  // The film begins on the +x side: the ball's +x, red in these colours, is in the middle; half a turn later -x is.
  const cv::Mat first = capture::read_rgb(folder_ / "pictures" / "frame000000.png");
  const cv::Mat opposite = capture::read_rgb(folder_ / "pictures" / "frame000003.png");
  EXPECT_GT(first.at<cv::Vec3b>(32, 48)[0], 240);
  EXPECT_LT(opposite.at<cv::Vec3b>(32, 48)[0], 15);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "pictures" / "frame000006.png"));
}

TEST_F(Film, StoppedOrbitLeavesNoHalfFilm) {
  const HeadlessDisplay display;
  recon::GeometryVideoReader video(ball_video(folder_));
  std::stop_source stop;
  OrbitFilmOptions options{.width = 96, .height = 64, .pictures = 50, .stop = stop.get_token()};
  options.progress = [&](int done, int) {
    if (done == 4) stop.request_stop();
  };
  auto film = make_film_writer(folder_ / "orbit.mp4", {.width = 96, .height = 64});
  EXPECT_EQ(render_orbit(video, options, *film), 4);
  film.reset();
  EXPECT_FALSE(std::filesystem::exists(folder_ / "orbit.mp4"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "orbit.mp4.part"));
}

TEST_F(Film, OrbitRefusesFramesThatAreNotThere) {
  const HeadlessDisplay display;
  recon::GeometryVideoReader video(ball_video(folder_));
  auto film = make_film_writer(folder_ / "pictures", {.width = 96, .height = 64});
  EXPECT_THROW(render_orbit(video, {.width = 96, .height = 64, .first_frame = 6}, *film), InvalidInput);
  EXPECT_THROW(render_orbit(video, {.width = 96, .height = 64, .last_frame = 7}, *film), InvalidInput);
}

}  // namespace
}  // namespace rotunda::playback
