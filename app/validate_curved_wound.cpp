// Cuts in tense skin that is curved, and cuts along curves, in lattices of any direction.
#include "app/validate_curved_wound.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "app/curved_wound.hpp"
#include "turgor/models/lattice/build/turned_block.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor {

namespace {

using lattice::BodyNodes;
using lattice::Model;
using lattice::Params;

/// A hundredth of the default tension, and skin without stiffening: lips move so little that the laws are
/// linear.
constexpr double kTension = 0.45;

Params params_of_cut(Vec3d direction) {
  Params params;
  params.tissue.law = lattice::TissueLaw::kSolid;
  params.skin.tension_along = params.skin.tension_across = kTension;
  params.skin.amplification = 0;
  params.skin.direction = direction;
  params.solver = {.sweeps = 20, .damping = 4};
  return params;
}

/// Straight cut of 30 mm, 8 mm deep, in a slab.
CurvedWound flat_wound() {
  const lattice::SkinParams skin;
  return {.height = [](double, double) { return 0.0; },
          .curve = [](double) { return 0.0; },
          .half_x = 0.036,
          .half_y = 0.03,
          .thickness = 0.02,
          .half_length = 0.015,
          .depth = 0.008,
          .young = 5e3,
          .poisson = lattice::TissueParams{}.poisson,
          .tension = kTension,
          .stiffness = skin.stiffness,
          .shear = skin.shear};
}

struct NamedWound {
  const char* name;
  CurvedWound wound;
  double finest = 0.004;  // spacing [m]
};

std::vector<NamedWound> wounds() {
  const CurvedWound flat = flat_wound();
  CurvedWound arc = flat, s = flat, along = flat, across = flat, ellipsoid = flat;
  // arc of a circle of 25 mm, 5 mm high; its ends go on along their tangents and bend back
  arc.curve = [half = flat.half_length](double x) {
    constexpr double kRadius = 0.025, kFade = 0.006;
    const double within = std::min(std::abs(x), half), end = std::sqrt(kRadius * kRadius - half * half),
                 beyond = std::abs(x) - within;
    return std::sqrt(kRadius * kRadius - within * within) - kRadius -
           (beyond > 0 ? half / end * kFade * (1 - std::exp(-beyond / kFade)) : 0) + 0.0025;
  };
  s.curve = [half = flat.half_length](double x) {
    constexpr double kHeight = 0.004, kFade = 0.006;
    const double within = std::clamp(x, -half, half), beyond = std::abs(x) - std::abs(within);
    const double slope = kHeight * std::numbers::pi / half * -1;
    return kHeight * std::sin(std::numbers::pi * within / half) +
           (beyond > 0 ? std::copysign(slope * kFade * (1 - std::exp(-beyond / kFade)), x) : 0);
  };
  constexpr double kRadius = 0.04;
  along.height = [](double, double y) { return std::sqrt(kRadius * kRadius - y * y) - kRadius; };
  across.height = [](double x, double) { return std::sqrt(kRadius * kRadius - x * x) - kRadius; };
  across.half_x = 0.03;
  // semi-axes of 80, 65 and 55 mm, turned by 25 degrees below the cut
  ellipsoid.height = [](double x, double y) {
    const double c = std::cos(25 * std::numbers::pi / 180), t = std::sin(25 * std::numbers::pi / 180),
                 p = (c * x + t * y) / 0.08, q = (c * y - t * x) / 0.065;
    return 0.055 * (std::sqrt(1 - p * p - q * q) - 1);
  };
  return {{"straight in a slab", flat, 0.003}, {"an arc in a slab", arc, 0.003},
          {"an S in a slab", s, 0.003},        {"along a cylinder", along, 0.003},
          {"across a cylinder", across},       {"in an ellipsoid", ellipsoid}};
}

/// Nodes of the body in a lattice that is turned by a rotation: those below its skin by `lowered`.
BodyNodes nodes_of(const CurvedWound& wound, const Mat3d& rotation, double spacing, double lowered) {
  // box around the body and its rim of fixed nodes
  const double rim = 2.2 * spacing, x_reach = wound.half_x + rim, y_reach = wound.half_y + rim;
  double lowest = 0, highest = -1;
  for (int i = -20; i <= 20; i++)
    for (int j = -20; j <= 20; j++) {
      const double z = wound.height(x_reach * i / 20, y_reach * j / 20);
      lowest = std::min(lowest, z - wound.thickness - rim), highest = std::max(highest, z + spacing);
    }
  Vec3d low, high;
  for (int c = 0; c < 8; c++) {
    const Vec3d x =
        rotation * Vec3d{c & 1 ? x_reach : -x_reach, c & 2 ? y_reach : -y_reach, c & 4 ? highest : lowest};
    low = min(low, x), high = max(high, x);
  }
  BodyNodes nodes;
  nodes.grid.spacing = {spacing, spacing, spacing};
  for (int axis = 0; axis < 3; axis++) {
    const double first = std::floor(low[axis] / spacing) - 2;
    nodes.grid.origin[axis] = first * spacing;
    nodes.grid.size[axis] = int(std::ceil(high[axis] / spacing) - first) + 3;
  }
  // nodes
  constexpr double kTolerance = 1e-6;
  const Int3 size = nodes.grid.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const Vec3d x = transposed(rotation) * point_at(nodes.grid, Vec3d{double(i), double(j), double(k)});
        const bool inside = std::abs(x.x) < x_reach && std::abs(x.y) < y_reach;
        const double depth = inside ? wound.height(x.x, x.y) - x.z : -1;
        const bool is_body = inside && depth > lowered - kTolerance && depth < wound.thickness + rim;
        const bool is_held = std::abs(x.x) > wound.half_x - kTolerance ||
                             std::abs(x.y) > wound.half_y - kTolerance ||
                             depth > wound.thickness - kTolerance;
        nodes.hu.push_back(is_body ? 0 : kAirHu);
        nodes.tissue.push_back(is_body ? lattice::Tissue::kMuscle : lattice::Tissue::kOutside);
        nodes.young.push_back(is_body ? float(wound.young) : 0);
        nodes.fixed.push_back(is_body && is_held);
      }
  return nodes;
}

