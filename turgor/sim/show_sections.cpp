// Sections of the deformed CT in the planes of a cut-away, for pictures.
#include <algorithm>
#include <cmath>

#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr int kMostSectionSamples = 512;  // along a side

/// Grid of a plane, one sample thick, that covers the points. Samples are as large as the CT's smallest side,
/// or larger if the plane has more than kMostSectionSamples of them.
Grid section_grid(Vec3d at, Vec3d normal, const std::vector<Vec3>& points, const Grid& ct) {
  const Vec3d other = std::abs(normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d right = normalized(cross(other, normal)), up = cross(normal, right);
  double low[2] = {0, 0}, high[2] = {0, 0};
  for (const Vec3 x : points) {
    const Vec3d from_at = Vec3d(x) - at;
    const double in_plane[2] = {dot(from_at, right), dot(from_at, up)};
    for (int i = 0; i < 2; i++)
      low[i] = std::min(low[i], in_plane[i]), high[i] = std::max(high[i], in_plane[i]);
  }
  const double longest = std::max(high[0] - low[0], high[1] - low[1]);
  const double spacing =
      std::max(std::min({ct.spacing.x, ct.spacing.y, ct.spacing.z}), longest / (kMostSectionSamples - 1));
  const auto samples = [&](int i) { return 1 + int(std::ceil((high[i] - low[i]) / spacing)); };
  return {.size = {samples(0), samples(1), 1},
          .spacing = {spacing, spacing, spacing},
          .origin = at + right * low[0] + up * low[1],
          .axes = {{right, up, normal}}};
}

}  // namespace

void show_sections(const Exec& exec, const World& world, WorldSnapshot& out) {
  for (BodySnapshot& body : out.bodies) body.sections.clear();
  if (!out.cutaway || out.cutaway->body.kind != BodyKind::kLattice) return;
  const auto index = std::size_t(out.cutaway->body.index);
  if (index >= world.lattice_bodies.size()) return;  // of another world
  const LatticeBody& body = world.lattice_bodies[index];
  BodySnapshot& shown = body_snapshot(out, out.cutaway->body);
  const CutawayPlanes planes = cutaway_planes(*out.cutaway, shown.box);
  for (const Vec3d normal : planes.normals) {
    const Grid grid = section_grid(planes.at, normal, shown.x, body.ct.grid);
    shown.sections.push_back(
        body.state.resample(exec, body.model, body.ct, grid, {.keep_surroundings = false}).ct);
  }
}

}  // namespace turgor
