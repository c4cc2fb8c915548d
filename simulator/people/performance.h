#pragma once
// What the studio shows: surfaces that move, and what is true of them. World: metres, z up, floor z = 0.
#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/frame.h"
#include "recon/mesh/triangle_mesh.h"
#include "simulator/people/act.h"
#include "simulator/people/surface_material.h"
#include "simulator/people/surface_texture.h"

namespace rotunda::simulator {

// A surface that keeps its vertices while it moves.
struct Figure {
  recon::TriangleMesh bind;     // our people's is closed; colours at the vertices
  std::vector<float> openness;  // one a vertex: 1 open to all light, 0 buried
  SurfaceTexture texture;
  std::vector<SurfaceMaterial> material = {};  // one a vertex; none: cloth all over
};

struct JointInfo {
  std::string name;
  int parent = -1;  // an earlier joint; -1: the root
};

struct JointState {
  Eigen::Vector3d position;     // of its centre, world, metres
  Eigen::Quaterniond rotation;  // of its frame in its parent's, from the bind pose; the root's in world
};

// Somebody doing something, again and again every frames() act frames. All functions may be called from any thread.
class Performance {
 public:
  virtual ~Performance() = default;
  virtual const std::string& person() const = 0;  // as asked for
  virtual const std::string& act() const = 0;
  virtual int frames() const = 0;      // of kActStep; then it starts again
  virtual bool is_cyclic() const = 0;  // it repeats without a jump

  virtual const std::vector<Figure>& figures() const = 0;  // the performer first, then what they carry
  // One a figure, with its bind mesh's triangles and colours. Seconds from the act's start: any time, between act
  // frames too; the act repeats.
  virtual std::vector<recon::TriangleMesh> surfaces_at(double seconds) const = 0;

  virtual const std::vector<JointInfo>& joints() const = 0;
  virtual std::vector<JointState> joints_at(double seconds) const = 0;
  virtual std::vector<HeelStrike> heel_strikes() const = 0;  // of one round
  // world_from_board, if a calibration board is there (board_prop.h).
  virtual std::optional<Eigen::Isometry3d> board_at(double /*seconds*/) const { return std::nullopt; }

  // Another one for every difference in surfaces, textures or motion: part of the key of what was rendered ahead.
  virtual std::string fingerprint() const = 0;
};

struct PerformanceOptions {
  std::string person = "alex";                  // one of person_names(), or FILE.glb, FILE.gltf
  std::string act = "walk";                     // one of act_names(), or a clip of that file
  std::optional<std::filesystem::path> motion;  // a BVH file that one of our people follows instead of an act
  bool travel = false;                          // through the volume instead of on the spot
  std::uint32_t seed = 1;                       // of the motion's small variations
  double coarseness = 1.0;                      // of our people's surfaces
  std::optional<int> texels_per_edge;           // of our people's textures
};

// Throws InvalidInput for a person, act or clip that is not there, with those that are; what gltf_performance.h,
// bvh.h and bvh_motion.h say for files.
std::unique_ptr<Performance> make_performance(const PerformanceOptions& options = {});

// One of our people, already made: `options` then says nothing of who it is.
struct Person;
std::unique_ptr<Performance> make_performance(Person person, const PerformanceOptions& options);

// What of the figures shows: for implementations of fingerprint().
class Fingerprint;
void add_to(Fingerprint& print, const std::vector<Figure>& figures);

// Which frame of the act an exposure that starts then shows, round(t / 40 ms) modulo the act's frames: for all cameras
// alike, on the rig's clock.
int act_frame_at(capture::Timestamp exposure_start, int frames);
inline double act_seconds(int frame) {
  return frame * kActStep;
}

}  // namespace rotunda::simulator
