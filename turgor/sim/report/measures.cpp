#include "turgor/sim/report/measures.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace turgor {

namespace {

/// Cosine of the angle between a direction, laid into a triangle of the CT, and Langer's lines there.
double cosine_to_lines(const lattice::Model& model, const lattice::SkinTriangle& triangle, Vec3d direction) {
  Vec3d along, across;  // unit, lattice frame
  for (int q = 0; q < 3; q++) {
    const Vec3d corner(rest_position(model.lattice, slot_node(model.lattice, triangle.vertex[q])));
    along += corner * double(triangle.along[q]);
    across += corner * double(triangle.across[q]);
  }
  const double c = dot(direction, along), s = dot(direction, across), length = std::hypot(c, s);
  return length > 0 ? c / length : 0;
}

bool is_near(const lattice::BladePath& path, Vec3d point, double distance) {
  return std::any_of(path.skin.begin(), path.skin.end(), [&](Vec3d p) { return norm(p - point) < distance; });
}

WoundSample sample_of(const lattice::Wound& wound, double time) {
  return {time, wound.gape_max, wound.gape_mean, wound.opening_area, wound.edge_displacement};
}

}  // namespace

SkinPull skin_pull(const lattice::Model& model, const lattice::BladePath& path) {
  const lattice::SkinParams& skin = model.params.skin;
  const Vec3d cut = normalized(path.skin.back() - path.skin.front());
  const Vec3 step = model.lattice.step;
  const double reach = 2 * std::max({step.x, step.y, step.z});
  // cos² of the angle between cut and lines, weighted by area: blind to the sign that a line does not have.
  double weighted = 0, area = 0;
  for (const lattice::SkinTriangle& triangle : model.skin.triangles) {
    const Vec3d corner(rest_position(model.lattice, slot_node(model.lattice, triangle.vertex.x)));
    if (!is_near(path, corner, reach)) continue;
    const double cosine = cosine_to_lines(model, triangle, cut);
    weighted += triangle.area * cosine * cosine;
    area += triangle.area;
  }
  if (!(area > 0)) return {};
  const double along = std::clamp(weighted / area, 0.0, 1.0);
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
  for (const Cut& cut : world.cuts) {
    CutMeasures m;
    m.name = cut.blade.name, m.body = world.lattices[std::size_t(cut.body)].name;
    m.region = cut.blade.width > 0, m.depth = cut.blade.depth, m.width = cut.blade.width;
    measures.cuts.push_back(m);
  }
  return measures;
}

void measure_frame(const Exec& exec, const World& world, const FrameReport& frame, bool snapshot,
                   Measures& measures) {
  measures.frame_seconds.push_back(frame.seconds);
  for (std::size_t c = 0; c < world.cuts.size(); c++) {
    const Cut& cut = world.cuts[c];
    if (!cut.path) continue;
    const LatticeBody& body = world.lattices[std::size_t(cut.body)];
    CutMeasures& m = measures.cuts[c];
    if (m.series.empty()) m.pull = skin_pull(body.model, *cut.path);
    m.edges = cut.edges;
    m.wound = lattice::measure_wound(body.model, body.state, *cut.path, int(c));
    m.series.push_back(sample_of(m.wound, time_of(world)));
  }
  if (!snapshot) return;
  SolverSample sample{time_of(world), frame.residual, 0, frame.largest_speed};
  for (const LatticeBody& body : world.lattices)
    if (body.model.params.solver.method == lattice::Method::kDescent)  // the other has no energy in joules
      sample.energy += lattice::energy(exec, body.model, body.state);
  measures.solver.push_back(sample);
}

}  // namespace turgor
