#include "recon/body/bvh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

// What files in the wild do: tabs, CRLF, exponents, plus signs, braces on the name's line, names with blanks and
// colons, positions on a joint, another channel order a joint, no newline at the end.
constexpr std::string_view kArm =
    "\xEF\xBB\xBFHIERARCHY\r\n"
    "ROOT mixamorig:Hips {\r\n"
    "\tOFFSET 1 2\t3\r\n"
    "\tCHANNELS 6 Zposition Yposition Xposition Zrotation Xrotation Yrotation\r\n"
    "\tJOINT Upper Arm\r\n\t{\r\n\t\tOFFSET 0 1e1 -0.0E+0\r\n\t\tCHANNELS 3 yrotation zrotation xrotation\r\n"
    "\t\tJOINT Hand\r\n\t\t{\r\n\t\t\tOFFSET 5 0 0\r\n\t\t\tCHANNELS 4 Xposition Yposition Zposition Xrotation\r\n"
    "\t\t\tEnd Site\r\n\t\t\t{\r\n\t\t\t\tOFFSET +2 0 0\r\n\t\t\t}\r\n\t\t}\r\n\t}\r\n}\r\n"
    "MOTION\r\nFrames:\t2\r\nFrame Time: 8.3333e-3\r\n"
    "0 0 0 0 0 0 0 0 0 5 0 0 0\r\n"
    "30 20 10  90 0 0\t0 90 0  7 0 0 90";

std::string refusal(std::string_view text) {
  try {
    (void)parse_bvh(text, "walk.bvh");
  } catch (const CorruptData& error) {
    return error.what();
  }
  return "taken";
}

std::string with(std::string_view text, std::string_view what, std::string_view instead) {
  std::string changed(text);
  const auto at = changed.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return changed.replace(at, what.size(), instead);
}

TEST(Bvh, ReadsWhatFilesInTheWildDo) {
  const auto motion = parse_bvh(kArm);
  ASSERT_EQ(motion.joints.size(), 4U);
  EXPECT_EQ(motion.joints[0].name, "mixamorig:Hips");
  EXPECT_EQ(motion.joints[1].name, "Upper Arm");
  EXPECT_TRUE(motion.joints[3].is_end_site);
  EXPECT_EQ(motion.joints[3].parent, 2);
  EXPECT_EQ(motion.channels(), 13U);
  EXPECT_DOUBLE_EQ(motion.frame_time, 0.0083333);
  const auto rest = zero_pose(motion);
  EXPECT_TRUE(rest[3].translation().isApprox(Vector3d(8, 12, 3), 1e-12));
}

// By hand: the root stands at (10, 20, 30) and turns x to y; the arm's joint lies 10 along its y, that is at (0, 20,
// 30), and turns y about z once more: its x now points to -x of the world. The hand's position channels say 7, its end
// lies 2 further, its own turn about x does not move it.
TEST(Bvh, PlacesJointsByTheirChannelsInTheirOrder) {
  const auto at = joint_transforms(parse_bvh(kArm), 1);
  EXPECT_TRUE(at[0].translation().isApprox(Vector3d(10, 20, 30), 1e-9));
  EXPECT_TRUE(at[1].translation().isApprox(Vector3d(0, 20, 30), 1e-9));
  EXPECT_TRUE(at[2].translation().isApprox(Vector3d(-7, 20, 30), 1e-9)) << at[2].translation().transpose();
  EXPECT_TRUE(at[3].translation().isApprox(Vector3d(-9, 20, 30), 1e-9)) << at[3].translation().transpose();
  EXPECT_TRUE((at[2].linear() * Vector3d::UnitY()).isApprox(Vector3d(0, 0, 1), 1e-9));
}

