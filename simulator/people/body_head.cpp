// Head and face on the reference head (HeadFrame). Proportions after Farkas, Anthropometry of the Head and Face, 1994
// (young adults, medians): head 0.196 long, 0.152 broad, 0.226 high; vertex 1.744, glabella 1.652, eyes 1.632,
// subnasale 1.587, mouth 1.564, chin 1.520; across the cheekbones 0.137 (women 0.130), the angles of the jaw 0.102
// (0.091).
#include <cmath>

#include "simulator/people/body_part_list.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;
using enum Material;

Vector3d at(double x, double y, double z) {
  return {x, y, z};
}

class Head {
 public:
  Head(PartList& body, const HeadFrame& frame) : body_(body), frame_(frame) {}

  BodyPart& cone(const Vector3d& a, const Vector3d& b, double ra, double rb, double blend, Material material = skin) {
    BodyPart part = blank(material, blend);
    part.a = frame_.from_reference(a);
    part.b = frame_.from_reference(b);
    part.radius_a = ra * frame_.scale;
    part.radius_b = rb * frame_.scale;
    return body_.add(part);
  }
  BodyPart& ellipsoid(const Vector3d& centre, const Vector3d& radii, double blend, Material material = skin) {
    BodyPart part = blank(material, blend);
    part.kind = BodyPart::Kind::ellipsoid;
    part.a = part.b = frame_.from_reference(centre);
    part.radii = radii * frame_.scale;
    return body_.add(part);
  }
  void carve(const Vector3d& centre, const Vector3d& radii, double blend) {
    ellipsoid(centre, radii, blend).carve = true;
  }
  void scalp() {
    BodyPart part = blank(hair, 0.003);
    part.kind = BodyPart::Kind::scalp;
    part.a = part.b = frame_.from_reference(at(-0.03, 0.0, 1.63));
    part.radius_a = part.radius_b = 0.23 * frame_.scale;
    body_.add(part);
  }
  const FaceBuild& face() const { return body_.build().face; }
  bool is_male() const { return body_.build().sex == Sex::male; }

 private:
  BodyPart blank(Material material, double blend) const {
    BodyPart part;
    part.joint = Joint::head;
    part.material = material;
    part.blend = blend * frame_.scale;
    return part;
  }
  PartList& body_;
  HeadFrame frame_;
};

void add_skull(Head& head) {
  head.ellipsoid(at(-0.010, 0, 1.664), at(0.097, 0.076, 0.082), 0.02);
  head.ellipsoid(at(0.036, 0, 1.673), at(0.054, 0.061, 0.056), 0.03);   // forehead
  head.ellipsoid(at(0.030, 0, 1.602), at(0.057, 0.060, 0.070), 0.025);  // middle of the face
}

void add_jaw(Head& head, Side side) {
  const double s = sign_of(side), wide = head.face().jaw * (head.is_male() ? 1.0 : 0.88);
  const Vector3d ear = at(-0.004, s * 0.056, 1.606), angle = at(0.012, s * 0.039 * wide, 1.560);
  const Vector3d chin = at(0.077, s * 0.012 * wide, 1.5345);
  head.cone(ear, angle, 0.013, 0.013, 0.020);
  head.cone(angle, chin, 0.014, 0.0150, 0.022);
  const double bone = head.is_male() ? 0.0600 : 0.0575;
  head.cone(at(0.060, s * 0.045, 1.607), at(-0.002, s * bone, 1.617), 0.013 * head.face().cheeks, 0.008, 0.016);
  head.ellipsoid(at(0.044, s * 0.033 * wide, 1.580), at(0.032, 0.018, 0.030), 0.022);
  head.ellipsoid(at(0.062, s * 0.036, 1.598), Vector3d(0.022, 0.020, 0.022) * head.face().cheeks, 0.018);
}

void add_brow(Head& head, Side side) {
  const double s = sign_of(side), ridge = head.face().brow * (head.is_male() ? 1.0 : 0.72);
  head.cone(at(0.0815, s * 0.010, 1.6535), at(0.066, s * 0.045, 1.6540), 0.0085 * ridge, 0.0080 * ridge, 0.016);
}

void add_eye(Head& head, Side side) {
  const double s = sign_of(side);
  head.carve(at(0.094, s * 0.0325, 1.634), at(0.018, 0.0185, 0.0105), 0.012);
  head.ellipsoid(at(0.0665, s * 0.0318, 1.6325), at(0.0138, 0.0150, 0.0130), 0.004);
  // the fold of the upper lid, and the bag under the lower
  head.cone(at(0.0765, s * 0.0180, 1.6400), at(0.0690, s * 0.0450, 1.6405), 0.0040, 0.0042, 0.006);
  head.cone(at(0.0770, s * 0.0210, 1.6235), at(0.0700, s * 0.0430, 1.6240), 0.0038, 0.0040, 0.008);
}

void add_nose(Head& head) {
  const double wide = head.face().nose_width * (head.is_male() ? 1.0 : 0.90), out = head.face().nose_length - 1.0;
  const double far = 0.018 * out - (head.is_male() ? 0.0 : 0.0025);
  head.cone(at(0.0800, 0, 1.6420), at(0.1000 + far, 0, 1.6060), 0.0085 * wide, 0.0085 * wide, 0.012);
  head.ellipsoid(at(0.1025 + far, 0, 1.6010), at(0.0105, 0.0105 * wide, 0.0090), 0.008);
  head.cone(at(0.1040 + far, 0, 1.5950), at(0.0900, 0, 1.5885), 0.0045, 0.0055, 0.005);
  for (const double s : {1.0, -1.0}) {
    head.ellipsoid(at(0.0940 + 0.5 * far, s * 0.0120 * wide, 1.5955), at(0.0095, 0.0062 * wide, 0.0070), 0.005);
    head.cone(at(0.0900, s * 0.008, 1.615), at(0.0830, s * 0.022, 1.600), 0.008, 0.006, 0.014);  // beside the nose
    head.carve(at(0.0985 + 0.7 * far, s * 0.0068 * wide, 1.5880), at(0.0060, 0.0032, 0.0042), 0.003);
  }
}

