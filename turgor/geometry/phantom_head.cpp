// A supine head with its neck (the face looks to -y).
#include "turgor/geometry/phantom_shapes.hpp"

namespace turgor::phantom {

namespace {

/// Cranium, face, jaw, neck, nose and ears, blended into one surface.
float head_distance(Vec3 p) {
  const auto ellipsoid = [&](Vec3 c, Vec3 r) { return ellipsoid_distance(p - c, r); };
  float d = smooth_min(ellipsoid({0, 12, 52}, {74, 92, 78}), ellipsoid({0, -24, -10}, {66, 72, 74}), 24);
  d = smooth_min(d, ellipsoid({0, -46, -52}, {50, 46, 32}), 26);
  d = smooth_min(
      d, ellipsoid_distance({p.x, p.y - 26, 0}, {54, 56, kEndless}) + std::max(0.0f, (p.z + 40) * 0.9f), 30);
  d = smooth_min(d, capsule_distance(p, {0, -90, 14}, {0, -101, -12}, 8), 14);
  const Vec3 q{std::abs(p.x), p.y, p.z};
  return smooth_min(d, ellipsoid_distance(q - Vec3{73, 16, 6}, {8, 15, 29}), 8);
}

void paint_outside(Anatomy& anatomy) {
  paint(anatomy, {-90, -112, -kEndless}, {90, 108, 135}, {{0, kSkin}, {2, kFat}, {5, kMuscle}}, 0,
        [](float y, float z) { return [=](float x) {
                                 return head_distance({x, y, z});
                               }; });
}

void paint_skull(Anatomy& anatomy) {
  paint_ellipsoid(anatomy, {0, 12, 50}, {68, 86, 71}, kCortex, 91);
  paint_ellipsoid(anatomy, {0, 12, 50}, {66, 84, 69}, 450, 91);
  paint_ellipsoid(anatomy, {0, 12, 50}, {63, 81, 66}, kCortex, 91);
  paint_ellipsoid(anatomy, {0, 12, 50}, {61, 79, 64}, kWater, 90);
}

/// Folded gray matter over white matter, and the ventricles.
void paint_brain(Anatomy& anatomy) {
  const auto folded = [](float shrink, float depth) {
    return [=](float y, float z) {
      return [=](float x) {
        const float fold =
            depth * std::sin(0.28f * x + 0.1f * z) * std::sin(0.25f * y) * std::sin(0.27f * z + 0.08f * x);
        const float middle = 1.2f - std::abs(x) - std::max(0.0f, 45 - z);  // longitudinal fissure
        const float brain =
            ellipsoid_distance({x, y - 12, z - 50}, {59 - shrink, 77 - shrink, 62 - shrink}) + fold;
        return std::max(brain, middle);
      };
    };
  };
  const Vec3 low{-62, -68, -14}, high{62, 92, 114};
  paint(anatomy, low, high, 38, 90, folded(0, 1.5f));
  paint(anatomy, low, high, 28, 90, folded(5, 5));
  for (const float side : {-1.0f, 1.0f}) {
    paint_capsule(anatomy, {side * 9, -16, 60}, {side * 13, 42, 62}, 6, 8, 90);
    paint_capsule(anatomy, {side * 13, 42, 62}, {side * 24, 26, 40}, 5, 8, 90);
    paint_ellipsoid(anatomy, {side * 20, 44, 8}, {23, 21, 17}, 36, 90);
  }
  paint_capsule(anatomy, {0, 30, 20}, {0, 34, -30}, 11, 32, 90);
}

/// Region of a shape at least `depth` below the skin.
Shape below_skin(Shape shape, float depth) {
  shape.distance = [depth, whole = std::move(shape.distance)](const Row& row, float* out) {
    whole(row, out);
    for (int i = 0; i < row.count; i++)
      out[i] = std::max(out[i], head_distance({row.x + float(i) * row.dx, row.y, row.z}) + depth);
  };
  return shape;
}

void paint_face(Anatomy& anatomy) {
  for (const float side : {-1.0f, 1.0f}) {
    paint_ellipsoid(anatomy, {side * 31, -60, 8}, {22, 24, 20}, kCortex - 300, 91);  // orbit: rim, fat, eye
    paint_ellipsoid(anatomy, {side * 31, -64, 8}, {19, 26, 17}, kFat + 20);
    paint_ellipsoid(anatomy, {side * 31, -69, 8}, {12, 12, 12}, 15);
    paint_ellipsoid(anatomy, {side * 31, -77, 8}, {5, 2.2f, 5}, 90);
    paint_capsule(anatomy, {side * 28, -58, 8}, {side * 12, -38, 10}, 2.2f, 35);
    paint_bone_capsule(anatomy, {side * 40, -60, -14}, {side * 60, -18, -4}, 5, 1.6f, 91);
    paint_ellipsoid(anatomy, {side * 27, -55, -18}, {17, 19, 17}, kCortex - 300, 91);  // maxillary sinus
    paint_ellipsoid(anatomy, {side * 27, -55, -18}, {15.5f, 17.5f, 15.5f}, kGas);
    paint_ellipsoid(anatomy, {side * 48, 20, 0}, {16, 18, 13}, kCortex, 91);  // petrous bone with its canal
    paint_capsule(anatomy, {side * 42, 18, 2}, {side * 78, 16, 2}, 3, kGas);
    paint_bone_capsule(anatomy, {side * 46, 0, -10}, {side * 44, -14, -52}, 7, 1.8f, 91);  // jaw
    paint_bone_capsule(anatomy, {side * 44, -14, -52}, {side * 12, -68, -60}, 7.5f, 2, 91);
  }
  paint_bone_capsule(anatomy, {-12, -68, -60}, {12, -68, -60}, 8, 2, 91);
  paint_ellipsoid(anatomy, {0, -52, -16}, {11, 34, 20}, kGas);  // nose, divided
  paint_capsule(anatomy, {0, -84, -12}, {0, -30, -14}, 1.4f, 400);
  paint_ellipsoid(anatomy, {0, -38, -46}, {24, 30, 11}, kMuscle);  // tongue
  for (int tooth = -7; tooth <= 7; tooth++) {
    const float angle = 0.19f * float(tooth), x = 26 * std::sin(angle), y = -48 - 28 * std::cos(angle);
    paint_capsule(anatomy, {x, y, -33}, {x, y, -39}, 3.2f, 1900);
    paint_capsule(anatomy, {x, y, -43}, {x, y, -50}, 3.0f, 1900);
  }
}

void paint_neck(Anatomy& anatomy) {
  paint_capsule(anatomy, {0, -6, -28}, {0, -2, -200}, 11, 40);
  paint_capsule(anatomy, {0, -6, -28}, {0, -2, -200}, 9, kGas, 16);
  paint_capsule(anatomy, {0, 32, -36}, {0, 34, -200}, 11, 85);
  for (int level = 0; level < 6; level++) {
    const float z = -38 - 18 * float(level);
    const auto label = std::uint16_t(50 - level);
    paint_bone_ellipsoid(anatomy, {0, 33, z}, {15, 12, 9}, 1.6f, label);
    for (const float side : {-1.0f, 1.0f}) {
      paint_bone_capsule(anatomy, {side * 14, 42, z}, {side * 16, 54, z - 2}, 4, 1.2f, label);
      paint_bone_capsule(anatomy, {side * 14, 56, z - 2}, {0, 64, z - 4}, 3, 1, label);
    }
  }
  paint_capsule(anatomy, {0, 49, -24}, {0, 51, -200}, 7, 30, 79);
  for (const float side : {-1.0f, 1.0f}) {
    paint_capsule(anatomy, {side * 26, 8, -40}, {side * 22, 4, -200}, 4, 60,
                  std::uint16_t(side < 0 ? 57 : 58));
    paint_capsule(anatomy, {side * 34, 10, -40}, {side * 28, 6, -200}, 6, 45);
  }
}

}  // namespace

Anatomy make_head(std::uint64_t) {
  Anatomy anatomy;
  paint_table(anatomy, 116, 108);
  paint_outside(anatomy);
  paint_skull(anatomy);
  paint_brain(anatomy);
  paint_neck(anatomy);
  Anatomy face;
  paint_face(face);
  for (Shape& shape : face) anatomy.push_back(below_skin(std::move(shape), 3));
  return anatomy;
}

}  // namespace turgor::phantom
