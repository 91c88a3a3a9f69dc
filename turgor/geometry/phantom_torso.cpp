// A supine torso from the chest to the hips, with the arms above the head (the front faces -y).
#include "turgor/geometry/phantom.hpp"
#include "turgor/geometry/phantom_shapes.hpp"

namespace turgor::phantom {

namespace {

/// Outline of the trunk and derived shapes.
struct Trunk {
  Profile half_width{{-150, 168}, {-95, 163}, {-35, 146}, {40, 152}, {110, 162}, {160, 158}};
  Profile half_depth{{-150, 102}, {-90, 100}, {-30, 94}, {50, 103}, {110, 106}, {160, 100}};
  float fat = 16;      // under the skin, on the sides [mm]
  float center = -18;  // y of the middle [mm]
};

void paint_layer(Anatomy& anatomy, const Trunk& trunk, float inset, float hu) {
  const float a = trunk.half_width.largest() + 3, b = trunk.half_depth.largest() + 3;
  paint(anatomy, {-a, trunk.center - b, -kEndless}, {a, trunk.center + b, kEndless}, hu, 0,
        [=](float y, float z) {
          const float width = trunk.half_width(z) - inset, depth = trunk.half_depth(z) - inset,
                      v = y - trunk.center;
          return [=](float x) { return trunk_distance(x, v, width, depth); };
        });
}

void paint_layers(Anatomy& anatomy, const Trunk& trunk) {
  paint_layer(anatomy, trunk, 0, kSkin);
  paint_layer(anatomy, trunk, 2, kFat);
  paint_layer(anatomy, trunk, 2 + trunk.fat, kMuscle);
  paint_layer(anatomy, trunk, 2 + trunk.fat + 13, kFat - 5);  // fat around the organs
}

/// The lungs fill the rib cage on both sides of the heart.
void paint_lungs(Anatomy& anatomy, const Trunk& trunk) {
  const float inset = trunk.fat + 19;
  for (const float side : {-1.0f, 1.0f}) {
    const Vec3 center{side * 74, -14, 105}, radius{62, 80, 118};
    const std::uint16_t label = side < 0 ? 14 : 11;
    paint(anatomy, {center.x - 66, -110, -20}, {center.x + 66, 75, kEndless}, kLung, label,
          [=](float y, float z) {
            const float width = trunk.half_width(z) - inset, depth = trunk.half_depth(z) - inset;
            return [=](float x) {
              const float wall = trunk_distance(x, y - trunk.center, width, depth);
              return std::max(wall, ellipsoid_distance({x - center.x, y - center.y, z - center.z}, radius));
            };
          });
    for (int branch = 0; branch < 14; branch++) {  // vessels that fan out from the hilum
      const float angle = 2.4f * float(branch), reach = 38 + 12 * std::sin(1.7f * float(branch));
      const Vec3 hilum{side * 32, 0, 82};
      const Vec3 tip = hilum + Vec3{side * (20 + reach * std::abs(std::cos(angle))), reach * std::sin(angle),
                                    reach * std::cos(1.3f * angle)};
      paint_capsule(anatomy, hilum, tip, 1.8f + 0.8f * std::cos(angle), 30, kKeepLabel);
    }
  }
}

void paint_chest(Anatomy& anatomy) {
  paint_ellipsoid(anatomy, {2, -14, 130}, {26, 46, 75}, 0);  // mediastinum
  paint_ellipsoid(anatomy, {22, -42, 72}, {50, 40, 46}, kBlood, 51);
  paint_capsule(anatomy, {0, -4, 90}, {0, -4, 190}, 9, 40, 16);
  paint_capsule(anatomy, {0, -4, 90}, {0, -4, 190}, 7, kGas, 16);
  paint_capsule(anatomy, {9, 2, -95}, {15, 8, 190}, 10.5f, 60, 52);
  paint_capsule(anatomy, {-14, 4, -95}, {-18, -8, 60}, 10.5f, 45, 63);
}

void paint_liver(Anatomy& anatomy, const Trunk& trunk, std::uint64_t seed) {
  const float inset = trunk.fat + 19;
  const Vec3 right{-62, -14, 6}, left{5, -48, 18};
  const Vec3 right_radius{70 + 4 * variation(seed, 3), 74, 62}, left_radius{62, 30, 32};
  paint(anatomy, {-140, -115, -62}, {72, 66, 72}, kLiver, 5, [=](float y, float z) {
    const float width = trunk.half_width(z) - inset, depth = trunk.half_depth(z) - inset;
    return [=](float x) {
      const float lobes =
          smooth_min(ellipsoid_distance({x - right.x, y - right.y, z - right.z}, right_radius),
                     ellipsoid_distance({x - left.x, y - left.y, z - left.z}, left_radius), 14);
      return std::max(trunk_distance(x, y - trunk.center, width, depth), lobes);
    };
  });
  paint_capsule(anatomy, {-10, -10, -2}, {-75, -20, 12}, 5, 90, 5);
  paint_capsule(anatomy, {-40, -14, 4}, {-70, 20, -8}, 4, 90, 5);
  paint_ellipsoid(anatomy, {-38, -52, -34}, {15, 22, 22}, 12, 4);
  // Under a centimeter of tissue: palpable on the liver's front.
  const Vec3 nodule{-60 + 6 * variation(seed, 4), -52 + 3 * variation(seed, 5), 4 + 8 * variation(seed, 6)};
  paint_ellipsoid(anatomy, nodule, {13, 13, 13}, kNodule, kNoduleLabel);
}

/// A hollow organ: wall, fluid, and gas above the level `gas_below_y` (the front is up).
void paint_hollow(Anatomy& anatomy, Vec3 center, Vec3 radius, float gas_above, std::uint16_t label) {
  paint_ellipsoid(anatomy, center, radius, 45, label);
  const Vec3 inner = radius - Vec3{3, 3, 3}, m{2, 2, 2};
  paint_ellipsoid(anatomy, center, inner, 15, label);
  paint(anatomy, center - inner - m, center + inner + m, kGas, label, [=](float y, float z) {
    return [=](float x) {
      return std::max(ellipsoid_distance({x - center.x, y - center.y, z - center.z}, inner),
                      y - center.y - gas_above);
    };
  });
}

void paint_colon(Anatomy& anatomy, Vec3 a, Vec3 b) {
  constexpr float kRadius = 19;
  paint_capsule(anatomy, a, b, kRadius, 45, 20);
  paint_capsule(anatomy, a, b, kRadius - 3, -40, 20);
  const Vec3 m{kRadius, kRadius, kRadius};
  const float level = std::min(a.y, b.y) + 3;
  paint(anatomy, min(a, b) - m, max(a, b) + m, kGas, 20, [=](float y, float z) {
    return [=](float x) {
      const float fold = 1.5f * std::sin((x + z) * 0.22f);  // haustra
      return std::max(capsule_distance({x, y, z}, a, b, kRadius - 4 + fold), y - level);
    };
  });
}

void paint_belly(Anatomy& anatomy, std::uint64_t seed) {
  paint_ellipsoid(anatomy, {84, 14, 20}, {26, 38, 44}, 50, 1);
  paint_hollow(anatomy, {52, -28, 14}, {40, 38, 44}, -8, 6);
  paint_capsule(anatomy, {-18, -22, -26}, {60, 0, 4}, 11, 40, 7);
  for (const float side : {-1.0f, 1.0f}) {
    const std::uint16_t label = side < 0 ? 2 : 3;
    paint_ellipsoid(anatomy, {side * 66, 20, -30 + 8 * side}, {26, 23, 50}, 35, label);
    paint_ellipsoid(anatomy, {side * 54, 16, -30 + 8 * side}, {13, 10, 26}, kFat, label);
  }
  paint_colon(anatomy, {-98, 2, -105}, {-98, -4, -48});
  paint_colon(anatomy, {100, 12, -112}, {102, 8, -42});
  paint_colon(anatomy, {-88, -54, -52}, {90, -58, -44});
  paint_ellipsoid(anatomy, {0, -34, -138}, {36, 30, 24}, 10, 21);
  for (int loop = 0; loop < 30; loop++) {
    const auto random = [&](int which) { return variation(seed, 100 + 8 * loop + which); };
    const Vec3 center{31 * (float(loop % 5) - 2) + 10 * random(0),
                      -34 + 24 * (float(loop / 5 % 3) - 1) + 9 * random(1),
                      -82 - 30 * float(loop / 15) + 12 * random(2)};
    const Vec3 radius{19 + 7 * random(3), 13 + 2 * random(4), 16 + 5 * random(5)};
    paint_hollow(anatomy, center, radius, random(6) > 0.3f ? -2.0f : -20.0f, 18);
  }
}

void paint_spine(Anatomy& anatomy) {
  paint_capsule(anatomy, {0, 34, -200}, {0, 34, 200}, 18, 85);  // discs show between the vertebrae
  for (int level = 0; level < 11; level++) {
    const float z = -138 + 30 * float(level);
    const auto label = std::uint16_t(27 + level);
    paint_bone_ellipsoid(anatomy, {0, 34, z}, {24, 18, 13.5f}, 2.2f, label);
    for (const float side : {-1.0f, 1.0f}) {
      paint_bone_capsule(anatomy, {side * 12, 46, z + 3}, {side * 14, 58, z + 1}, 4.5f, 1.5f, label);
      paint_bone_capsule(anatomy, {side * 14, 59, z}, {side * 34, 61, z + 2}, 3.8f, 1.5f, label);
      paint_bone_capsule(anatomy, {side * 13, 60, z}, {0, 66, z - 4}, 3.2f, 1.2f, label);
    }
  }
  paint_capsule(anatomy, {0, 54, -200}, {0, 54, 200}, 6.5f, 25, 79);
}

/// All ribs at once: on the surface inside the chest wall, a periodic band that descends from the spine to
/// the front.
void paint_ribs(Anatomy& anatomy, const Trunk& trunk) {
  constexpr float kPitch = 27, kDrop = 88, kLowest = 30;
  const auto rib = [=](float thinner, float from) {
    return [=](float y, float z) {
      const float inset = trunk.fat + 15;
      const float width = trunk.half_width(z) - inset, depth = trunk.half_depth(z) - inset,
                  v = (y - trunk.center) / depth;
      return [=](float x) {
        const float u = x / width,
                    back = v / (std::sqrt(u * u + v * v) + 1e-6f);       // 1 at the spine, -1 at the front
        const float spine_z = z + kDrop * std::sqrt(0.5f * (1 - back));  // height of this rib at the spine
        const float level = std::max(std::round((spine_z - kLowest) / kPitch), 0.0f);
        const float along = (spine_z - kLowest - level * kPitch) / 6.5f;
        const float across = trunk_distance(x, y - trunk.center, width, depth) / 4;
        const float r = std::sqrt(along * along + across * across);
        const float floating = level < 1.5f ? (-0.2f - back) * 40 : -10.0f;  // lowest end at the side
        return std::max((r - 1) * 4 + thinner, std::max(floating, (back - from) * 40));
      };
    };
  };
  const Vec3 low{-170, -130, -60}, high{170, 90, kEndless};
  paint(anatomy, low, high, kCortex - 200, 92, rib(0, 2));
  paint(anatomy, low, high, 180, 92, rib(1.6f, 2));
  paint(anatomy, low, high, kCartilage, 117, rib(0, -0.82f));
}

void paint_sternum(Anatomy& anatomy, const Trunk& trunk) {
  const float y = trunk.center - trunk.half_depth(100) + trunk.fat + 14;
  paint_ellipsoid(anatomy, {0, y, 100}, {34, 7, 86}, kCartilage, 117);
  paint_bone_ellipsoid(anatomy, {0, y, 112}, {19, 6.5f, 78}, 1.8f, 116);
}

void paint_pelvis(Anatomy& anatomy) {
  paint_bone_ellipsoid(anatomy, {0, 44, -138}, {44, 16, 34}, 2, 25);
  for (const float side : {-1.0f, 1.0f}) {
    const Vec3 center{side * 62, -8, -152}, radius{62, 72, 74};
    const std::uint16_t label = side < 0 ? 78 : 77;
    const auto wing = [=](float thinner) {  // section of a shell, open to the front and to the middle
      return [=](float y, float z) {
        return [=](float x) {
          const float shell =
              std::abs(ellipsoid_distance({x - center.x, y - center.y, z - center.z}, radius)) - 5.5f;
          const float middle = 46 - side * x, front = -46 - y - 0.5f * (z + 78);
          return std::max(shell, std::max(middle, front)) + thinner;
        };
      };
    };
    const Vec3 low{center.x - 72, -90, -kEndless}, high{center.x + 72, 76, -70};
    paint(anatomy, low, high, kCortex, label, wing(0));
    paint(anatomy, low, high, kMarrow, label, wing(2));
    paint_bone_ellipsoid(anatomy, {side * 88, -6, -160}, {24, 24, 24}, 2, std::uint16_t(side < 0 ? 76 : 75));
  }
}

void paint_muscles(Anatomy& anatomy, const Trunk& trunk) {
  for (const float side : {-1.0f, 1.0f}) {
    paint_capsule(anatomy, {side * 34, 30, 10}, {side * 54, -6, -150}, 16, kMuscle,
                  std::uint16_t(side < 0 ? 89 : 88));
    paint(anatomy, {side * 36 - 36, 26, -kEndless}, {side * 36 + 36, 80, kEndless}, kMuscle,
          std::uint16_t(side < 0 ? 87 : 86), [=](float y, float z) {
            const float width = trunk.half_width(z) - 7, depth = trunk.half_depth(z) - 7;
            return [=](float x) {
              return std::max(trunk_distance(x, y - trunk.center, width, depth),
                              ellipsoid_distance({x - side * 34, y - 50, 0}, {29, 18, 1e6f}));
            };
          });
  }
}

}  // namespace

Anatomy make_torso(std::uint64_t seed) {
  Trunk trunk;
  trunk.fat = 16 + 2 * variation(seed, 1);
  Anatomy anatomy;
  paint_table(anatomy, 98, 194);
  paint_layers(anatomy, trunk);
  paint_muscles(anatomy, trunk);
  paint_lungs(anatomy, trunk);
  paint_chest(anatomy);
  paint_belly(anatomy, seed);
  paint_liver(anatomy, trunk, seed);
  paint_pelvis(anatomy);
  paint_spine(anatomy);
  paint_ribs(anatomy, trunk);
  paint_sternum(anatomy, trunk);
  return anatomy;
}

}  // namespace turgor::phantom
