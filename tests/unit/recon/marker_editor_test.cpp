#include "recon/deform/marker_editor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "config/errors.h"
#include "recon/deform/marker_keeper.h"
#include "recon/deform/surface_distance.h"
#include "tests/support/template_person.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::HasSubstr;

std::uint32_t triangles_of_segment() {
  return static_cast<std::uint32_t>(segment_triangles().size());
}

// The scan is the template as the person stands, one arm lifted higher than the other: triangle for triangle, in a file
// that counts them from 1000 and leaves every other number out.
class AnEditorOfMarkers : public testing::Test {
 protected:
  AnEditorOfMarkers() {
    auto one = tests::someone();
    one.pose.rotation[index(BodyJoint::upper_arm_left)] = Eigen::AngleAxisd(20.0 * tests::kDegree, Vector3d::UnitX()) *
                                                          one.pose.rotation[index(BodyJoint::upper_arm_left)];
    fit_ = {.body = one.body, .pose = one.pose};
    scan_.mesh = tests::scan_of(one);
    for (std::uint32_t t = 0; t < scan_.mesh.triangles.size(); ++t) scan_.from_triangle.push_back(1000 + 2 * t);
  }
  Markers markers(std::vector<Marker> pairs) const { return {.pairs = std::move(pairs), .fit = fit_}; }
  static std::uint32_t in_file(std::uint32_t triangle) { return 1000 + 2 * triangle; }
  // A triangle on the middle ring of a segment, at its side.
  static std::uint32_t on(std::size_t segment, std::uint32_t which = 50) {
    return static_cast<std::uint32_t>(segment) * triangles_of_segment() + which;
  }
  // A triangle's middle from the joint of a segment.
  Vector3d seen_from(std::size_t segment, std::uint32_t triangle) const {
    const Vector3d middle = middle_of(scan_.mesh, triangle).cast<double>();
    return joint_transforms(fit_.body.skeleton, fit_.pose)[index(joint_of_segment(segment))].inverse() * middle;
  }

  static constexpr std::size_t kForearmLeft = 5, kForearmRight = 8, kPelvis = 0;
  PreparedScan scan_;
  TemplateFit fit_;
};

TEST_F(AnEditorOfMarkers, MirrorsPlacesWhereverTheArmsAre) {
  const BodyMirror mirror(scan_.mesh, fit_);
  EXPECT_EQ(mirrored_segment(kForearmLeft), kForearmRight);
  EXPECT_EQ(mirrored_segment(kPelvis), kPelvis);
  for (const std::size_t segment : {kForearmLeft, std::size_t{11}, std::size_t{2}})
    for (std::uint32_t t = 20; t < triangles_of_segment() - 20; t += 7) {
      const auto from = on(segment, t), to = mirror.on_template(from);
      const auto other = mirrored_segment(segment);
      ASSERT_EQ(segment_of_triangle(to), other);
      // Triangles of the two sides are cut by the other diagonal: their middles are a third of an edge apart at most.
      constexpr double kCoarse = 0.034;
      const Vector3d wanted = seen_from(segment, from).cwiseProduct(Vector3d(1, -1, 1));
      EXPECT_LT((wanted - seen_from(other, to)).norm(), kCoarse) << segment << " " << t;
      const auto place = mirror.on_scan(from, segment);
      ASSERT_TRUE(place);
      EXPECT_LT((wanted - seen_from(other, *place)).norm(), kCoarse) << segment << " " << t;
    }
}

