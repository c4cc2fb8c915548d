#pragma once
// The body template as one closed surface: its sixteen segments united and rounded where they meet, in a pose in which
// nothing touches anything else. Shape and topology that no frame's own hull has to be trusted for. Metres.
#include "recon/body/body_template.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// Standing at the origin with legs and arms held off the body (an A-pose).
Pose free_pose();

// Genus 0, with normals, triangles with edges of about `cell` (metres). Throws InvalidInput if the template's segments
// do not make one body: measures that no person has.
TriangleMesh body_surface(const BodyTemplate& body, const Pose& pose, double cell = 0.012);

}  // namespace rotunda::recon
