// Rhombus chains against formulas of the half space, and against finite element bodies with the same surface.
// Presses and pulls are at points and on meshes that were not used for any fit.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "app/pressed_block.hpp"
#include "app/validation.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/phantom_liver.hpp"
#include "turgor/models/rhombus/half_space.hpp"
#include "turgor/models/rhombus/tissues.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/sim/bodies/rhombus/elastic_stiffness.hpp"

namespace turgor {

namespace {

using rhombus::Chain;
using rhombus::Tissue;

/// Largest relative difference of presses from Sneddon's sphere, over all tissues and over radii and depths
/// outside the fit.
double press_error(double deepest) {
  double worst = 0;
  for (const Tissue& tissue : rhombus::tissues()) {
    if (tissue.young == 0) continue;
    const Chain chain = *rhombus::build_chain(tissue.chain);
    const double modulus = rhombus::contact_modulus(tissue.young, 0.5);
    for (const double radius : {1e-4, 3e-4, 0.001, 0.0023, 0.0071, 0.015, 0.05})
      for (double fraction = 0.003; fraction < deepest; fraction *= 1.13) {
        const double expected = rhombus::sneddon_force(modulus, radius, fraction * radius);
        const double found = rhombus::force_of_tip(chain, rhombus::tip_on(chain, radius), fraction * radius);
        worst = widest(worst, std::abs(found / expected - 1));
      }
  }
  return worst;
}

/// Largest relative difference of pulls from a disc on a half space, up to `farthest` radii.
double pull_error(double farthest) {
  double worst = 0;
  const Chain chain = *rhombus::build_chain(rhombus::chain_of_modulus(4e3));
  for (const double radius : {0.0017, 0.006, 0.012})
    for (double fraction = 0.01; fraction <= farthest; fraction += 0.03) {
      const double disc =
          rhombus::disc_stiffness(rhombus::contact_modulus(4e3, 0.5), radius) * fraction * radius;
      const double found = -rhombus::force_of_tip(chain, rhombus::tip_on(chain, radius), -fraction * radius);
      worst = widest(worst, std::abs(found / disc - 1));
    }
  return worst;
}

/// Largest K / (K(0) + b F) of all tissues, pressed and pulled up to 50 N.
double growth_share() {
  double worst = 0;
  for (const Tissue& tissue : rhombus::tissues()) {
    const Chain chain = *rhombus::build_chain(tissue.chain);
    const double soft = 1 / rhombus::depth_of_force(chain, 0).compliance;
    for (double force = -50; force < 50; force += 0.013)
      worst = widest(worst, 1 / rhombus::depth_of_force(chain, force).compliance /
                                (soft + rhombus::growth_bound(chain) * std::abs(force)));
  }
  return worst;
}

/// Largest force [N] and slope [N/m] of random grasps of the phantom liver.
struct Grasped {
  double force = 0, slope = 0;
};
Grasped random_grasps(int count) {
  const TriMesh mesh = phantom_liver();
  rhombus::Body body{.vertices = {}, .triangles = mesh.triangles, .stiffness = {}};
  for (const Vec3 x : mesh.vertices) body.vertices.push_back(Vec3d(x));
  const rhombus::Model model = *rhombus::build(std::move(body), {.chain = rhombus::tissues()[0].chain});
  rhombus::State state = rhombus::make_state(model, 1);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1), sign(-1, 1);
  Grasped most;
  for (int n = 0; n < count; n++) {
    state.touches[0] = {};
    const auto v = std::size_t(unit(random) * double(model.surface.vertices.size() - 1));
    const Vec3d normal = model.surface.normals[v];
    rhombus::TouchInput in{.radius = 0.002 + 0.01 * unit(random), .opening = 0.01};
    in.position = model.surface.vertices[v] + normal * (in.radius - 0.001 - 0.01 * unit(random));
    const auto tick = [&] {
      rhombus::TouchForce force;
      rhombus::solve_touches(model, state, {&in, 1}, 1e-3, {&force, 1});
      return force;
    };
    tick();
    in.grip = 1;
    tick();
    const Vec3d displacement =
        normal * (0.06 * unit(random)) + Vec3d{sign(random), sign(random), sign(random)} * 0.02;
    in.position += displacement;
    const rhombus::TouchForce first = tick();
    in.position += normalized(displacement) * 1e-5;
    const rhombus::TouchForce second = tick();
    most.force = widest(widest(most.force, norm(first.force)), norm(second.force));
    if (!first.slipped && !second.slipped)
      most.slope = widest(most.slope, norm(second.force - first.force) / 1e-5);
  }
  return most;
}

// ------------------------------------------------------------ elements

struct Elements {
  const char* name;
  SolidMesh mesh;
  std::function<bool(Vec3d)> is_fixed;
  Vec3d size;       // [m]
  double cell = 0;  // [m]
  double poisson = 0.45;
  bool sticks_out = false;  // a chain without the body's stiffness is known to be wrong
};

/// Force of the chain relative to the elements, pressed and pulled: least and most over points. `uneven`: the
/// same presses without the stiffness of the body.
struct Ratios {
  double pressed[2] = {INFINITY, 0}, pulled[2] = {INFINITY, 0}, uneven[2] = {INFINITY, 0};
};
void widen(double (&range)[2], double ratio) {
  range[0] = narrowest(range[0], ratio), range[1] = widest(range[1], ratio);
}

/// Force of the elements when the vertices around a point move along z together by 1 m [N], and the radius of
/// the disc that these vertices form [m].
struct PulledDisc {
  double stiffness = 0, radius = 0;
};
PulledDisc pulled_disc(const sfem::Model& model, Vec3d point, double radius, double cell) {
  std::vector<int> vertices;
  for (std::size_t v = 0; v < model.body.mesh.vertices.size(); v++) {
    const Vec3d away = model.body.mesh.vertices[v] - point;
    if (std::abs(away.z) < 1e-6 && norm(away) < radius) vertices.push_back(int(v));
  }
  const auto n = Eigen::Index(3 * vertices.size());
  Eigen::MatrixXd green(n, n);
  sfem::gather_green(model, vertices, green.data());
  Eigen::VectorXd up(n);
  for (Eigen::Index i = 0; i < n; i++) up[i] = i % 3 == 2;
  return {up.dot(green.ldlt().solve(up)), cell * std::sqrt(double(vertices.size()) / std::numbers::pi)};
}

/// The same chain, scaled to another ball.
rhombus::ChainParams chain_for_tip(double young, double radius) {
  rhombus::ChainParams chain = rhombus::chain_of_modulus(young);
  const double scale = radius / chain.tip;
  chain.normal *= scale, chain.tangential *= scale, chain.side *= scale, chain.tip = radius;
  return chain;
}

Result<Ratios> compare(const Exec& exec, const Elements& e) {
  constexpr double kYoung = 3e3;
  sfem::Params params;
  params.touch_depth = 4 * e.cell;
  Result<sfem::Model> elements = solved(exec, held(e.mesh, {kYoung, e.poisson}, e.is_fixed), params);
  if (!elements) return elements.error();
  const double modulus = rhombus::contact_modulus(kYoung, e.poisson);
  const SolidBoundary outer = solid_boundary(*elements);
  rhombus::Body body = outer.body;
  const double radius = 1.7 * e.cell, depth = 0.3 * radius;
  const rhombus::Params chains{.chain = chain_for_tip(0.75 * modulus, radius)};
  Result<rhombus::Model> even = rhombus::build(body, chains);
  if (!even) return even.error();
  Result<std::vector<double>> stiffness =
      elastic_stiffness(exec, *elements, outer, even->surface, usual_contact(radius));
  if (!stiffness) return stiffness.error();
  body.stiffness = *stiffness;
  const rhombus::Model model = *rhombus::build(std::move(body), chains);
  Ratios ratios;
  for (const auto& [across, along] :
       {std::pair{0.5, 0.5}, {0.25, 0.5}, {0.75, 0.375}, {0.375, 0.25}, {0.75, 0.75}}) {
    const Vec3d point{across * e.size.x, along * e.size.y, e.size.z};
    const double pressed =
        press(patch_at(exec, *elements, point, {1.7 * radius, 3}), point, radius, depth, 8).back().second;
    rhombus::State state = rhombus::make_state(model, 1);
    rhombus::TouchInput in{.position = point + Vec3d{0, 0, radius - depth}, .radius = radius};
    rhombus::TouchForce touch;
    rhombus::solve_touches(model, state, {&in, 1}, 1e-3, {&touch, 1});
    const rhombus::FootPoint foot = rhombus::find_foot_point(model.surface, model.tree, point);
    const double local_stiffness = rhombus::stiffness_at(model, foot.at);
    widen(ratios.pressed, touch.force.z / pressed),
        widen(ratios.uneven, touch.force.z / local_stiffness / pressed);
    const PulledDisc disc = pulled_disc(*elements, point, radius, e.cell);
    const double pull = 0.5 * disc.radius;
    const double chain =
        -rhombus::force_of_tip(model.chain, rhombus::tip_on(model.chain, disc.radius), -pull);
    widen(ratios.pulled, local_stiffness * chain / (disc.stiffness * pull));
  }
  return ratios;
}

/// A wedge that extends beyond its support: 15 to 45 mm thick.
SolidMesh wedge() {
  SolidMesh mesh = hex_block({0.096, 0.096, 1}, {16, 16, 6});
  for (Vec3d& x : mesh.vertices) x.z = 0.045 - (1 - x.z) * (0.045 - 0.03 * x.x / 0.096);
  return tetrahedralize(mesh);
}

std::vector<Elements> bodies_of_elements(bool quick) {
  const auto is_bottom = [](Vec3d x) { return x.z < 1e-9; };
  const int divisions = quick ? 12 : 16;
  std::vector<Elements> all;
  all.push_back({"a block",
                 hex_block({0.08, 0.08, 0.04}, {divisions, divisions, divisions / 2}),
                 is_bottom,
                 {0.08, 0.08, 0.04},
                 0.08 / divisions});
  all.push_back({"the block doubled",
                 hex_block({0.16, 0.16, 0.08}, {divisions, divisions, divisions / 2}),
                 is_bottom,
                 {0.16, 0.16, 0.08},
                 0.16 / divisions});
  all.push_back({"a wedge of tetrahedra",
                 wedge(),
                 [](Vec3d x) { return x.x < 1e-9; },
                 {0.096, 0.096, 0.045},
                 0.006,
                 0.3,
                 true});
  return all;
}

}  // namespace

