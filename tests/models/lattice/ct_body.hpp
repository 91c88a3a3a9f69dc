// Small CTs with a body in air, and prescribed cuts and displacements, for tests of drawing and resampling.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/cutting/fine_lattice.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

constexpr double kVoxel = 0.001;  // [m]

/// A CT of 1 mm voxels: textured tissue where `inside(voxel index)`, air elsewhere.
inline CtVolume make_ct(Int3 size, const std::function<bool(Vec3d)>& inside) {
  CtVolume ct;
  ct.grid = {.size = size, .spacing = {kVoxel, kVoxel, kVoxel}, .origin = {-0.1, 0.05, 0.3}, .axes = {}};
  ct.samples.resize(sample_count(ct.grid));
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        ct.at(i, j, k) = inside({double(i), double(j), double(k)})
                             ? std::int16_t((i * 37 + j * 91 + k * 53) % 101 - 40)
                             : kAirHu;
  return ct;
}

/// A ball in the center of a cube of n³ voxels.
inline CtVolume ball_ct(int n, double radius) {
  const double middle = 0.5 * (n - 1);
  return make_ct({n, n, n}, [=](Vec3d p) { return norm(p - Vec3d{middle, middle, middle}) < radius; });
}

/// A CT with a smooth transition at the skin, as of a scanner, so that the surface can be exact.
inline CtVolume soft_ball(int n, double radius) {
  CtVolume ct = ball_ct(n, radius);
  const double middle = 0.5 * (n - 1);
  for (int k = 0; k < n; k++)
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) {
        const double outward = norm(Vec3d(Int3{i, j, k}) - Vec3d{middle, middle, middle}) - radius;
        ct.at(i, j, k) = std::int16_t(std::clamp(-449 - 35 * outward, -1000.0, 102.0));
      }
  return ct;
}

/// A slab of tissue below air, wider than the scan: the scan ends at its sides and its bottom.
inline CtVolume slab_ct() {
  return make_ct({64, 64, 32}, [](Vec3d p) { return p.z < 22; });
}

inline std::int16_t at_or_air(const CtVolume& ct, Int3 p) {
  return contains(ct.grid, p) ? ct.at(p.x, p.y, p.z) : kAirHu;
}

template <class See>
void for_voxels(const Grid& grid, const See& see) {
  for (int k = 0; k < grid.size.z; k++)
    for (int j = 0; j < grid.size.y; j++)
      for (int i = 0; i < grid.size.x; i++) see(Int3{i, j, k});
}

/// A ball whose edge is blurred over about three voxels, in noise or in clean air.
inline CtVolume blurred_ball_ct(int n, double radius, bool noise) {
  CtVolume ct = ball_ct(n, radius);
  const double middle = 0.5 * (n - 1);
  for_voxels(ct.grid, [&](Int3 p) {
    const double out = norm(Vec3d(p) - Vec3d{middle, middle, middle}) - radius;
    if (out > -1.5) ct.at(p.x, p.y, p.z) = std::int16_t(-1000 + 1000 * std::clamp(0.5 - out / 3, 0.0, 1.0));
    if (out >= 1.5 && noise)
      ct.at(p.x, p.y, p.z) = std::int16_t(-1000 + (p.x * 31 + p.y * 17 + p.z * 7) % 60);
  });
  return ct;
}

/// A body from a CT without skin, since the tests prescribe its displacements.
inline Model body_of(const CtVolume& ct, Int3 block) {
  Params params;
  params.block = block;
  params.skin.enabled = false;
  return build(Exec(1), ct, {}, params).value();
}
/// Removes the body nodes [4, 7) × [4, 7) from layer 5 on.
inline void remove_block(const Model& model, State& state) {
  for (int k = 5; k < model.anatomy.lattice.size.z; k++)
    for (int j = 4; j < 7; j++)
      for (int i = 4; i < 7; i++) {
        const auto slot = std::size_t(node_slot(model.anatomy.lattice, i, j, k));
        if (is_body(model.anatomy.tissue[slot])) state.cuts.removed[slot] = 1, state.cuts.removed_nodes++;
      }
}

