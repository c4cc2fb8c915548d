#include "simulator/gallery.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "config/errors.h"

namespace rotunda::simulator {
namespace {

namespace fs = std::filesystem;

struct TemporaryFolder {
  fs::path path = fs::temp_directory_path() / ("rotunda-gallery-" + std::to_string(getpid()));
  ~TemporaryFolder() { fs::remove_all(path); }
};

TEST(Gallery, HasASheetOfEveryActAndAPageThatShowsThem) {
  const TemporaryFolder folder;
  std::vector<std::string> told;
  write_gallery(folder.path, {.people = {"alex"}, .acts = {"a-pose"}, .coarseness = 1.4, .scale = 0.25},
                [&](const std::string& person) { told.push_back(person); });
  EXPECT_EQ(told, std::vector<std::string>{"alex"});
  const cv::Mat sheet = cv::imread((folder.path / "a-pose.jpg").string());
  ASSERT_FALSE(sheet.empty());
  const auto mean = cv::mean(sheet(cv::Rect(20, 100, 20, 100)));  // beside the person stands the blue screen
  EXPECT_GT(mean[0], 2.0 * mean[2]);
  std::stringstream page;
  page << std::ifstream(folder.path / "gallery.md").rdbuf();
  EXPECT_NE(page.str().find("](a-pose.jpg)"), std::string::npos);
}

TEST(Gallery, AnUnknownActIsRefused) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_gallery(folder.path, {.people = {}, .acts = {"fly"}}), InvalidInput);
}

}  // namespace
}  // namespace rotunda::simulator
