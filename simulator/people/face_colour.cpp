// Places are those of body_head.cpp.
#include "simulator/people/paint.h"
#include "simulator/people/skin_colour.h"
#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

using namespace paint;
using Eigen::Vector3d;

struct FacePoint {
  const BodyBuild& build;
  const Clothing& look;
  Vector3d q;
  double side;  // from the middle of the face, towards either ear
  bool is_male() const { return build.sex == Sex::male; }
  double grain(double size, std::uint32_t channel) const { return solid_noise(q / size, build.seed + channel); }
};

// Warmer where blood shows, darker in the hollows of the eyes.
Vector3d complexion(const FacePoint& f, Vector3d colour) {
  const Vector3d warm(1.0, 0.80, 0.78), deep(0.80, 0.72, 0.74);
  const double cheek = disc(f.side - 0.045, (f.q.z() - 1.602) * 1.2, 0.006, 0.034);
  const double nose = disc(f.q.y(), f.q.z() - 1.602, 0.007, 0.014) * step_up(f.q.x() - 0.090, 0.01);
  colour = mix(colour, colour.cwiseProduct(warm), f.look.blush * (0.40 * cheek + 0.28 * nose));
  const double socket = disc((f.side - 0.0300) * 0.75, f.q.z() - 1.6330, 0.0065, 0.0080);
  colour = mix(colour, colour.cwiseProduct(deep), 0.50 * socket);
  const double inner = disc(f.side - 0.0170, f.q.z() - 1.6385, 0.003, 0.008);
  colour = mix(colour, colour.cwiseProduct(deep), 0.45 * inner);
  const double wing = band(std::hypot(f.side - 0.0100, (f.q.z() - 1.5965) * 1.05) - 0.0098, 0.0006, 0.0022);
  colour = mix(colour, colour * 0.62, 0.55 * wing * step_up(f.side - 0.0120, 0.004));
  const double fold = f.side - 0.0210 - 0.55 * (1.5950 - f.q.z());  // from the nose to the corner of the mouth
  return mix(colour, colour * 0.80, 0.40 * band(fold, 0.0010, 0.0045) * band(f.q.z() - 1.584, 0.008, 0.008));
}

Vector3d stubble(const FacePoint& f, Vector3d colour) {
  if (!f.is_male() || f.look.stubble <= 0.0) return colour;
  const double jaw = step_up(1.5800 - f.q.z() + 0.55 * std::max(0.0, f.side - 0.035), 0.010);
  const double upper_lip = band(f.q.z() - 1.5765, 0.004, 0.003) * step_up(0.030 - f.side, 0.006);
  const double cover = std::max(jaw, upper_lip) * step_up(f.q.z() - 1.505, 0.02);
  const double hairs = 0.55 + 0.9 * f.grain(0.0016, 41);
  return mix(colour, mix(rgb(f.look.hair), Vector3d(0.32, 0.32, 0.36), 0.5), cover * f.look.stubble * hairs);
}

Vector3d lips(const FacePoint& f, Vector3d colour) {
  const double half = 0.0250, u = f.side / half;
  if (u > 1.25 || f.q.x() < 0.07) return colour;
  const double taper = std::max(0.0, 1.0 - u * u), full = f.build.face.lips * (f.is_male() ? 0.86 : 1.08);
  const double line = 1.5638 + 1.2 * f.side * f.side - 0.0006 * std::cos(f.side * 420.0) * taper;
  const double bow = 0.80 + 0.20 * band(f.side - 0.0062, 0.0015, 0.0050);
  const double above = f.q.z() - line;
  const double height = above > 0 ? 0.0074 * full * bow * std::pow(taper, 0.75) : 0.0092 * full * std::sqrt(taper);
  const double within = step_up(height - std::abs(above), 0.0016) * (u < 1.0 ? 1.0 : 0.0);
  Vector3d lip = rgb(f.look.lips) * (above > 0 ? 0.88 : 1.0);
  lip *= 1.0 + 0.10 * solid_noise(Vector3d(f.q.y() / 0.0011, f.q.z() / 0.006, 0.0), f.build.seed + 43);
  lip = mix(lip, lip * 1.16, above < 0 ? band(above + 0.45 * height, 0.001, 0.003) : 0.0);
  colour = mix(colour, lip, (f.is_male() ? 0.72 : 0.92) * within);
  const double shade = band(f.q.z() - 1.5520, 0.0012, 0.0040) * band(f.side, 0.010, 0.008);  // under the lower lip
  colour = mix(colour, colour * 0.76, 0.6 * shade);
  const double seam = band(above, 0.0007 + 0.0006 * taper, 0.0010) * step_up(1.06 - u, 0.08);
  return mix(colour, Vector3d(0.22, 0.09, 0.09), 0.85 * seam);
}

Vector3d nostrils(const FacePoint& f, const Vector3d& colour) {
  const double wide = f.build.face.nose_width * (f.is_male() ? 1.0 : 0.90);
  const double hole = disc((f.side - 0.0070 * wide) * 1.25, (f.q.z() - 1.5893) * 1.5, 0.0026, 0.0022);
  const double under = step_up(1.5925 - f.q.z(), 0.003) * band(f.side, 0.012, 0.004) * step_up(f.q.z() - 1.583, 0.004);
  return mix(mix(colour, colour * 0.72, 0.55 * under), Vector3d(0.16, 0.07, 0.06), 0.85 * hole);
}

