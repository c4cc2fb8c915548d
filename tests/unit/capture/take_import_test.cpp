#include "capture/take/take_import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <system_error>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "capture/take/take_export.h"
#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using namespace test;

cv::Mat noise_picture(int width, int height, std::uint64_t seed) {
  TakeCamera camera{.name = "", .width = width, .height = height, .format = PixelFormat::rgb8};
  return to_rgb(noise_image(camera, seed));
}

// Footage as somebody would bring it: three cameras of unlike sizes, four pictures each, background and mattes.
class TakeImport : public testing::Test {
 public:
  TakeImport() {
    for (int i = 0; i < 3; ++i) {
      CameraModel camera;
      camera.name = "side" + std::to_string(i);
      camera.width = 33 + 7 * i;
      camera.height = 21 + 5 * i;
      camera.K << 40, 0, 16, 0, 42, 10, 0, 0, 1;
      camera.t = {0.1 * i, 0, 2};
      cameras.push_back(camera);
    }
    options.name = "walk";
    options.takes = root.path() / "takes";
    options.images = root.path() / "images";
    options.calibration = root.path() / "calib.yaml";
    write_calibration(options.calibration, cameras);
    for (std::size_t i = 0; i < cameras.size(); ++i)
      for (std::size_t frame = 0; frame < 4; ++frame) write(image_file(i, frame), cameras[i], picture_seed(i, frame));
  }

  static std::uint64_t picture_seed(std::size_t camera, std::size_t frame) { return camera * 10 + frame; }
  fs::path image_file(std::size_t camera, std::size_t frame) const {
    return options.images / cameras[camera].name / ("shot" + std::to_string(frame) + ".png");
  }
  cv::Mat expected(std::size_t camera, std::size_t frame) const {
    return noise_picture(cameras[camera].width, cameras[camera].height, picture_seed(camera, frame));
  }
  static void write(const fs::path& file, const CameraModel& camera, std::uint64_t seed) {
    fs::create_directories(file.parent_path());
    write_png(file, noise_picture(camera.width, camera.height, seed));
  }
  std::string failure() const {
    try {
      import_take(options);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "imported";
  }
  bool nothing_left() const { return !fs::exists(options.takes) || fs::is_empty(options.takes); }

  TemporaryFolder root;
  std::vector<CameraModel> cameras;
  TakeImportOptions options;
};

bool same_pixels(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

TEST_F(TakeImport, KeepsEveryPixelOfEveryCamera) {
  std::size_t last = 0;
  options.fps = 50;
  const TakeInfo info = import_take(options, [&](std::size_t done, std::size_t total) {
    EXPECT_EQ(done, last + 1);
    EXPECT_EQ(total, 12U);
    last = done;
  });
  EXPECT_EQ(last, 12U);
  EXPECT_EQ(info.frame_sets, 4U);
  const TakeReader take(options.takes / "walk");
  EXPECT_EQ(take.info().state, TakeState::complete);
  EXPECT_EQ(take.info().complete_sets, 4U);
  EXPECT_EQ(read_calibration(calibration_file(take.folder())).size(), 3U);
  for (std::size_t frame = 0; frame < 4; ++frame) {
    const FrameSet set = take.read(frame);
    EXPECT_EQ((set.time - take.info().start).count(), static_cast<std::int64_t>(frame) * 20'000'000);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      ASSERT_TRUE(set.slots[i].frame);
      EXPECT_TRUE(same_pixels(to_rgb(set.slots[i].frame->image), expected(i, frame)));
    }
  }
}

TEST_F(TakeImport, ComesBackTheSameFromExport) {
  import_take(options);
  const TakeReader take(options.takes / "walk");
  const auto result = export_take(take, root.path() / "out");
  EXPECT_EQ(result.written, 12U);
  EXPECT_EQ(result.missing, 0U);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    for (std::size_t frame = 0; frame < 4; ++frame)
      EXPECT_TRUE(
          same_pixels(read_rgb(root.path() / "out" / cameras[i].name / frame_file_name(frame)), expected(i, frame)));
}

TEST_F(TakeImport, KeepsBackgroundAndMattes) {
  options.background = root.path() / "background";
  options.mattes = root.path() / "mattes";
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    write(options.background / (cameras[i].name + ".png"), cameras[i], 1000 + i);
    for (std::size_t frame = 0; frame < 4; ++frame) {
      fs::create_directories(options.mattes / cameras[i].name);
      write_png(options.mattes / cameras[i].name / (std::to_string(frame) + ".png"),
                cv::Mat(cameras[i].height, cameras[i].width, CV_8UC1, cv::Scalar(60.0 + static_cast<double>(frame))));
    }
  }
  import_take(options);
  const auto folder = options.takes / "walk";
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    EXPECT_TRUE(same_pixels(read_rgb(background_file(folder, cameras[i].name)),
                            noise_picture(cameras[i].width, cameras[i].height, 1000 + i)));
    EXPECT_EQ(read_grey(matte_file(folder, cameras[i].name, 3)).at<std::uint8_t>(0, 0), 63);
  }
}

