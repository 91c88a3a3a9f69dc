#include "turgor/sim/report/measures.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace turgor {

namespace {

/// The skin around a place at rest: its normal, smooth over the steps of the lattice, and Langer's lines.
struct SkinAround {
  Vec3d normal, lines;  // lattice frame, not unit
};

/// Within `reach`, the nearer triangles more.
SkinAround skin_around(const lattice::Model& model, Vec3d point, double reach) {
  SkinAround around;
  const Vec3d everywhere = inverse(model.grid.axes) * model.params.skin.direction;
  for (std::size_t t = 0; t < model.skin.triangles.size(); t++) {
    const lattice::SkinTriangle& triangle = model.skin.triangles[t];
    const Vec3d a(rest_position(model.lattice, slot_node(model.lattice, triangle.vertex.x)));
    const Vec3d e1(triangle.edge1), e2(triangle.edge2);
    const Vec3d away = a + (e1 + e2) / 3 - point;
    const double weight = 1 - dot(away, away) / (reach * reach);
    if (weight <= 0) continue;
    const Vec3d line = model.skin.lines.empty() ? everywhere : Vec3d(model.skin.lines[t]);
    around.normal += cross(e1, e2) * weight;
    around.lines += line * (dot(line, around.lines) < 0 ? -weight : weight);  // a line has no sign
  }
  return around;
}

/// Cosine of the angle between the blade's path and Langer's lines, both in the skin's tangent plane; none
/// where there is no skin, or lines straight into it.
std::optional<double> cosine_to_lines(const SkinAround& skin, Vec3d across) {
  const Vec3d path = cross(across, skin.normal);
  const Vec3d lines = cross(cross(skin.normal, skin.lines), skin.normal);
  const double size = norm(path) * norm(lines);
  if (!(size > 0)) return std::nullopt;
  return dot(path, lines) / size;
}

/// cos² of the angle between a cut and the lines, the mean along it: blind to the sign that a line does not
/// have.
std::optional<double> share_along_lines(const lattice::Model& model, const lattice::BladePath& path) {
  const Vec3 step = model.lattice.step;
  const double reach = std::max(0.01, 3.0 * std::max({step.x, step.y, step.z}));
  double sum = 0, count = 0;
  for (std::size_t n = 0; n < path.skin.size(); n++)
    if (const auto cosine = cosine_to_lines(skin_around(model, path.skin[n], reach), across_at(path, n)))
      sum += *cosine * *cosine, count++;
  if (count == 0) return std::nullopt;
  return std::clamp(sum / count, 0.0, 1.0);
}

WoundSample sample_of(const lattice::Wound& wound, double time) {
  return {time, wound.gape_max, wound.gape_mean, wound.opening_area, wound.edge_displacement};
}

}  // namespace

SkinPull skin_pull(const lattice::Model& model, const lattice::BladePath& path) {
  const lattice::SkinParams& skin = model.params.skin;
  const std::optional<double> share = share_along_lines(model, path);
  if (!share) return {};
  const double along = *share;
  SkinPull pull;
  pull.angle = std::acos(std::sqrt(along)) * 180 / std::numbers::pi;
  if (skin.law == lattice::SkinLaw::kArea) {
    pull.opening = pull.lengthwise = 0.5 * (skin.tension_along + skin.tension_across);
  } else {
    pull.opening = skin.tension_across * along + skin.tension_along * (1 - along);
    pull.lengthwise = skin.tension_along * along + skin.tension_across * (1 - along);
  }
  return pull;
}

Measures make_measures(const World& world) {
  Measures measures;
  measures.pressed = make_pressed(world);
  for (const Cut& cut : world.cuts) {
    CutMeasures m;
    m.name = cut.blade.name, m.body = world.lattice_bodies[std::size_t(cut.body)].name;
    m.region = cut.blade.width > 0, m.depth = cut.blade.depth, m.width = cut.blade.width;
    measures.cuts.push_back(m);
  }
  return measures;
}

void measure_frame(const Exec& exec, const World& world, const FrameReport& frame, bool snapshot,
                   Measures& measures) {
  measures.frame_seconds.push_back(frame.seconds);
  look_at_pressed(exec, world, measures.pressed);
  for (std::size_t c = 0; c < world.cuts.size(); c++) {
    const Cut& cut = world.cuts[c];
    if (!cut.path) continue;
    const LatticeBody& body = world.lattice_bodies[std::size_t(cut.body)];
    CutMeasures& m = measures.cuts[c];
    if (m.series.empty()) m.pull = skin_pull(body.model, *cut.path);
    m.edges = cut.edges;
    measures.near_cuts.resize(world.lattice_bodies.size());
    lattice::BodySurface& near = measures.near_cuts[std::size_t(cut.body)];
    const lattice::State& cuts = body.state.without_places();
    if (near.pieces.version != body.state.cuts())
      near = build_surface(body.model, cuts, &body.ct, lattice::Extent::kCuts);
    std::vector<int> nodes;
    if (body.state.is_on_device()) nodes = nodes_beside(body.model, cuts, near, *cut.path, int(c));
    m.wound = body.state.read_wound_nodes(nodes, [&](const lattice::State& state) {
      return lattice::measure_wound(body.model, state, near, *cut.path, int(c));
    });
    m.series.push_back(sample_of(m.wound, time_of(world)));
  }
  if (!snapshot) return;
  SolverSample sample{time_of(world), frame.residual, 0, frame.largest_speed};
  for (const LatticeBody& body : world.lattice_bodies)
    if (body.model.params.solver.method == lattice::Method::kVbd)  // the other has no energy in joules
      sample.energy += lattice::energy(exec, body.model, body.state);
  measures.solver.push_back(sample);
}

}  // namespace turgor