std::vector<Figure> validate_rhombus(const Exec& exec, bool quick) {
  std::vector<Figure> figures{
      most_figure("presses of balls of 0.1 to 50 mm, 1/300 to 6 radii deep", "Sneddon's sphere", "relative",
                  press_error(rhombus::kDeepestPress), 0.10),
      most_figure("presses of balls up to 1/20 of a radius deep", "Sneddon's sphere", "relative",
                  press_error(0.05), 0.03),
      most_figure("pulls to a strain of 30 %", "a disc on a half space", "relative",
                  pull_error(rhombus::kPulledRadii), 0.10),
      most_figure("stiffness up to 50 N, relative to the growth bound", "K(0) + b F", "1", growth_share(),
                  1 + 1e-9)};
  const Grasped grasped = random_grasps(quick ? 20000 : 100000);
  figures.push_back(most_figure("random grasps: force", "tear", "N", grasped.force, 50));
  figures.push_back(most_figure("random grasps: slope", "finite", "N/m", grasped.slope, 1e5));
  for (const Elements& e : bodies_of_elements(quick)) {
    const Result<Ratios> r = compare(exec, e);
    const Ratios found = r ? *r : Ratios{};
    const auto add = [&](const std::string& what, double ratio, double low, double high, bool limit) {
      figures.push_back({what + " on " + e.name, "sfem", "of the elements", ratio, low, high, limit});
    };
    add("pressed, least over points,", found.pressed[0], 0.7, 1.15, false);
    add("pressed, most over points,", found.pressed[1], 0.7, 1.15, false);
    add("pulled, least over points,", found.pulled[0], 0.9, 1.15, false);
    add("pulled, most over points,", found.pulled[1], 0.9, 1.15, false);
    if (e.sticks_out)
      add("pressed, without the body's stiffness, most over points,", found.uneven[1], 0.7, 1.15, true);
  }
  return figures;
}

}  // namespace turgor
