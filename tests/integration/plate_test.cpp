// The empty studio, recorded by the daemon, goes into the takes after it; and what is said of takes.
#include "capture/picture.h"
#include "tests/integration/house_test.h"

namespace rotunda::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Plate : public StudioTest {};

TEST_F(Plate, SomebodyInTheStudioIsToldAndTheTakesAfterwardsKeepIt) {
  const auto rig = write_rig();
  const auto sim = start_sim(rig);  // somebody walks there all the time
  const auto daemon = start_daemon(rig);
  const auto plated = rotunda({"plate", "--frames", "8", "--json"});
  EXPECT_EQ(plated.exit_code, 1) << plated.out << plated.err;
  EXPECT_THAT(plated.err, HasSubstr("something moved before cam00"));
  const auto report = nlohmann::json::parse(plated.out);
  ASSERT_EQ(report["cameras"].size(), 3u);
  for (const auto& camera : report["cameras"]) {
    EXPECT_GE(camera["pictures"], 6);
    EXPECT_EQ(capture::read_rgb(camera["file"].get<std::string>()).size(), cv::Size(kWidth, kHeight));
  }
  ASSERT_EQ(rotunda({"take", "start", "after", "--frames", "2"}).exit_code, 0);
  EXPECT_EQ(contents_of(takes() / "after" / "background"), contents_of(takes() / ".plate"));
  EXPECT_THAT(rotunda({"take", "list"}).out, testing::Not(HasSubstr("plate"))) << "it is no take";
}

class Slate : public StudioTest {};

TEST_F(Slate, TakesAreCountedMarkedNotedRenamedAndTrimmed) {
  const auto rig = write_rig();
  const auto sim = start_sim(rig);
  const auto daemon = start_daemon(rig);
  ASSERT_EQ(rotunda({"take", "start", "--scene", "12", "--shot", "B"}).exit_code, 0);
  EXPECT_EQ(rotunda({"take", "mark", "slipped"}).exit_code, 0);
  EXPECT_EQ(rotunda({"take", "note", "12B-01", "while it runs"}).exit_code, 0);
  wait_for_status([](const auto& now) { return now["take"]["complete"] >= 4; });
  ASSERT_EQ(rotunda({"take", "stop"}).exit_code, 0);
  EXPECT_NE(rotunda({"take", "mark", "too late"}).exit_code, 0);
  EXPECT_EQ(rotunda({"take", "circle", "12B-01"}).exit_code, 0);
  const auto shown = nlohmann::json::parse(rotunda({"take", "show", "12B-01", "--json"}).out);
  EXPECT_EQ(shown["slate"], "12 B 1");
  EXPECT_EQ(shown["note"], "while it runs");
  EXPECT_EQ(shown["circled"], true);
  EXPECT_LT(shown["spread_max_us"], 1000.0) << "the cameras expose at one moment";
  EXPECT_THAT(rotunda({"take", "show", "12B-01"}).out, HasSubstr("slipped"));

  ASSERT_EQ(rotunda({"take", "start", "--scene", "12", "--shot", "B", "--frames", "2"}).exit_code, 0);
  EXPECT_TRUE(fs::exists(takes() / "12B-02"));
  EXPECT_EQ(rotunda({"take", "rename", "12B-02", "12B-01"}).exit_code, 3);
  EXPECT_EQ(rotunda({"take", "rename", "12B-02", "spare"}).exit_code, 0);
  EXPECT_EQ(rotunda({"take", "trim", "12B-01", "1:3", "-o", "middle"}).exit_code, 0);
  EXPECT_EQ(verify("middle", 0)["complete"], 2);
}

}  // namespace
}  // namespace rotunda::tests