// One silhouette, a bright column in the middle, in every form that programs write.
TEST_F(TakeImport, TakesMattesOfEveryKind) {
  const auto folder = root.path();
  const auto plane = [](int type, double white) {
    cv::Mat mask(21, 33, type, cv::Scalar::all(0));
    mask(cv::Rect(10, 0, 5, 21)).setTo(cv::Scalar::all(white));
    return mask;
  };
  const auto with_alpha = [&](const cv::Mat& alpha) {
    cv::Mat rgba;
    cv::merge(std::vector<cv::Mat>{alpha * 0.3, alpha * 0.5, alpha * 0.1, alpha}, rgba);
    return rgba;
  };
  cv::Mat opaque = plane(CV_8UC4, 255);
  cv::insertChannel(cv::Mat(opaque.size(), CV_8UC1, cv::Scalar(255)), opaque, 3);
  const std::vector<std::pair<const char*, cv::Mat>> kinds = {{"grey", plane(CV_8UC1, 255)},
                                                              {"of ones", plane(CV_8UC1, 1)},
                                                              {"grey as RGB", plane(CV_8UC3, 255)},
                                                              {"16 bits", plane(CV_16UC1, 65535)},
                                                              {"8 in 16 bits", plane(CV_16UC1, 255)},
                                                              {"alpha", with_alpha(plane(CV_8UC1, 255))},
                                                              {"16-bit alpha", with_alpha(plane(CV_16UC1, 65535))},
                                                              {"opaque RGBA", opaque}};
  for (const auto& [kind, picture] : kinds) {
    ASSERT_TRUE(cv::imwrite((folder / "matte.png").string(), picture)) << kind;
    EXPECT_TRUE(same_pixels(read_matte(folder / "matte.png"), plane(CV_8UC1, 255))) << kind;
  }
  ASSERT_TRUE(cv::imwrite((folder / "soft.png").string(), plane(CV_16UC1, 32768)));
  EXPECT_EQ(read_matte(folder / "soft.png").at<std::uint8_t>(3, 12), 128);
  write_png(folder / "colour.png", noise_picture(33, 21, 5));
  EXPECT_THROW(read_matte(folder / "colour.png"), CorruptData);
  std::ofstream(folder / "none.png") << "not a picture";
  EXPECT_THROW(read_matte(folder / "none.png"), CorruptData);
}

TEST_F(TakeImport, TakesGreyPicturesAsGrey) {
  const cv::Mat grey(cameras[1].height, cameras[1].width, CV_8UC1, cv::Scalar(77.0));
  write_png(image_file(1, 2), grey);
  import_take(options);
  const auto slot = TakeReader(options.takes / "walk").read(2, 1);
  ASSERT_TRUE(slot.frame);
  EXPECT_EQ(to_rgb(slot.frame->image).at<cv::Vec3b>(5, 5), cv::Vec3b(77, 77, 77));
}