TEST_F(AnEditorOfMarkers, MakesMovesAndTakesAwayOnBothSides) {
  MarkerEditor editor(scan_, markers({{7, on(kPelvis), in_file(on(kPelvis))}}));
  const auto made = editor.add(on(kForearmLeft), on(kForearmLeft));
  EXPECT_TRUE(made.done);
  EXPECT_THAT(made.told, AllOf(HasSubstr("8 on forearm_left"), HasSubstr("9 on forearm_right")));
  const auto& pairs = editor.markers().pairs;
  ASSERT_EQ(pairs.size(), 3U);
  EXPECT_EQ(pairs[1].scan_triangle, in_file(on(kForearmLeft)));
  EXPECT_EQ(editor.on_prepared(pairs[1]), on(kForearmLeft));
  EXPECT_EQ(segment_of_triangle(pairs[2].template_triangle), kForearmRight);
  EXPECT_EQ(segment_of_triangle(editor.on_prepared(pairs[2])), kForearmRight);

  editor.select(9);
  ASSERT_NE(editor.mirror_of_selected(), nullptr);
  EXPECT_EQ(editor.mirror_of_selected()->number, 8);
  const auto before = pairs[1];
  EXPECT_TRUE(editor.move_on_scan(on(kForearmRight, 90)).done);
  EXPECT_EQ(pairs[2].scan_triangle, in_file(on(kForearmRight, 90)));
  EXPECT_NE(pairs[1].scan_triangle, before.scan_triangle);  // the other side goes along
  EXPECT_TRUE(editor.move_on_template(on(kForearmRight, 90)).done);
  EXPECT_EQ(pairs[2].template_triangle, on(kForearmRight, 90));
  EXPECT_NE(pairs[1].template_triangle, before.template_triangle);
  EXPECT_TRUE(editor.remove().done);
  EXPECT_EQ(pairs.size(), 1U);
  EXPECT_EQ(editor.selected(), nullptr);
}

TEST_F(AnEditorOfMarkers, LeavesTheOtherSideAloneWhenAsked) {
  MarkerEditor editor(scan_, markers({{1, on(kPelvis), in_file(on(kPelvis))}}));
  editor.set_symmetric(false);
  editor.add(on(kForearmLeft), on(kForearmLeft));
  EXPECT_EQ(editor.markers().pairs.size(), 2U);
  editor.add(on(kForearmRight), on(kForearmRight));
  editor.select(2);
  EXPECT_EQ(editor.mirror_of_selected(), nullptr);
  editor.remove();
  EXPECT_EQ(editor.markers().pairs.size(), 2U);
}

TEST_F(AnEditorOfMarkers, UndoesEveryStepAndDoesItAgain) {
  const std::vector<Marker> first{{1, on(kPelvis), in_file(on(kPelvis))}};
  MarkerEditor editor(scan_, markers(first));
  EXPECT_FALSE(editor.undo().done);
  std::vector<std::vector<Marker>> steps{first};
  constexpr int kSteps = 60;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    EXPECT_TRUE(editor.add(on(kForearmLeft, 30 + i), on(kForearmLeft, 30 + i)).done);
    steps.push_back(editor.markers().pairs);
  }
  EXPECT_TRUE(editor.changed());
  for (int i = kSteps - 1; i >= 0; --i) {
    EXPECT_TRUE(editor.undo().done);
    EXPECT_EQ(editor.markers().pairs, steps[static_cast<std::size_t>(i)]);
  }
  EXPECT_FALSE(editor.changed());  // back where it was saved
  for (int i = 1; i <= 5; ++i) EXPECT_TRUE(editor.redo().done);
  EXPECT_EQ(editor.markers().pairs, steps[5]);
  editor.add(on(kForearmLeft, 99), on(kForearmLeft, 99));
  EXPECT_FALSE(editor.redo().done);  // another way was taken
}

TEST_F(AnEditorOfMarkers, RefusesWhatTheFileWouldAndSaysWhy) {
  MarkerEditor editor(scan_, markers({{1, on(kPelvis), in_file(on(kPelvis))}}));
  const auto before = editor.markers().pairs;
  const auto taken = editor.add(on(1), on(kPelvis));  // the belly's, where the pelvis has it
  EXPECT_FALSE(taken.done);
  EXPECT_THAT(taken.told, AllOf(HasSubstr("marker 2 on spine"), HasSubstr("the pelvis has it already")));
  const auto far = editor.add(on(kForearmLeft), on(kForearmRight));
  EXPECT_FALSE(far.done);
  EXPECT_THAT(far.told, HasSubstr("left for right"));
  editor.select(1);
  EXPECT_THAT(editor.remove().told, HasSubstr("one marker at least"));
  EXPECT_FALSE(editor.move_on_scan(on(kForearmLeft)).done);
  editor.select(std::nullopt);
  EXPECT_FALSE(editor.move_on_scan(on(kPelvis, 3)).done);
  EXPECT_EQ(editor.markers().pairs, before);
  EXPECT_FALSE(editor.changed());
  EXPECT_THROW(MarkerEditor(scan_, markers({{1, on(kPelvis), 1001}})), InvalidInput);  // odd: left out of the scan
}