void add_mouth(Head& head) {
  const double full = head.face().lips * (head.is_male() ? 0.92 : 1.10);
  head.ellipsoid(at(0.0760, 0, 1.5690), at(0.0170, 0.0290, 0.0240), 0.018);
  for (const double s : {1.0, -1.0}) {
    head.cone(at(0.0895, s * 0.0035, 1.5678), at(0.0790, s * 0.0240, 1.5648), 0.0052 * full, 0.0030, 0.004);
    head.cone(at(0.0880, s * 0.0020, 1.5592), at(0.0790, s * 0.0215, 1.5632), 0.0060 * full, 0.0032, 0.004);
  }
  head.carve(at(0.1005, 0, 1.5484), at(0.0100, 0.0170, 0.0060), 0.010);  // over the chin
  head.carve(at(0.0985, 0, 1.5790), at(0.0050, 0.0035, 0.0080), 0.004);  // philtrum
  head.ellipsoid(at(0.0780, 0, 1.5365), at(0.0150, 0.0200, 0.0150), 0.016);
}

void add_ear(Head& head, Side side) {
  const double s = sign_of(side);
  const Vector3d across = at(0.36, s, 0.0).normalized();
  auto& plate = head.cone(at(-0.017, s * 0.080, 1.638), at(-0.006, s * 0.0765, 1.606), 0.0165, 0.0095, 0.008);
  plate.across = across;
  plate.flatness = 0.38;
  const std::array<Vector3d, 6> rim = {at(-0.0045, s * 0.0800, 1.6330), at(-0.0065, s * 0.0845, 1.6500),
                                       at(-0.0195, s * 0.0890, 1.6565), at(-0.0315, s * 0.0905, 1.6440),
                                       at(-0.0270, s * 0.0860, 1.6200), at(-0.0080, s * 0.0790, 1.5985)};
  for (std::size_t i = 0; i + 1 < rim.size(); ++i) head.cone(rim[i], rim[i + 1], 0.0040, 0.0040, 0.007);
  head.ellipsoid(at(-0.0030, s * 0.0775, 1.6000), at(0.0070, 0.0045, 0.0070), 0.004);  // lobe
  head.cone(at(0.0010, s * 0.0770, 1.6260), at(0.0020, s * 0.0760, 1.6160), 0.0045, 0.0040, 0.004);
  head.carve(at(-0.0090, s * 0.0895, 1.6270), at(0.0100, 0.0065, 0.0150), 0.006);
}

void add_beard(Head& head) {
  const double thick = head.face().beard, wide = head.face().jaw;
  if (thick <= 0.0) return;
  for (const double s : {1.0, -1.0}) {
    const Vector3d ear = at(0.006, s * 0.062, 1.604), angle = at(0.016, s * 0.050 * wide, 1.562);
    const Vector3d chin = at(0.080, s * 0.013 * wide, 1.5340), lip = at(0.0880, s * 0.004, 1.5765);
    head.cone(ear, angle, 0.012 + 0.4 * thick, 0.014 + thick, 0.006, hair);
    head.cone(angle, chin, 0.014 + thick, 0.0165 + thick, 0.008, hair);
    head.cone(lip, at(0.0740, s * 0.0300, 1.5640), 0.0055 + 0.4 * thick, 0.0060 + 0.4 * thick, 0.004, hair);
    head.cone(at(0.0740, s * 0.0300, 1.5640), at(0.074, s * 0.024, 1.5440), 0.0060 + 0.4 * thick, 0.012 + thick, 0.006,
              hair);
  }
}

void add_neck(PartList& body, const HeadFrame& frame) {
  const double thick = body.build().sex == Sex::male ? 1.0 : 0.84, k = body.scale();
  const Vector3d top = frame.from_reference(at(-0.008, 0, 1.590));
  body.cone(Joint::neck, skin, at(-0.030, 0, 1.43) * k, top, 0.062 * thick, 0.053 * thick, 0.02);
  for (const double s : {1.0, -1.0}) {  // the muscle from behind the ear to the breastbone
    const Vector3d ear = frame.from_reference(at(-0.022, s * 0.052, 1.585));
    body.cone(Joint::neck, skin, ear, at(0.030, s * 0.018, 1.452) * k, 0.014 * thick, 0.010 * thick, 0.020);
  }
  if (body.build().sex == Sex::male)
    body.ellipsoid(Joint::neck, skin, at(0.034, 0, 1.502), at(0.012, 0.011, 0.014), 0.016);  // Adam's apple
}

}  // namespace

void add_head(PartList& body, const HeadFrame& frame) {
  add_neck(body, frame);
  Head head(body, frame);
  add_skull(head);
  for (const Side side : {Side::left, Side::right}) {
    add_jaw(head, side);
    add_brow(head, side);
  }
  add_nose(head);
  add_mouth(head);
  for (const Side side : {Side::left, Side::right}) {
    add_eye(head, side);
    add_ear(head, side);
  }
  head.scalp();
  add_beard(head);
  const double k = body.scale(), ease = body.build().ease;
  if (ease <= 0.0) return;
  auto& collar = body.cone(Joint::neck, shirt, at(-0.026, 0, 1.43) * k, at(-0.010, 0, 1.502) * k, 0.082, 0.067, 0.006);
  collar.open_end = true;
}

}  // namespace rotunda::simulator
