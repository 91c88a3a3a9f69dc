#include "turgor/sim/report/measures.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/sim/report/gape_error.hpp"

namespace turgor {

namespace {

/// Mean normal of the skin at rest and mean direction of Langer's lines, near a point.
struct AverageSkin {
  Vec3d normal, lines;  // lattice frame, not unit
};

/// Mean over the skin within `reach`, weighted by 1 − d²/reach².
AverageSkin average_skin(const lattice::Model& model, Vec3d point, double reach) {
  AverageSkin around;
  TURGOR_CHECK(reach > 0, "a mean is over an area");
  const Vec3d everywhere = inverse(model.anatomy.grid.axes) * model.params.skin.direction;
  for (std::size_t t = 0; t < model.anatomy.skin.triangles.size(); t++) {
    const lattice::SkinTriangle& triangle = model.anatomy.skin.triangles[t];
    const Vec3d a(rest_position(model.anatomy.lattice, slot_node(model.anatomy.lattice, triangle.vertex.x)));
    const Vec3d e1(triangle.edge1), e2(triangle.edge2);
    const Vec3d away = a + (e1 + e2) / 3 - point;
    const double weight = 1 - dot(away, away) / (reach * reach);
    if (weight <= 0) continue;
    const Vec3d line = model.anatomy.skin.lines.empty() ? everywhere : Vec3d(model.anatomy.skin.lines[t]);
    around.normal += cross(e1, e2) * weight;
    around.lines += line * (dot(line, around.lines) < 0 ? -weight : weight);  // lines have no sign
  }
  return around;
}

/// Cosine of the angle between the blade's path and Langer's lines, both projected on the skin's tangent
/// plane. Empty without skin, or if the lines are normal to it.
std::optional<double> cosine_to_lines(const AverageSkin& skin, Vec3d across) {
  const Vec3d path = cross(across, skin.normal);
  const Vec3d lines = cross(cross(skin.normal, skin.lines), skin.normal);
  const double size = norm(path) * norm(lines);
  if (!(size > 0)) return std::nullopt;
  return dot(path, lines) / size;
}

/// Mean along a cut of cos² of the angle to Langer's lines; independent of the sign of the lines.
std::optional<double> mean_cos2_to_lines(const lattice::Model& model, const lattice::BladePath& path) {
  const Vec3 step = model.anatomy.lattice.spacing;
  const double reach = std::max(0.01, 3.0 * std::max({step.x, step.y, step.z}));
  double sum = 0, count = 0;
  for (std::size_t n = 0; n < path.points.size(); n++)
    if (const auto cosine = cosine_to_lines(average_skin(model, path.points[n], reach), across_at(path, n)))
      sum += *cosine * *cosine, count++;
  if (count == 0) return std::nullopt;
  return std::clamp(sum / count, 0.0, 1.0);
}

/// Largest height of the skin within half a width of each end of an excised wound.
DogEars dog_ears_of(const LatticeBody& body, const lattice::BladePath& path) {
  const lattice::EndHeights heights = lattice::heights_at_ends(body.model, *body.state, path);
  return {heights.first, heights.last};
}

WoundSample sample_of(const lattice::Wound& wound, double time) {
  return {time, wound.gape_max, wound.gape_mean, wound.opening_area, wound.edge_displacement};
}

/// Cuts and sutures that requests have added or removed since the last frame.
void follow_requests(const World& world, Measures& measures) {
  if (measures.cuts.size() > world.cuts.size()) measures.cuts.resize(world.cuts.size());
  while (measures.cuts.size() < world.cuts.size()) {
    const Cut& cut = world.cuts[measures.cuts.size()];
    TURGOR_CHECK(is_index(cut.body, world.lattice_bodies.size()), "a cut belongs to a lattice");
    CutMeasures m;
    m.name = cut.blade.name, m.body = world.lattice_bodies[std::size_t(cut.body)].name;
    m.region = cut.blade.width > 0, m.excision = cut.blade.excision.has_value(), m.depth = cut.blade.depth,
    m.width = cut.blade.width;
    m.undermined = cut.blade.undermine;
    measures.cuts.push_back(m);
  }
  if (measures.sutures.size() > world.sutures.size()) measures.sutures.resize(world.sutures.size());
  while (measures.sutures.size() < world.sutures.size())
    measures.sutures.push_back(make_suture_measures(world, world.sutures[measures.sutures.size()]));
}

}  // namespace

CutTension cut_tension(const lattice::Model& model, const lattice::BladePath& path) {
  const lattice::SkinParams& skin = model.params.skin;

  // angle to Langer's lines
  const std::optional<double> along_lines = mean_cos2_to_lines(model, path);
  if (!along_lines) return {};
  const double along = *along_lines;
  CutTension tension;
  tension.angle = std::acos(std::sqrt(along)) * 180 / std::numbers::pi;

  // tension in directions of the cut
  tension.is_directional = skin.law != lattice::SkinLaw::kArea && skin.tension_along != skin.tension_across;
  if (skin.law == lattice::SkinLaw::kArea) {
    tension.opening = tension.lengthwise = 0.5 * (skin.tension_along + skin.tension_across);
  } else {
    tension.opening = skin.tension_across * along + skin.tension_along * (1 - along);
    tension.lengthwise = skin.tension_along * along + skin.tension_across * (1 - along);
  }
  return tension;
}

double expected_gape_error(const lattice::Model& model, double depth) {
  constexpr double kFactor = 0.94, kLargestRatio = 0.5;
  const Vec3 spacing = model.anatomy.lattice.spacing;
  const double ratio = double(std::max({spacing.x, spacing.y, spacing.z})) / depth;
  if (model.params.tissue.law != lattice::TissueLaw::kSolid || !(ratio <= kLargestRatio)) return -1;
  return kFactor * ratio * ratio;
}

Measures make_measures(const World& world) {
  Measures measures;
  measures.pressed = make_pressed(world);
  follow_requests(world, measures);
  return measures;
}

void measure_frame(const Exec& exec, const World& world, const FrameReport& frame, bool snapshot,
                   Measures& measures) {
  // time and forces
  measures.frame_seconds.push_back(frame.seconds);
  update_pressed(exec, world, measures.pressed);
  follow_requests(world, measures);
  for (std::size_t c = 0; c < world.cuts.size(); c++) {
    // wounds
    const Cut& cut = world.cuts[c];
    if (!cut.path) continue;
    const LatticeBody& body = world.lattice_bodies[std::size_t(cut.body)];
    CutMeasures& m = measures.cuts[c];
    if (m.series.empty()) {
      m.tension = cut_tension(body.model, m.excision ? lattice::axis_of(*cut.path) : *cut.path);
      const lattice::Anatomy& anatomy = body.model.anatomy;
      if (!m.region && !m.excision)
        m.gape_error = anatomy.cell_center.empty() ? expected_gape_error(body.model, m.depth)
                                                   : expected_gape_error_of_partial_cells(
                                                         anatomy, lattice::path_length(*cut.path), m.depth);
      if (m.excision) m.marked = lattice::size_of(cut.path->points), m.width = m.marked.width;
    }
    m.edges = cut.edges;
    measures.wound_surfaces.resize(world.lattice_bodies.size());

    // surface near the cut, rebuilt after changes
    lattice::BodySurface& near = measures.wound_surfaces[std::size_t(cut.body)];
    const lattice::Cuts& cuts = body.state.cuts();
    if (!near.fragments || near.fragments->version != cut_version(cuts))
      near = build_surface(body.model, cuts, &body.ct, lattice::Extent::kCuts);

    // measures
    std::vector<int> nodes;
    if (body.state.is_on_device())
      nodes = wound_support_nodes(body.model, cuts, body.state.virtual_u(), near, *cut.path, int(c));
    m.wound = body.state.read_wound_nodes(nodes, [&](const lattice::State& state) {
      return lattice::measure_wound(body.model, state, near, *cut.path, int(c));
    });
    m.series.push_back(sample_of(m.wound, time_of(world)));
    m.specimen = cut.specimen;
    if (cut.specimen) m.dog_ears = dog_ears_of(body, *cut.path);
  }

  // sutures
  for (std::size_t s = 0; s < world.sutures.size(); s++) {
    const CutMeasures& wound = measures.cuts[std::size_t(world.sutures[s].scene.incision)];
    measures.sutures[s].skin_force = wound.tension.opening * wound.wound.length;
    measure_suture(world, world.sutures[s], measures.sutures[s]);
  }

  // solver
  if (!snapshot) return;
  SolverSample sample{time_of(world), frame.residual, 0, frame.largest_speed};
  for (const LatticeBody& body : world.lattice_bodies)
    if (body.model.params.solver.method == lattice::Method::kVbd)  // projections have no energy in joules
      sample.energy += lattice::energy(exec, body.model, body.state);
  measures.solver.push_back(sample);
}

}  // namespace turgor
