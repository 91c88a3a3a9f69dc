// Forces that a step has left over, cell by cell; and the step of its smooth part.
#include "turgor/models/lattice/coarse/coarse_correction.hpp"

#include <algorithm>
#include <numeric>

#include "turgor/models/lattice/build/skin.hpp"
#include "turgor/models/lattice/coarse/coarse_levels.hpp"
#include "turgor/models/lattice/coarse/prolongation.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/mechanics/cut_elements.hpp"
#include "turgor/models/lattice/solver/inertia.hpp"

namespace turgor::lattice {

namespace {

/// Two neighbouring layers of nodes: the even one first.
struct TwoLayers {
  const Lattice& lattice;
  VecField& field;

  /// From slots of a layer to entries of the field.
  int shift(int k) const { return (k & 1) * layer_stride(lattice) - row_slot(lattice, -1, k); }
  void add(int slot, int k, Vec3 f) const {
    const auto at = std::size_t(slot + shift(k));
    field.set(at, field[at] + f);
  }
};

/// Forces of the cells whose lowest nodes are [slot, slot + kGroup), added to those of their corners.
struct CellForces {
  const Model& model;
  const State& state;
  NodeArrays nodes;
  SolidLaw law;
  TwoLayers out;

  /// Moduli of those that are whole now.
  template <int kWidth>
  void find_young(int slot, const int (&corner)[kCellCorners], Real (&young)[kWidth]) const {
    for (int i = 0; i < kWidth; i++) young[i] = model.cell_young[std::size_t(slot + i)];
    if (!state.row_cut[std::size_t(slot / row_stride(model.lattice))]) return;
    std::uint8_t bits[kWidth] = {};
    for (int i = 0; i < kWidth; i++) bits[i] = nodes.cut[slot + i] & kIsCut;
    for (int c = 0; c < kCellCorners; c++)
      for (int i = 0; i < kWidth; i++) bits[i] |= nodes.cut[slot + corner[c] + i] & edges_from_corner(c);
    for (int i = 0; i < kWidth; i++) young[i] = bits[i] ? 0 : young[i];
  }

  template <int kWidth>
  void add(int slot, int k, const int (&corners)[kCellCorners]) const {
    Real young[kWidth];
    find_young<kWidth>(slot, corners, young);
    const SolidLaw by = law;
    const NodeArrays n = nodes;
    Real *fx = out.field.x.data(), *fy = out.field.y.data(), *fz = out.field.z.data();
    int corner[kCellCorners];
    for (int c = 0; c < kCellCorners; c++) corner[c] = corners[c];
    Real px[kCellCorners][kWidth], py[kCellCorners][kWidth], pz[kCellCorners][kWidth];
    TURGOR_LANES
    for (int i = 0; i < kWidth; i++) {
      const int a = slot + i;
      Vec3 d[kCellCorners];
#pragma GCC unroll 8
      for (int c = 0; c < kCellCorners; c++) d[c] = n.u(a + corner[c]) - n.u(a);
      const CellStress stress = cell_stress(d, by, young[i]);
#pragma GCC unroll 8
      for (int c = 0; c < kCellCorners; c++) {
        const Vec3 f = corner_force(stress, d[c], c);
        px[c][i] = f.x, py[c][i] = f.y, pz[c][i] = f.z;
      }
    }
    for (int c = 0; c < kCellCorners; c++)
      for (int i = 0; i < kWidth; i++) {
        const int at = slot + corner[c] + out.shift(k + cell_corner(c).z) + i;
        fx[at] += px[c][i], fy[at] += py[c][i], fz[at] += pz[c][i];
      }
  }