struct Mistake {
  const char* what;
  std::function<void(TakeImport&)> make;
  std::vector<const char*> told;
};

void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << mistake.what;
}

class TakeImportMistake : public TakeImport, public testing::WithParamInterface<Mistake> {};

TEST_P(TakeImportMistake, IsNamedAndLeavesNothing) {
  GetParam().make(*this);
  const std::string text = failure();
  for (const char* part : GetParam().told) EXPECT_THAT(text, HasSubstr(part));
  EXPECT_TRUE(nothing_left());
}

const Mistake kMistakes[] = {
    {"no images folder", [](auto& t) { fs::remove_all(t.options.images); }, {"images is not a folder"}},
    {"a camera without pictures, and one that is not calibrated",
     [](auto& t) { fs::rename(t.options.images / "side1", t.options.images / "sied1"); },
     {"side1: is in the calibration, but", "sied1: has pictures in", "not in the calibration"}},
    {"a short camera", [](auto& t) { fs::remove(t.image_file(2, 1)); }, {"side2: 3 pictures in", "have 4"}},
    {"a picture of another size",
     [](auto& t) { t.write(t.image_file(0, 3), t.cameras[1], 1); },
     {"side0: ", "shot3.png is 40 x 26, the calibration is for 33 x 21"}},
    {"not a picture", [](auto& t) { std::ofstream(t.image_file(1, 2)) << "text"; }, {"side1: ", "shot2.png"}},
    {"a picture cut short", [](auto& t) { fs::resize_file(t.image_file(1, 2), 20); }, {"side1: ", "shot2.png"}},
    {"mistakes of two cameras",
     [](auto& t) {
       t.write(t.image_file(0, 0), t.cameras[2], 1);
       std::ofstream(t.image_file(2, 3)) << "text";
     },
     {"side0: ", "side2: "}},
    {"a camera without background",
     [](auto& t) {
       t.options.background = t.root.path() / "background";
       for (const int i : {0, 2})
         t.write(t.options.background / ("side" + std::to_string(i) + ".png"), t.cameras[static_cast<std::size_t>(i)],
                 1);
     },
     {"side1: has no background"}},
    {"fewer mattes than images",
     [](auto& t) {
       t.options.mattes = t.root.path() / "mattes";
       for (const auto& camera : t.cameras) t.write(t.options.mattes / camera.name / "0.png", camera, 1);
     },
     {"side0: 1 mattes for 4 images", "side2: 1 mattes for 4 images"}},
    {"a name that leaves the folder", [](auto& t) { t.options.name = "../walk"; }, {"cannot be the name of a take"}},
    {"one camera only",
     [](auto& t) {
       t.cameras.resize(1);
       write_calibration(t.options.calibration, t.cameras);
     },
     {"1 cameras, expected 2 to 64"}},
};
INSTANTIATE_TEST_SUITE_P(Footage, TakeImportMistake, testing::ValuesIn(kMistakes));

TEST_F(TakeImport, LeavesATakeThatExistsAlone) {
  fs::create_directories(options.takes / "walk");
  std::ofstream(options.takes / "walk" / "mine.txt") << "keep me";
  EXPECT_THAT(failure(), HasSubstr("exists already"));
  EXPECT_TRUE(fs::exists(options.takes / "walk" / "mine.txt"));
}

TEST_F(TakeImport, LeavesNothingWhenStopped) {
  std::stop_source stop;
  try {
    import_take(
        options, [&](std::size_t done, std::size_t) { done == 3 ? static_cast<void>(stop.request_stop()) : void(); },
        stop.get_token());
    FAIL();
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code(), std::errc::operation_canceled);
  }
  EXPECT_TRUE(nothing_left());
}

}  // namespace
}  // namespace rotunda::capture