/// Moves every node by `displacement(rest position in the lattice frame [m])`.
inline void move(const Model& model, State& state, const std::function<Vec3d(Vec3d)>& displacement) {
  const Int3 size = model.anatomy.lattice.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const auto slot = std::size_t(node_slot(model.anatomy.lattice, i, j, k));
        if (!is_body(model.anatomy.tissue[slot])) continue;
        state.motion.u.set(slot,
                           Vec3(displacement(hadamard(Vec3d(Int3{i, j, k}), model.anatomy.grid.spacing))));
      }
}

/// Lists all cells of the cut fine edges as cells that the blades pass through, without crossed sample lines
/// (cut_fraction.hpp).
inline void list_cut_cells(const Model& model, State& state) {
  const FineLattice fine = fine_lattice(model);
  std::set<std::pair<int, std::uint8_t>> cells;
  for (const CutEdge& edge : state.cuts.edges) {
    const Int3 a = fine_node(fine, edge);
    for_cells_of_edge(fine, a, a + kFamilies[edge.family], [&](Int3 cell) {
      cells.insert({node_slot(fine.cells, cell), edge.incision});
    });
  }
  state.cuts.samples.clear();
  for (const auto& [slot, incision] : cells)
    state.cuts.samples.push_back({.slot = slot, .incision = incision});
}

/// Cuts the edges that cross the plane y = `at` where `reaches(crossing)`; positions in the lattice frame
/// [m]. Returns the number of cut lattice edges.
inline int cut_across_y(const Model& model, State& state, double at,
                        const std::function<bool(Vec3d)>& reaches) {
  const Lattice& l = model.anatomy.lattice;
  const FineLattice fine = fine_lattice(model);
  const auto crossing = [&](Vec3d x, Vec3d y) {  // or NaN
    const double fraction = (at - x.y) / (y.y - x.y);
    return (x.y >= at) != (y.y >= at) && reaches(x + (y - x) * fraction) ? fraction : std::nan("");
  };
  const auto solid = [&](Int3 p) { return contains(l, p) && is_solid(model, state.cuts, node_slot(l, p)); };
  int count = 0;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++)
        for (std::size_t f = 0; f < kFamilyCount; f++) {
          const Int3 a{i, j, k}, b = a + kFamilies[f];
          if (!solid(a) || !solid(b)) continue;
          if (std::isnan(crossing(hadamard(Vec3d(a), model.anatomy.grid.spacing),
                                  hadamard(Vec3d(b), model.anatomy.grid.spacing))))
            continue;
          state.cuts.cut[std::size_t(node_slot(l, a))] |= std::uint8_t(1u << f);
          count++;
        }
  for (int k = 0; k < fine.size.z; k++)
    for (int j = 0; j < fine.size.y; j++)
      for (int i = 0; i < fine.size.x; i++)
        for (int f = 0; f < kFamilyCount; f++) {
          const Int3 a{i, j, k}, b = a + kFamilies[std::size_t(f)];
          if (!contains(fine, b)) continue;
          const Vec3d x = hadamard(lattice_index(fine, a), model.anatomy.grid.spacing);
          const double fraction = crossing(x, hadamard(lattice_index(fine, b), model.anatomy.grid.spacing));
          if (std::isnan(fraction)) continue;
          CutEdge edge = cut_edge_at(fine, a, f);
          edge.fraction = Real(fraction), edge.rightward = true;
          edge.along = Real(x.x);
          state.cuts.edges.push_back(edge);
        }
  list_cut_cells(model, state);
  return count;
}

/// A smooth displacement of about `size` [m], without inverted cells while `size` is below about an eighth of
/// `wave` [m].
inline Vec3d wobble(Vec3d p, double size, double wave, double phase) {
  const double w = 6.283185307179586 / wave;
  return Vec3d{std::sin(w * p.y + phase) + 0.5 * std::cos(w * p.x + 2 * phase),
               std::cos(w * p.z - phase) + 0.5 * std::sin(w * p.x),
               std::sin(w * p.x + 0.7 * w * p.y + phase)} *
         (0.5 * size);
}

}  // namespace turgor::lattice