/// Mean height of the skin's nodes over the skin of the body [m].
double mean_height(const CurvedWound& wound, const Mat3d& rotation, const Model& model) {
  double sum = 0;
  int count = 0;
  for (const lattice::SkinTriangle& t : model.anatomy.skin.triangles)
    for (int c = 0; c < 3; c++) {
      const Int3 node = slot_node(model.anatomy.lattice, t.vertex[c]);
      const Vec3d x = transposed(rotation) * point_at(model.anatomy.grid, Vec3d(node));
      if (std::abs(x.x) > 0.7 * wound.half_x || std::abs(x.y) > 0.7 * wound.half_y) continue;
      const double height = x.z - wound.height(x.x, x.y);
      if (height > -wound.thickness / 2) sum += height, count++;
    }
  TURGOR_CHECK(count > 0, "a mean is over at least one node");
  return sum / count;
}

/// Gape at rest in a lattice whose skin lies at a mean height of 0 over that of the wound [m].
Gape gape_of_lattice(const Exec& exec, const CurvedWound& wound, const Mat3d& rotation, double spacing) {
  const Params params = params_of_cut(rotation.column[0]);
  const auto model_of = [&](double lowered) {
    return assemble(Exec(1), nodes_of(wound, rotation, spacing, lowered), nullptr, params).value();
  };
  const Model model = model_of(mean_height(wound, rotation, model_of(0)));
  lattice::State state = make_state(model);
  // blade, a third of a spacing off the center
  const Vec3d off = rotation.column[1] * (0.37 * spacing);
  lattice::Incision blade{.depth = wound.depth};
  constexpr int kPoints = 16;
  for (int n = 0; n <= kPoints; n++) {
    const double x = wound.half_length * (2.0 * n / kPoints - 1), y = wound.curve(x);
    blade.path.push_back(rotation * Vec3d{x, y, wound.height(x, y)} + off);
  }
  blade.from = blade.path.front(), blade.to = blade.path.back();
  if (wound.curve(0.7 * wound.half_length) == 0) blade.path.clear();
  const lattice::BladePath path = lay_blade(model, state, blade).value();
  cut_edges(model, state, path, 0, 1, 0);
  for (int n = 0; n < 120; n++) lattice::step(exec, model, state, {}, 1.0 / 30);
  const lattice::Wound found = measure_wound(model, state, path, 0);
  Gape gape{found.gape_max, 0};
  double nearest = 1;
  for (const lattice::GapePoint& p : found.profile)
    if (const double away = std::abs(p.along - found.length / 2); away < nearest)
      nearest = away, gape.middle = p.gape;
  return gape;
}

}  // namespace

void add_curved_wounds(const Exec& exec, std::vector<Figure>& figures) {
  const Mat3d straight = lattice::rotation_about({0, 0, 1}, 0),
              turned = lattice::rotation_about({1, 0.6, 0.3}, 17);
  for (const NamedWound& w : wounds()) {
    const Gape limit = limit_of_linear_elements(w.wound, 6, 8);
    for (const double spacing : {0.004, 0.003})
      for (const bool is_turned : {false, true}) {
        if (spacing < w.finest) continue;
        const Gape found = gape_of_lattice(exec, w.wound, is_turned ? turned : straight, spacing);
        figures.push_back(near_figure(fmt::format("cut {}, spacing {:.0f} mm{}", w.name, 1e3 * spacing,
                                                  is_turned ? ", lattice turned by 17 degrees" : ""),
                                      fmt::format("linear finite elements, {:.3f} mm", 1e3 * limit.largest),
                                      found.largest, limit.largest, 0.15));
      }
  }
}

}  // namespace turgor
