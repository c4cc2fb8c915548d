// What animating a scan costs and how true it stays: people of 15, 50, 264 and 294 thousand triangles under a simulated
// act. Beside it, in the same run, the solves alone by Eigen's SimplicialLDLT and by CHOLMOD (simplicial, METIS), 4
// right-hand sides for the quaternion fields and 3 for the coordinates, as the paper's method needs them; and the
// paper's own quality.
#include <fmt/format.h>
#include <suitesparse/cholmod.h>
#include <tbb/global_control.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <numbers>

#include "playback/marker_preview.h"
#include "playback/surface_pick.h"
#include "recon/deform/cotangent_weights.h"
#include "recon/deform/scan_animation.h"
#include "simulator/people/person.h"
#include "simulator/scan/scan.h"
#include "tests/support/act_bvh.h"

namespace rotunda {
namespace {

using Eigen::Vector3f;

double wall() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
double cpu() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Cost {
  double wall_ms, cpu_ms;
};
// The median of some runs.
template <class Work>
Cost cost_of(int runs, const Work& work) {
  std::vector<double> walls, cpus;
  for (int i = 0; i < runs; ++i) {
    const double w = wall(), c = cpu();
    work();
    walls.push_back(1e3 * (wall() - w));
    cpus.push_back(1e3 * (cpu() - c));
  }
  std::sort(walls.begin(), walls.end());
  std::sort(cpus.begin(), cpus.end());
  return {walls[walls.size() / 2], cpus[cpus.size() / 2]};
}

// One vertex held, the rest free.
Eigen::SparseMatrix<double> pinned_laplacian(const recon::TriangleMesh& mesh) {
  std::vector<int> row(mesh.positions.size());
  for (std::size_t v = 0; v < row.size(); ++v) row[v] = static_cast<int>(v) - 1;
  return recon::laplacian(mesh, recon::cotangent_weights(mesh), row, static_cast<int>(row.size()) - 1);
}

void baseline_eigen(const Eigen::SparseMatrix<double>& lower) {
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(lower);
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(lower.rows(), 7);
  Eigen::MatrixXd x;
  const auto cost = cost_of(3, [&] { x = solver.solve(b); });
  fmt::print("  {:<38} {:>9.2f} {:>9.2f} {:>8.0f}\n", "baseline: Eigen SimplicialLDLT, solves", cost.wall_ms,
             cost.cpu_ms, 1e3 / cost.wall_ms);
}

void baseline_cholmod(Eigen::SparseMatrix<double> lower) {
  cholmod_common common;
  cholmod_start(&common);
  common.supernodal = CHOLMOD_SIMPLICIAL;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_METIS;
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(lower.rows());
  view.nzmax = static_cast<std::size_t>(lower.nonZeros());
  view.p = lower.outerIndexPtr();
  view.i = lower.innerIndexPtr();
  view.x = lower.valuePtr();
  view.stype = -1;
  view.xtype = CHOLMOD_REAL;
  view.sorted = view.packed = 1;
  auto* factor = cholmod_analyze(&view, &common);
  cholmod_factorize(&view, factor, &common);
  auto* four = cholmod_ones(view.nrow, 4, CHOLMOD_REAL, &common);
  auto* three = cholmod_ones(view.nrow, 3, CHOLMOD_REAL, &common);
  const auto cost = cost_of(3, [&] {
    for (auto* b : {four, three}) {
      auto* x = cholmod_solve(CHOLMOD_A, factor, b, &common);
      cholmod_free_dense(&x, &common);
    }
  });
  fmt::print("  {:<38} {:>9.2f} {:>9.2f} {:>8.0f}\n", "baseline: CHOLMOD simplicial, solves", cost.wall_ms, cost.cpu_ms,
             1e3 / cost.wall_ms);
  cholmod_free_dense(&four, &common);
  cholmod_free_dense(&three, &common);
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
}

void speed(recon::ScanAnimation& animation, const std::vector<recon::HandlePose>& poses, double bind_s) {
  const std::size_t frames = poses.size() / recon::kBodySegments;
  std::vector<Vector3f> positions(frames * animation.rest().positions.size());
  animation.deform(poses, positions);  // memory is there
  const auto before = animation.clock();
  constexpr int kRuns = 3;
  const auto cost = cost_of(kRuns, [&] { animation.deform(poses, positions); });
  const auto after = animation.clock();
  const auto n = static_cast<double>(frames);
  fmt::print("  {:<38} {:>9.2f} {:>9.2f} {:>8.0f}\n", "a sequence, all stages, a frame", cost.wall_ms / n,
             cost.cpu_ms / n, 1e3 * n / cost.wall_ms);
  const auto stage = [&](const char* name, double from, double to) {
    fmt::print("    {:<36} {:>9} {:>9.2f}\n", name, "", 1e3 * (to - from) / n / kRuns);
  };
  stage("rotations and right-hand side", before.rotate_s, after.rotate_s);
  stage("solve", before.solve_s, after.solve_s);
  stage("volume", before.volume_s, after.volume_s);
  stage("vertices out", before.store_s, after.store_s);
  const std::span<const recon::HandlePose> one(poses.data(), recon::kBodySegments);
  std::vector<Vector3f> frame(animation.rest().positions.size());
  const auto alone = cost_of(9, [&] { animation.deform(one, frame); });
  fmt::print("  {:<38} {:>9.2f} {:>9.2f} {:>8.0f}\n", "one frame alone", alone.wall_ms, alone.cpu_ms,
             1e3 / alone.wall_ms);
  fmt::print("  {:<38} {:>9.0f}\n", "bind", 1e3 * bind_s);
}

// The editor of markers: a click on the scan, a frame of the motion as the window is given it, and with new markers.
void editing(const recon::PreparedScan& scan, const recon::Markers& markers, const recon::BodyMotion& motion) {
  const auto tell = [](const char* what, const Cost& cost) {
    fmt::print("  {:<38} {:>9.2f} {:>9.2f}\n", what, cost.wall_ms, cost.cpu_ms);
  };
  const auto eye = playback::Orbit{}.viewpoint(720, 810);
  tell("editor: pick", cost_of(9, [&] { playback::pick(scan.mesh, eye, {360.0, 405.0}); }));
  playback::MarkerPreview preview(scan, *markers.fit, motion);
  long revision = 0;
  int frame = 0;
  tell("editor: new markers, bound and seen", cost_of(3, [&] {
         preview.wait_for({++revision, frame, false}, markers);
       }));
  tell("editor: another frame", cost_of(9, [&] { preview.wait_for({revision, ++frame, false}, markers); }));
  tell("editor: another frame, residuals", cost_of(5, [&] { preview.wait_for({revision, ++frame, true}, markers); }));
}

// The standing scan with one joint turned by a right angle.
std::vector<recon::HandlePose> turned(const recon::ScanAnimation& animation, recon::BodyJoint joint,
                                      const Eigen::Vector3d& axis) {
  recon::BodyMotion motion{.poses = {animation.fit().pose}, .leg_length = animation.fit().body.skeleton.leg_length()};
  auto& rotation = motion.poses[0].rotation[index(joint)];
  rotation = rotation * Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::numbers::pi, axis));
  return animation.handle_poses(motion);
}