Vector3d brows(const FacePoint& f, const Vector3d& colour) {
  const double t = (f.side - 0.0125) / 0.0405;
  if (t < -0.1 || t > 1.1) return colour;
  const double arch = f.is_male() ? 0.0030 : 0.0048;
  const double middle = 1.6525 + arch * std::sin(3.1416 * std::pow(std::clamp(t, 0.0, 1.0), 1.25)) - 0.0010 * t;
  const double thick = (f.is_male() ? 0.0036 : 0.0022) * f.build.face.brow * (1.0 - 0.70 * std::max(0.0, t - 0.15));
  const Vector3d stroke(f.q.y() / 0.0028 + f.q.z() / 0.0016, f.q.z() / 0.0050, 0.0);
  const double hairs = 0.72 + 0.75 * solid_noise(stroke, f.build.seed + 42);
  const double edge = band(f.q.z() - middle, 0.55 * thick, 0.0024) * band(t - 0.5, 0.46, 0.09);
  return mix(colour, rgb(f.look.hair) * 0.80, edge * hairs);
}

// The opening between the lids: an almond, its outer corner a little higher.
struct EyeOpening {
  double dy, dz, upper, lower;
  explicit EyeOpening(const FacePoint& f) : dy(f.side - 0.0316), dz(f.q.z() - 1.6322 - 0.07 * dy) {
    const double u = dy / 0.0152, open = f.build.face.eyes * (f.is_male() ? 0.94 : 1.10);
    const double arc = std::max(0.0, 1.0 - u * u);
    upper = 0.0060 * open * std::pow(arc, 0.62) * (1.0 - 0.12 * u);
    lower = -0.0042 * open * std::pow(arc, 0.80) * (1.0 + 0.15 * u);
  }
  bool within() const { return std::abs(dy) < 0.0152; }
};

Vector3d eyeball(const FacePoint& f, const EyeOpening& eye) {
  Vector3d ball(0.83, 0.80, 0.785);
  ball = mix(ball, Vector3d(0.76, 0.52, 0.48), 0.7 * step_up(std::abs(eye.dy) - 0.0132, 0.0035));
  const double dy = eye.dy - 0.0003, dz = eye.dz - 0.0012, r = std::hypot(dy, dz);
  const double rays = 0.25 * solid_noise(Vector3d(std::atan2(dz, dy) * 6.0, r / 0.003, 0.0), f.build.seed + 44);
  Vector3d iris = rgb(f.look.iris) * (1.0 + rays) * (dz < 0.0 ? 1.20 : 0.90);
  iris = mix(iris, iris * 0.35, step_up(r - 0.0050, 0.0010));
  ball = mix(ball, iris, band(r, 0.0057, 0.0007));
  ball = mix(ball, Vector3d(0.02, 0.02, 0.02), band(r, 0.0023, 0.0005));
  ball *= 0.62 + 0.38 * step_up(eye.upper - eye.dz - 0.0018, 0.0030);  // the upper lid's shadow
  return mix(ball, Vector3d(1.0, 1.0, 1.0),
             0.9 * disc(f.q.y() - std::copysign(0.0316, f.q.y()) - 0.0016, dz - 0.0018, 0.0006, 0.0006));
}

Vector3d eyes(const FacePoint& f, Vector3d colour) {
  if (f.q.x() < 0.045 || std::abs(f.side - 0.0316) > 0.022 || std::abs(f.q.z() - 1.6322) > 0.018) return colour;
  const EyeOpening eye(f);
  const double crease = eye.dz - eye.upper - 0.0036 - 0.0006 * (1.0 - std::abs(eye.dy) / 0.0152);
  colour = mix(colour, colour * 0.62, 0.75 * band(crease, 0.0004, 0.0013) * band(eye.dy, 0.0150, 0.004));
  const double open = std::min(step_up(eye.upper - eye.dz, 0.0009), step_up(eye.dz - eye.lower, 0.0009));
  if (eye.within()) colour = mix(colour, eyeball(f, eye), open);
  const double near = band(eye.dy, 0.0152, 0.0016);
  const double lash = f.is_male() ? 0.0007 : 0.0011;
  colour = mix(colour, Vector3d(0.10, 0.06, 0.05), 0.90 * near * band(eye.dz - eye.upper, lash, 0.0010));
  const double wet = band(eye.dz - eye.lower, 0.0004, 0.0009);
  colour = mix(colour, Vector3d(0.48, 0.27, 0.24), 0.60 * near * wet);
  const double bag = eye.dz - eye.lower + 0.0062 - 0.012 * std::abs(eye.dy);
  return mix(colour, colour * 0.84, 0.45 * band(bag, 0.0006, 0.0020) * band(eye.dy + 0.003, 0.009, 0.006));
}

}  // namespace

bool is_eyeball(const BodyBuild& build, const Vector3d& q) {
  if (q.x() < 0.045) return false;
  const Clothing any;
  const EyeOpening eye(FacePoint{build, any, q, std::abs(q.y())});
  return eye.within() && eye.dz < eye.upper && eye.dz > eye.lower;
}

Vector3d face_colour(const BodyBuild& build, const Clothing& look, const Vector3d& q, Vector3d colour) {
  const FacePoint f{build, look, q, std::abs(q.y())};
  colour = complexion(f, colour);
  colour = stubble(f, colour);
  colour = lips(f, colour);
  colour = nostrils(f, colour);
  colour = eyes(f, colour);
  return brows(f, colour);
}

}  // namespace rotunda::simulator
