#include "capture/base/av_objects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "config/errors.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

namespace rotunda::capture {
namespace {

using testing::HasSubstr;

TEST(AvObjects, PassGoodResultsThrough) {
  EXPECT_EQ(check(7, "read"), 7);
}

TEST(AvObjects, TurnAnErrnoIntoASystemError) {
  try {
    check(AVERROR(ENOSPC), "cam00.mkv");
    FAIL();
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code().value(), ENOSPC);
    EXPECT_THAT(error.what(), HasSubstr("cam00.mkv"));
  }
}

TEST(AvObjects, TurnInvalidDataIntoCorruptData) {
  EXPECT_THROW(check(AVERROR_INVALIDDATA, "cam00.mkv"), CorruptData);
}

TEST(AvObjects, NameTheFileThatIsMissingOrIsNoMedia) {
  EXPECT_THROW(open_input("/nowhere/at all.mkv"), std::system_error);
  const auto file = std::filesystem::path(testing::TempDir()) / "no:media.mkv";
  std::ofstream(file) << "this is a line of text";
  try {
    open_input(file);
    FAIL();
  } catch (const CorruptData& error) {
    EXPECT_THAT(error.what(), HasSubstr("no:media.mkv"));
  }
  std::filesystem::remove(file);
}

TEST(AvObjects, TellThatACodecIsMissing) {
  EXPECT_THROW(make_encoder("no such codec"), std::system_error);
  EXPECT_EQ(make_encoder("ffv1")->codec_id, AV_CODEC_ID_FFV1);
  EXPECT_EQ(make_decoder("ffv1")->codec_id, AV_CODEC_ID_FFV1);
}

TEST(AvObjects, WriteToTheFileTheyAreGiven) {
  const auto file = std::filesystem::path(testing::TempDir()) / "av_objects.mkv";
  open_output(file, "matroska");
  EXPECT_TRUE(std::filesystem::exists(file));
  std::filesystem::remove(file);
  EXPECT_THROW(open_output("/nowhere/out.mkv", "matroska"), std::system_error);
}

}  // namespace
}  // namespace rotunda::capture
