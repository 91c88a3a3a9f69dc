#include "turgor/models/rhombus/spread.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/lanes.hpp"

namespace turgor::rhombus {

namespace {

/// A load in the kernel's single-precision form.
struct Source {
  float position[3];    // relative to the origin `middle` [m]
  float force[3];       // times 2/(π E*) and the square root of the softness at the vertex [m²]
  float size;           // magnitude of `force` [m²]
  float half_softened;  // half of its ε² [m²]
};

/// Sixteen vertices, one a lane.
struct VertexLanes {
  Lanes position[3];
  Lanes half_softened;
};

// Regularization ε. Even pressure on a disc of the vertex's area gives it the mean displacement 16 f/(3 π² E*
// a), with a its radius. The law below gives 2 f/(π E* ε) at the vertex itself.
double half_softened_by(double area) {
  const double softened = 3 * std::numbers::pi / 8 * std::sqrt(area / std::numbers::pi);
  return 0.5 * softened * softened;
}

double softness_at(const Model& model, std::size_t v) {
  return model.stiffness.empty() ? 1 : 1 / std::sqrt(model.stiffness[v]);
}

/// Adds the displacement by one load [de Goes, James 2017, eq. 6, for ν = 1/2]:
///
///     u = ½ [(1/ρ + ε²/ρ³) f + (r·f) r/ρ³],    ρ² = r² + ε²
///
/// with ε² the mean of both vertices.
void add_kelvin_displacements(const VertexLanes& at, const Source& from, Lanes (&move)[3]) {
  const Lanes softened = at.half_softened + from.half_softened;
  const Lanes x = at.position[0] - from.position[0], y = at.position[1] - from.position[1],
              z = at.position[2] - from.position[2];
  const Lanes inverse2 = 1.f / (x * x + y * y + z * z + softened);
  const Lanes half = 0.5f * square_root(inverse2);
  const Lanes along = half * (1.f + softened * inverse2);
  const Lanes toward = half * inverse2 * (x * from.force[0] + y * from.force[1] + z * from.force[2]);
  move[0] += along * from.force[0] + toward * x;
  move[1] += along * from.force[1] + toward * y;
  move[2] += along * from.force[2] + toward * z;
}

std::vector<Source> sources_of(const Model& model, std::span<const Load> loads, Vec3d middle) {
  const double compliance = 2 / (std::numbers::pi * half_space_modulus(model.chain));
  std::vector<Source> sources;
  sources.reserve(loads.size());
  for (const Load& load : loads) {
    const auto v = std::size_t(load.vertex);
    const Vec3d x = model.surface.vertices[v] - middle, f = load.force * (compliance * softness_at(model, v));
    sources.push_back({{float(x.x), float(x.y), float(x.z)},
                       {float(f.x), float(f.y), float(f.z)},
                       float(norm(f)),
                       float(half_softened_by(model.area[v]))});
  }
  return sources;
}

}  // namespace

double half_space_modulus(const Chain& chain) {
  const double tip = chain.params.tip;
  return 1 / (depth_of_force(chain, 0).compliance * 2 * (tip > 0 ? tip : 0.5 * unit_width(chain)));
}

void displacements_of(const Exec& exec, const Model& model, std::span<const Load> loads,
                      std::vector<Vec3d>& displacement) {
  const std::vector<Vec3d>& vertices = model.surface.vertices;
  TURGOR_CHECK(std::all_of(loads.begin(), loads.end(),
                           [&](const Load& l) { return is_index(l.vertex, vertices.size()); }),
               "loads act on vertices of the organ");
  // loads
  const std::vector<Source> sources = sources_of(model, loads, vertices[0]);
  displacement.resize(vertices.size());
  parallel_for(exec, (vertices.size() + kLanes - 1) / kLanes, [&](std::size_t block) {
    const std::size_t begin = block * kLanes, end = std::min(begin + kLanes, vertices.size());
    // gather sixteen vertices
    VertexLanes at{{}, all_lanes(1)};
    for (std::size_t v = begin; v < end; v++) {
      const Vec3d x = vertices[v] - vertices[0];
      for (int axis = 0; axis < 3; axis++) at.position[axis][v - begin] = float(x[axis]);
      at.half_softened[v - begin] = float(half_softened_by(model.area[v]));
    }
    Lanes move[3] = {};
    // sum over the loads
    for (const Source& source : sources) add_kelvin_displacements(at, source, move);
    // scatter
    for (std::size_t v = begin; v < end; v++)
      displacement[v] =
          Vec3d{move[0][v - begin], move[1][v - begin], move[2][v - begin]} * softness_at(model, v);
  });
}

// The law of add_kelvin_displacements for one pair, in double precision.
void displacement_block(const Model& model, int vertex, int loaded, std::span<double, 9> block) {
  const auto v = std::size_t(vertex), l = std::size_t(loaded);
  TURGOR_CHECK(is_index(vertex, model.area.size()) && is_index(loaded, model.area.size()),
               "loads act on vertices of the organ");
  const Vec3d r = model.surface.vertices[v] - model.surface.vertices[l];
  const double softened = half_softened_by(model.area[v]) + half_softened_by(model.area[l]);
  const double inverse2 = 1 / (dot(r, r) + softened), half = 0.5 * std::sqrt(inverse2);
  const double compliance = 2 / (std::numbers::pi * half_space_modulus(model.chain)) * softness_at(model, v) *
                            softness_at(model, l);
  const double along = compliance * half * (1 + softened * inverse2), toward = compliance * half * inverse2;
  for (int axis = 0; axis < 3; axis++)
    for (int k = 0; k < 3; k++)
      block[std::size_t(3 * axis + k)] = (k == axis ? along : 0) + toward * r[axis] * r[k];
}

// The displacement is largest in the force's direction: u = f/ρ times 2/(π E*).
double farthest_move(const Exec& exec, const Model& model, std::span<const Load> loads) {
  const std::vector<Source> sources = sources_of(model, loads, model.surface.vertices[0]);
  std::vector<double> move(loads.size());
  parallel_for(exec, loads.size(), [&](std::size_t n) {
    float sum = 0;
    for (std::size_t m = 0; m < sources.size(); m++) {
      const Source &a = sources[n], &b = sources[m];
      const float x = a.position[0] - b.position[0], y = a.position[1] - b.position[1],
                  z = a.position[2] - b.position[2];
      sum += b.size / std::sqrt(x * x + y * y + z * z + a.half_softened + b.half_softened);
    }
    move[n] = double(sum) * softness_at(model, std::size_t(loads[n].vertex));
  });
  return move.empty() ? 0 : *std::max_element(move.begin(), move.end());
}

}  // namespace turgor::rhombus