TEST_F(AnEditorOfMarkers, MovesOneSideAloneWhereTheOtherIsTaken) {
  const BodyMirror mirror(scan_.mesh, fit_);
  const auto mirrored = *mirror.on_scan(on(kForearmLeft, 90), kForearmLeft);
  MarkerEditor editor(scan_, markers({{1, on(kPelvis), in_file(on(kPelvis))}, {2, on(9), in_file(mirrored)}}));
  const auto made = editor.add(on(kForearmLeft, 90), on(kForearmLeft, 90));
  EXPECT_TRUE(made.done);
  EXPECT_THAT(made.told, AllOf(HasSubstr("alone"), HasSubstr("hand_right has it already")));
  EXPECT_EQ(editor.markers().pairs.size(), 3U);
}

TEST_F(AnEditorOfMarkers, GoesThroughThePairsRoundAndRound) {
  MarkerEditor editor(scan_, markers({{4, on(0), in_file(on(0))}, {9, on(1), in_file(on(1))}}));
  EXPECT_EQ(editor.selected(), nullptr);
  std::vector<int> seen;
  for (int i = 0; i < 3; ++i) {
    editor.select_next(1);
    seen.push_back(editor.selected()->number);
  }
  editor.select_next(-1);
  seen.push_back(editor.selected()->number);
  EXPECT_THAT(seen, testing::ElementsAre(4, 9, 4, 9));
}

TEST_F(AnEditorOfMarkers, BeginsWithoutAnyPair) {
  MarkerEditor editor(scan_, markers({}));
  editor.select_next(1);
  EXPECT_EQ(editor.selected(), nullptr);
  EXPECT_TRUE(editor.add(on(0), on(0)).done);
  editor.select_next(-1);
  EXPECT_NE(editor.selected(), nullptr);
}

TEST_F(AnEditorOfMarkers, LosesNothingThatIsNotSaved) {
  const fs::path folder = fs::temp_directory_path() / ("rotunda_markers_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const fs::path file = folder / "markers.yaml";
  MarkerEditor editor(scan_, markers({{1, on(kPelvis), in_file(on(kPelvis))}}));
  MarkerKeeper keeper(file, "a \"quoted\" scan.ply");
  keeper.keep(editor);
  EXPECT_FALSE(fs::exists(keeper.unsaved()));
  editor.add(on(kForearmLeft), on(kForearmLeft));
  keeper.keep(editor);
  EXPECT_FALSE(fs::exists(file));
  ASSERT_TRUE(MarkerKeeper(file, "").left());
  EXPECT_EQ(MarkerKeeper(file, "").left()->pairs, editor.markers().pairs);
  keeper.save(editor);
  EXPECT_FALSE(editor.changed());
  EXPECT_FALSE(fs::exists(keeper.unsaved()));
  EXPECT_EQ(read_markers(file).pairs, editor.markers().pairs);
  editor.undo();
  keeper.keep(editor);
  EXPECT_TRUE(fs::exists(keeper.unsaved()));  // what is saved is not what is seen
  editor.redo();
  keeper.keep(editor);
  EXPECT_FALSE(fs::exists(keeper.unsaved()));
  fs::remove_all(folder);
  editor.undo();
  EXPECT_THROW(keeper.keep(editor), std::system_error);
  EXPECT_NO_THROW(keeper.keep(editor));  // told once
}

TEST(SurfaceDistances, AreThoseOfShiftedSurfacesAndEndAtTheirReach) {
  auto one = tests::someone();
  const auto mesh = tests::scan_of(one);
  for (const float distance : surface_distances(mesh, mesh, 0.1)) EXPECT_LT(distance, 1e-6F);
  auto shifted = mesh;
  for (auto& p : shifted.positions) p.x() += 3.0F;
  for (const float distance : surface_distances(mesh, shifted, 0.1)) EXPECT_EQ(distance, 0.1F);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    shifted.positions[v] = mesh.positions[v] + 0.004F * mesh.normals[v];
  auto distances = surface_distances(shifted, mesh, 0.1);
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2),
                   distances.end());
  EXPECT_NEAR(distances[distances.size() / 2], 0.004F, 0.0005F);  // normals of vertices lean between triangles
}

}  // namespace
}  // namespace rotunda::recon
