// A supine right leg from the thigh to the foot (the knee cap looks to -y).
#include "turgor/geometry/phantom_shapes.hpp"

namespace turgor::phantom {

namespace {

struct Leg {
  Profile radius{{-440, 33}, {-395, 36}, {-330, 41}, {-240, 56}, {-170, 60}, {-90, 52},
                 {-20, 56},  {30, 60},   {120, 68},  {260, 78},  {460, 86}};
  Profile center{{-440, 10}, {-330, 12}, {-200, 18}, {-100, 14}, {0, 4}, {200, 6}, {460, 8}};  // y
};

void paint_outside(Anatomy& anatomy, const Leg& leg) {
  paint(anatomy, {-100, -102, -460}, {100, 102, 1e4f}, {{0, kSkin}, {2, kFat}}, 0, [=](float y, float z) {
    const float r = leg.radius(z), c = leg.center(z);
    return [=](float x) {
      const float column = std::max(ellipsoid_distance({x, y - c, 0}, {0.95f * r, r, 1e6f}), -445 - z);
      const float sole = capsule_distance({x * 0.85f, y, z * 1.15f}, {0, 26, -480}, {0, -62, -488}, 31);
      const float knee = ellipsoid_distance({x, y + 44, z - 8}, {28, 20, 32});
      return smooth_min(smooth_min(column, sole, 30), knee, 20);
    };
  });
}

/// Muscles as sectors of the leg's cross section, with fat between them.
void paint_muscles(Anatomy& anatomy, const Leg& leg) {
  paint(anatomy, {-100, -102, -400}, {100, 102, 1e4f}, kMuscle, 0, [=](float y, float z) {
    const float r = leg.radius(z), c = leg.center(z), inset = 9 + 6 * std::clamp((z + 100) / 300, 0.0f, 1.0f);
    const float knee = std::abs(z) < 40 ? 14 * (1 - std::abs(z) / 40) : 0.0f, turn = 0.004f * z, v = y - c;
    return [=](float x) {
      const float outline = ellipsoid_distance({x, v, 0}, {0.95f * r, r, 1e6f}) + inset + knee;
      float seam = 1e3f;
      for (int s = 0; s < 5; s++) {
        const float angle = 1.2566f * float(s) + 0.5f + turn,
                    along = std::cos(angle) * x + std::sin(angle) * v;
        const float across = std::abs(std::sin(angle) * x - std::cos(angle) * v);
        seam = std::min(seam, along > 0 ? across : 1e3f);
      }
      return std::max(outline, 1.3f - seam);
    };
  });
}

void paint_bones(Anatomy& anatomy) {
  const auto shaft = [&](Vec3 a, Vec3 b, float radius, float cortex, std::uint16_t label) {
    paint_capsule(anatomy, a, b, radius, 1200, label);
    paint_capsule(anatomy, a, b, radius - cortex, -60, label);  // yellow marrow
  };
  shaft({-6, 2, 40}, {8, 4, 560}, 14.5f, 5, 76);
  for (const float side : {-1.0f, 1.0f}) {
    paint_bone_ellipsoid(anatomy, {side * 22, 10, 26}, {20, 27, 25}, 1.8f, 76);
    paint_bone_ellipsoid(anatomy, {side * 20, 8, -22}, {21, 22, 17}, 1.8f);
    paint_ellipsoid(anatomy, {side * 21, 9, 0}, {17, 20, 4}, kCartilage);
  }
  paint_bone_ellipsoid(anatomy, {0, 0, 38}, {24, 18, 24}, 1.8f, 76);
  paint_bone_ellipsoid(anatomy, {0, -44, 14}, {20, 9, 21}, 1.6f);
  paint_capsule(anatomy, {0, -42, 34}, {0, -50, 100}, 4, 90);
  paint_capsule(anatomy, {0, -42, -4}, {0, -32, -52}, 4, 90);
  shaft({6, -4, -40}, {10, 4, -400}, 12, 4, 0);
  shaft({-34, 22, -36}, {-24, 18, -400}, 5.5f, 2, 0);
  paint_bone_ellipsoid(anatomy, {8, 4, -400}, {20, 18, 15}, 1.6f);
  paint_bone_ellipsoid(anatomy, {-24, 16, -408}, {8, 10, 14}, 1.4f);
  paint_bone_ellipsoid(anatomy, {2, 2, -420}, {18, 24, 11}, 1.5f);
  paint_bone_capsule(anatomy, {0, 22, -430}, {0, 38, -434}, 12, 1.8f);
  paint_bone_capsule(anatomy, {4, -14, -424}, {4, -34, -428}, 11, 1.5f);
  for (int toe = 0; toe < 5; toe++) {
    const float x = 20 - 10 * float(toe);
    paint_bone_capsule(anatomy, {0.7f * x, -44, -427}, {x, -74, -432}, 4.5f, 1.3f);
  }
}

void paint_vessels(Anatomy& anatomy) {
  paint_capsule(anatomy, {-26, -6, 460}, {-12, 34, 60}, 5, 60);
  paint_capsule(anatomy, {-12, 34, 60}, {-4, 40, -80}, 4.5f, 60);
  paint_capsule(anatomy, {-34, 0, 460}, {-20, 36, 60}, 6, 45);
  paint_capsule(anatomy, {-4, 40, -80}, {16, 30, -390}, 2.5f, 60);
}

}  // namespace

Anatomy make_leg(std::uint64_t) {
  const Leg leg;
  Anatomy anatomy;
  paint_table(anatomy, 101, 98);
  paint_outside(anatomy, leg);
  paint_muscles(anatomy, leg);
  paint_vessels(anatomy);
  paint_bones(anatomy);
  return anatomy;
}

}  // namespace turgor::phantom