void quality(const char* method, recon::ScanAnimation& animation) {
  using recon::BodyJoint;
  const double rest = recon::signed_volume(animation.rest());
  const struct {
    const char* name;
    BodyJoint joint;
    Eigen::Vector3d axis;
  } kBends[] = {{"elbow bent 90", BodyJoint::forearm_left, -Eigen::Vector3d::UnitZ()},
                {"knee bent 90", BodyJoint::shank_left, Eigen::Vector3d::UnitY()},
                {"hip bent 90", BodyJoint::thigh_left, -Eigen::Vector3d::UnitY()},
                {"waist bent 90", BodyJoint::spine, Eigen::Vector3d::UnitY()},
                {"waist twisted 90", BodyJoint::spine, Eigen::Vector3d::UnitZ()},
                {"head twisted 90", BodyJoint::neck, Eigen::Vector3d::UnitZ()}};
  for (const auto& bend : kBends) {
    const auto poses = turned(animation, bend.joint, bend.axis);
    recon::TriangleMesh posed = animation.rest();
    animation.deform(poses, posed.positions);
    fmt::print("  {:<8} {:<18} volume {:+6.2f} %  drift {:7.2f} mm\n", method, bend.name,
               100.0 * (recon::signed_volume(posed) / rest - 1.0), 1e3 * animation.drift(poses, posed.positions));
  }
}

void run(const char* name, std::size_t triangles, const char* act) {
  const auto person = simulator::make_person(name);
  const auto scan = simulator::scan_of(person.bind, person.texture, {.triangles = triangles, .flaws = {}, .seed = 1});
  const auto motion = recon::import_bvh(
      tests::act_bvh(person.skeleton, simulator::motion_of(act, person.skeleton, {.travel = false, .seed = 1})));
  double start = wall();
  auto prepared = recon::prepare_scan(scan);
  const auto fit = recon::fit_template(prepared.mesh);
  const auto markers = recon::propose_markers(prepared.mesh, prepared.from_triangle, fit);
  fmt::print("{} of {} triangles, {} of {} frames, {} markers (found in {:.1f} s)\n", name,
             prepared.mesh.triangles.size(), act, motion.poses.size(), markers.pairs.size(), wall() - start);
  fmt::print("  {:<38} {:>9} {:>9} {:>8}\n", "", "wall ms", "CPU ms", "fps");
  baseline_eigen(pinned_laplacian(prepared.mesh));
  baseline_cholmod(pinned_laplacian(prepared.mesh));
  start = wall();
  recon::ScanAnimation animation(prepared, markers);
  const double bind_s = wall() - start;
  auto poses = animation.handle_poses(motion);
  poses.resize(std::min<std::size_t>(poses.size(), 64 * recon::kBodySegments));
  speed(animation, poses, bind_s);
  editing(prepared, markers, motion);
  quality("ours", animation);
  recon::ScanAnimation paper(std::move(prepared), markers, {.as_paper = true});
  quality("paper", paper);
}

}  // namespace
}  // namespace rotunda

// deform_bench [THREADS]
int main(int argc, char** argv) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    argc > 1 ? static_cast<std::size_t>(std::atoi(argv[1])) : 2);
  for (const std::size_t triangles : {15'000, 50'000, 264'000}) rotunda::run("anna", triangles, "capoeira");
  rotunda::run("alex", 294'000, "dance");
}