  void operator()(const Runs& cells, int k) const {
    const Lattice& l = model.lattice;
    for (int parity = 0; parity < 2; parity++) {
      int corner[kCellCorners];
      for (int c = 0; c < kCellCorners; c++) corner[c] = slot_offset(l, cell_corner(c), parity);
      for (int j = 0; j + 1 < l.size.y; j++)
        for (const Run run : cells.of_half_row(row_slot(l, j, k) / l.half + parity)) {
          int begin = 0;
          for (; begin + 2 * kGroup <= run.count; begin += 2 * kGroup)
            add<2 * kGroup>(run.begin + begin, k, corner);
          if (begin < run.count) add<kGroup>(run.begin + begin, k, corner);
        }
    }
  }
};

/// Inertia, and nothing yet where nothing moves.
void begin_layer(const Model& model, const Inertia& inertia, const State& state, int k, TwoLayers out) {
  const Lattice& l = model.lattice;
  const int shift = out.shift(k);
  for (auto* axis : {&out.field.x, &out.field.y, &out.field.z})
    std::fill_n(axis->begin() + shift + row_slot(l, -1, k), layer_stride(l), Real(0));
  const Real per_h2 = 1 / (inertia.dt * inertia.dt);
  for_each_piece(model, nullptr, k, [&](int, int slot, int pieces) {
    Real *fx = out.field.x.data(), *fy = out.field.y.data(), *fz = out.field.z.data();
    const Real *ux = state.u.x.data(), *uy = state.u.y.data(), *uz = state.u.z.data();
    const Inertia y = inertia;
    TURGOR_LANES
    for (int s = slot; s < slot + pieces; s++) {
      const Real m = y.moves(s) * per_h2 / nonzero(y.w[s]);
      const Vec3 lack = y.at(s, 1) - Vec3{ux[s], uy[s], uz[s]};
      fx[s + shift] = lack.x * m, fy[s + shift] = lack.y * m, fz[s + shift] = lack.z * m;
    }
  });
}

/// Of skin in the cells between layers k and k + 1.
void add_skin(const Model& model, const State& state, const NodeArrays& nodes, const SkinForces& skin, int k,
              TwoLayers out) {
  const int above = row_slot(model.lattice, -1, k + 1);
  const std::span<const SkinTriangle> triangles = skin_of_cells(model, {k, k + 1});
  const std::uint8_t* cut = state.skin_cut.data() + (triangles.data() - model.skin.triangles.data());
  TriangleForces forces;
  for (std::size_t first = 0; first < triangles.size(); first += kSkinLanes) {
    const std::size_t count = std::min(std::size_t(kSkinLanes), triangles.size() - first);
    skin.find(triangles.subspan(first, count), nodes, forces);
    for (std::size_t i = 0; i < count; i++)
      for (int c = 0; c < 3 && !cut[first + i]; c++) {
        const int slot = triangles[first + i].vertex[c];
        out.add(slot, slot < above ? k : k + 1, forces.get(c, int(i)));
      }
  }
}

/// What answers the skin in the CT, and what blades parted.
void add_pull_and_parts(const Model& model, const CutElementForces& parts, int k, TwoLayers out,
                        std::vector<VirtualNodeShift>& virtual_nodes) {
  const Lattice& l = model.lattice;
  const int begin = row_slot(l, -1, k), end = begin + layer_stride(l);
  const Skin& skin = model.skin;
  if (!skin.triangles.empty())
    for (int n = skin.row_begin[std::size_t(begin / l.half)]; n < skin.row_begin[std::size_t(end / l.half)];
         n++)
      out.add(skin.nodes[std::size_t(n)], k, -skin.pull[std::size_t(n)]);
  for (const ElementNode& node : parts.nodes_of(begin, end - begin))
    out.add(node.slot, k, parts.gather(node).f);
  for (const ElementNode& copy : parts.virtual_nodes_of(k)) {
    const Vec3 f = parts.gather(copy).f;
    virtual_nodes[std::size_t(copy.corner - slot_count(l))] = {f.x, f.y, f.z};
  }
}

/// Those that begin in a layer; slots ascend with layers.
void add_loose_edges(const Model& model, const State& state, const CoarseSpace& space, int k, TwoLayers out) {
  const Lattice& l = model.lattice;
  const auto root = [&](int slot) { return model.root_stiffness[std::size_t(slot)]; };
  const auto first = [&](int layer) {
    return std::partition_point(space.loose.begin(), space.loose.end(),
                                [&](const LooseEdge& e) { return e.slot < row_slot(l, -1, layer); });
  };
  for (auto edge = first(k); edge != first(k + 1); ++edge) {
    const int other = end_of(l, *edge), above = k + kFamilies[std::size_t(edge->family)].z;
    const auto a = std::size_t(edge->slot), b = std::size_t(other), family = std::size_t(edge->family);
    NodeSystem s;
    const Vec3 d = hadamard(l.step, Vec3(kFamilies[family])) + (state.u[b] - state.u[a]);
    add_spring(s, d, model.rest_length[family], model.spring_scale[family] * root(edge->slot) * root(other));
    out.add(edge->slot, k, s.f), out.add(other, above, -s.f);
  }
}

// ---------------------------------------------------------------- between corners and unknowns

/// What the forces that are left over do to the unknowns.
std::vector<double> gather_unknowns(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                                    double dt) {
  const CoarseSpace& space = *state.coarse;
  const std::size_t rows = space.row_begin.size() - 1;
  std::vector<Vec3d> sums(kStretches * rows);
  const auto sums_of = [&](std::size_t stretch) { return std::span(sums).subspan(stretch * rows, rows); };
  find_left_over(exec, model, state, space, inputs, dt, state.residual_forces,
                 [&](int stretch, int k, LayerForces forces) {
                   add_to_corners(space, k, forces, sums_of(std::size_t(stretch)));
                 });
  add_copies_to_corners(model, state, sums_of(0));
  std::vector<double> out(3 * std::size_t(space.unknowns));
  for (std::size_t row = 0; row < rows; row++) {
    Vec3d sum;
    for (std::size_t stretch = 0; stretch < kStretches; stretch++) sum += sums_of(stretch)[row];
    for (int t = space.row_begin[row]; t < space.row_begin[row + 1]; t++)
      for (int axis = 0; axis < 3; axis++)
        out[std::size_t(3 * space.terms[std::size_t(t)].unknown + axis)] +=
            double(space.terms[std::size_t(t)].weight) * sum[axis];
  }
  return out;
}

/// Moves nodes and copies by `part` of what the unknowns say.
void move_by(const Exec& exec, const Model& model, State& state, std::span<const double> unknowns,
             double part) {
  const CoarseSpace& space = *state.coarse;
  std::vector<Vec3> corners(space.row_begin.size() - 1);
  for (std::size_t row = 0; row < corners.size(); row++) {
    Vec3d sum;
    for (int t = space.row_begin[row]; t < space.row_begin[row + 1]; t++)
      for (int axis = 0; axis < 3; axis++)
        sum[axis] += double(space.terms[std::size_t(t)].weight) *
                     unknowns[std::size_t(3 * space.terms[std::size_t(t)].unknown + axis)];
    corners[row] = Vec3(sum * part);
  }
  move_followers(exec, model, state, corners);
}

double work(std::span<const double> forces, std::span<const double> way) {
  return std::inner_product(forces.begin(), forces.end(), way.begin(), 0.0);
}

/// Of ways of three numbers each.
double longest(std::span<const double> ways) {
  double most = 0;
  for (std::size_t n = 0; n < ways.size(); n += 3)
    most = std::max(most, norm(Vec3d{ways[n], ways[n + 1], ways[n + 2]}));
  return most;
}

/// Does a blade cut more in the steps to come? Not when it has stopped for some.
bool blade_goes_on(State& state, std::size_t cuts) {
  constexpr int kStopped = 8;
  state.steps_since_cut = cuts != state.cuts_before ? 0 : state.steps_since_cut + 1;
  state.cuts_before = cuts;
  return state.blades_on.any() && state.steps_since_cut < kStopped;
}

/// As the CT shows it, and nothing moves it: then there is nothing to solve for.
bool is_at_rest(const Model& model, const State& state, const Inputs& inputs, double dt) {
  constexpr double kStill = 1e-6;  // steps of the lattice a frame: rounding
  const Vec3 h = model.lattice.step;
  return cut_version(state) == 0 && inputs.loads.empty() && norm(inputs.gravity) == 0 &&
         double(state.fastest) * dt < kStill * double(std::min({h.x, h.y, h.z}));
}

}  // namespace

void find_left_over(const Exec& exec, const Model& model, State& state, const CoarseSpace& space,
                    const Inputs& inputs, double dt, ResidualWorkspace& room,
                    const std::function<void(int, int, LayerForces)>& see) {
  room.virtual_nodes.assign(state.virtual_nodes.size(), {});
  room.layers.resize(kStretches);
  const Inertia inertia(model, state, inputs, dt);
  const SolidLaw law = solid_law(model.lattice.step, model.params.tissue.poisson);
  const SkinForces skin(model);
  const CutElementForces parts(model, state);
  const int layers = model.lattice.size.z;
  parallel_for(exec, kStretches, [&](std::size_t stretch) {
    VecField& field = room.layers[stretch];
    const auto slots = std::size_t(2 * layer_stride(model.lattice) + kSpareSlots);
    if (field.x.size() != slots) field.resize(slots);
    const TwoLayers out{model.lattice, field};
    const CellForces cells{model, state, node_arrays(model, state), law, out};
    const auto add_cells = [&](int k) {
      if (k < 0 || k + 1 >= layers) return;
      cells(space.cells, k);
      add_loose_edges(model, state, space, k, out);
      if (!model.skin.triangles.empty()) add_skin(model, state, cells.nodes, skin, k, out);
    };
    const int begin = layers * int(stretch) / kStretches, end = layers * int(stretch + 1) / kStretches;
    if (begin == end) return;
    for (int k = std::max(0, begin - 1); k <= begin; k++) begin_layer(model, inertia, state, k, out);
    add_cells(begin - 1);
    for (int k = begin; k < end; k++) {
      if (k + 1 < layers) begin_layer(model, inertia, state, k + 1, out);
      add_cells(k);
      add_pull_and_parts(model, parts, k, out, room.virtual_nodes);
      see(int(stretch), k, {field, out.shift(k)});
    }
  });
}

bool may_have_coarse_space(const Model& model) {
  const Params& params = model.params;
  return params.solver.coarse && params.solver.method == Method::kVbd &&
         params.tissue.law == TissueLaw::kSolid;
}

bool prepare_coarse_space(const Model& model, State& state, const Inputs& inputs, double dt) {
  if (!may_have_coarse_space(model) || !inputs.contacts.empty()) return false;
  const std::size_t cuts = cut_version(state);
  const bool goes_on = blade_goes_on(state, cuts);
  if (is_at_rest(model, state, inputs, dt)) return false;
  // Times of frames are rounded; and a frame that is done in parts, while a tool is fast, is not worth a
  // space of its own.
  if (state.coarse && dt < 0.99 * state.coarse->dt) return false;
  if (!state.coarse || state.coarse->version != cuts || dt > 1.01 * state.coarse->dt) {
    if (goes_on) return false;
    state.coarse = make_coarse_space(model, state, dt);
  }
  return state.coarse->unknowns > 0;
}

double apply_coarse_correction(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                               double dt) {
  const CoarseSpace& space = *state.coarse;
  const auto forces = [&] { return gather_unknowns(exec, model, state, inputs, dt); };
  const std::vector<double> before = forces(), way = space.stiffness.solve(before);
  const double slope = work(before, way);
  if (!(slope > 0)) return 0;
  move_by(exec, model, state, way, 1);
  const double part = part_of_way(slope, work(forces(), way));
  move_by(exec, model, state, way, part - 1);
  return part * longest(way);
}

std::size_t memory_bytes(const CoarseSpace& space) {
  const auto bytes = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
  return bytes(space.blocks) + bytes(space.row_begin) + bytes(space.terms) + bytes(space.follows) +
         bytes(space.runs) + bytes(space.runs_begin) + bytes(space.outside) + bytes(space.loose) +
         bytes(space.cells.all) + bytes(space.cells.row_begin) + bytes(space.stiffness.order) +
         bytes(space.stiffness.mobility) + bytes(space.stiffness.column) + bytes(space.stiffness.row) +
         bytes(space.stiffness.value);
}

}  // namespace turgor::lattice