TEST(Bvh, WritesWhatItReads) {
  const auto motion = parse_bvh(kArm);
  const auto again = parse_bvh(bvh_text(motion));
  ASSERT_EQ(again.joints.size(), motion.joints.size());
  for (std::size_t j = 0; j < motion.joints.size(); ++j) {
    EXPECT_EQ(again.joints[j].name, motion.joints[j].name);
    EXPECT_EQ(again.joints[j].parent, motion.joints[j].parent);
    EXPECT_EQ(again.joints[j].offset, motion.joints[j].offset);
    EXPECT_EQ(again.joints[j].channels, motion.joints[j].channels);
  }
  EXPECT_EQ(again.values, motion.values);
  EXPECT_NEAR(again.frame_time, motion.frame_time, 1e-9);
}

TEST(Bvh, RefusesBadFilesWithTheLine) {
  EXPECT_THAT(refusal(with(kArm, "Hand", "")), HasSubstr("walk.bvh:9: a joint without a name"));
  EXPECT_THAT(refusal(with(kArm, "5 0 0\r\n\t\t\tCH", "5 x 0\r\n\t\t\tCH")), HasSubstr(":11: expected a number"));
  EXPECT_THAT(refusal(with(kArm, "1e1", "1e300")), HasSubstr("is no sensible offset"));
  EXPECT_THAT(refusal(with(kArm, "1e1", "nan")), HasSubstr("is no sensible offset"));
  EXPECT_THAT(refusal(with(kArm, "CHANNELS 4", "CHANNELS 40")), HasSubstr("a number of channels (0 to 6)"));
  EXPECT_THAT(refusal(with(kArm, "yrotation", "wrotation")), HasSubstr("no channel 'wrotation'"));
  EXPECT_THAT(refusal(with(kArm, "OFFSET +2 0 0", "")), HasSubstr("an End Site has no OFFSET"));
  EXPECT_THAT(refusal(with(kArm, "Frames:\t2", "Frames: 3")), HasSubstr("the file is cut"));
  EXPECT_THAT(refusal(with(kArm, "Frames:\t2", "Frames: 3") + std::string(40, ' ')),
              HasSubstr("the file ends after 2 of 3 frames"));
  EXPECT_THAT(refusal(with(kArm, "Frames:\t2", "Frames: 1")), HasSubstr("'30' follows the 1 frames announced"));
  EXPECT_THAT(refusal(with(kArm, "Frames:\t2", "Frames: 90000000")), HasSubstr("do not fit"));
  EXPECT_THAT(refusal(with(kArm, "Frames:\t2", "Frames: 0")), HasSubstr("no frame"));
  EXPECT_THAT(refusal(with(kArm, "8.3333e-3", "0")), HasSubstr("a frame time of 0 s"));
  EXPECT_THAT(refusal(with(kArm, "0 5 0 0 0\r\n", "0 5 0 0\r\n")),
              HasSubstr(":23: frame 0 has 12 numbers instead of 13"));
  EXPECT_THAT(refusal(with(kArm, "0 5 0 0 0\r\n", "0 5 0 0 0 1\r\n")), HasSubstr("goes on with '1'"));
  EXPECT_THAT(refusal(with(kArm, "ROOT", "JOINT")), HasSubstr("expected 'ROOT' or 'MOTION'"));
  std::string deep = "HIERARCHY\nROOT a\n{ OFFSET 0 0 0\n";
  for (int i = 0; i < 5000; ++i) deep += "JOINT b { OFFSET 0 0 0\n";
  EXPECT_THAT(refusal(deep), HasSubstr("nest deeper than 512"));
}

// Cut anywhere before the last number it is told; flipped bytes may give other numbers but nothing worse.
TEST(Bvh, RefusesEveryTruncationAndSurvivesFlippedBytes) {
  for (std::size_t size = 0; size + 2 < kArm.size(); ++size)
    EXPECT_THAT(refusal(kArm.substr(0, size)), HasSubstr("walk.bvh:")) << size;
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    std::string text(kArm);
    for (int flips = 0; flips < 2; ++flips) text[random() % text.size()] ^= static_cast<char>(1U << (random() % 8));
    (void)refusal(text);
  }
}

}  // namespace
}  // namespace rotunda::recon
