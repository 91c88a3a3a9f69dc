// A body on one side of a bus or the other: its model and one state in arrays of that side, and its steps by
// that side's run. A side is GpuSide (gpu_body.cu); tests have one that is the host, in a shuffled order.
// Nothing goes over or back but what is told to.
#pragma once

#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/device_arrays.hpp"
#include "turgor/models/lattice/device/device_coarse.hpp"
#include "turgor/models/lattice/device/device_readback.hpp"
#include "turgor/models/lattice/device/device_resampling.hpp"
#include "turgor/models/lattice/device/device_state.hpp"
#include "turgor/models/lattice/solver/pbd_kernels.hpp"
#include "turgor/models/lattice/solver/vbd_kernels.hpp"

namespace turgor::lattice {

/// What both solvers need.
template <class Side>
struct DeviceNodes {
  template <class T>
  using Array = typename Side::template Array<T>;

  int half;
  DeviceVectors<Side> u, u_before, v;
  Array<Real> w, root;
  Array<std::uint8_t> cut, removed, skin_cut;
  ColorBegin moving_of;
  Array<int> moving;
  Array<SkinTriangle> triangles;
  Array<StepMarks> marks;

  DeviceNodes(DeviceAllocator<Side>& rooms, const Model& m)
      : half(m.lattice.half),
        u(rooms, m.inverse_mass.size()),
        u_before(rooms, m.inverse_mass.size()),
        v(rooms, m.inverse_mass.size()),
        w(rooms.copy(m.inverse_mass)),
        root(rooms.copy(m.root_stiffness)),
        cut(rooms.template room<std::uint8_t>(m.inverse_mass.size())),
        removed(rooms.template room<std::uint8_t>(m.inverse_mass.size())),
        skin_cut(rooms.template room<std::uint8_t>(m.skin.triangles.size())),
        moving(rooms.copy(groups(m, moving_of))),
        triangles(rooms.copy(m.skin.triangles)),
        marks(rooms.template room<StepMarks>(1)) {}

  static std::vector<int> groups(const Model& m, ColorBegin& of) {
    std::vector<int> first;
    of = groups_by_colors(m.lattice, m.moving, first);
    return first;
  }
  void put_cuts(const State& state) {
    cut.upload(state.cut), removed.upload(state.removed), skin_cut.upload(state.skin_cut);
  }
  MovingNodes view() const {
    return {.half = half,
            .slots = int(w.size()),
            .nodes = {u.x.data(), u.y.data(), u.z.data(), w.data(), root.data(), cut.data()},
            .bx = u_before.x.data(),
            .by = u_before.y.data(),
            .bz = u_before.z.data(),
            .vx = v.x.data(),
            .vy = v.y.data(),
            .vz = v.z.data(),
            .removed = removed.data(),
            .moving = moving.data(),
            .moving_count = int(moving.size()),
            .marks = marks.data()};
  }
};

template <class Side>
struct DevicePbd {
  template <class T>
  using Array = typename Side::template Array<T>;

  Array<NodeKind> kinds;
  Array<std::uint16_t> kind;
  Array<int> joining, heads, next;
  ColorBegin joining_of, heads_of;

  DevicePbd(DeviceAllocator<Side>& rooms, const PbdOrdering& ordering)
      : kinds(rooms.copy(ordering.kinds)),
        kind(rooms.copy(ordering.kind)),
        joining(rooms.copy(ordering.joining)),
        heads(rooms.copy(ordering.heads)),
        next(rooms.copy(ordering.next)),
        joining_of(ordering.joining_of),
        heads_of(ordering.heads_of) {}

  PbdView view(const Model& model, const DeviceNodes<Side>& nodes) const {
    return {.rules = pbd_rules(model),
            .body = nodes.view(),
            .kinds = kinds.data(),
            .kind = kind.data(),
            .joining = joining.data(),
            .joining_of = joining_of,
            .triangles = nodes.triangles.data(),
            .skin_cut = nodes.skin_cut.data(),
            .next = next.data(),
            .heads = heads.data(),
            .heads_of = heads_of};
  }
};

template <class Side>
struct DeviceVbd {
  template <class T>
  using Array = typename Side::template Array<T>;
  template <class T>
  using List = DeviceList<Side, T>;

  Array<Real> young;
  Array<std::uint8_t> row_cut;
  Array<int> skin_nodes, corner_begin, row_begin, lanes_begin;
  Array<Vec3> pull;
  Array<SkinCorners> corners;
  SkinParams pull_of;  // which skin
  List<CutCellElement> cells;
  List<CutSkinElement> cut_skin_elements;
  List<NodeElement> uses;
  List<ElementNode> element_nodes, virtual_nodes;
  ColorBegin virtual_nodes_of;
  List<VirtualNodeShift> shifts, shifts_before;
  List<NodeContact> contacts;
  List<PartOfResidual> residual;

  DeviceVbd(DeviceAllocator<Side>& rooms, const Model& m)
      : young(rooms.copy(m.cell_young)),
        row_cut(rooms.template room<std::uint8_t>(m.inverse_mass.size() / std::size_t(2 * m.lattice.half))),
        skin_nodes(rooms.copy(m.skin.nodes)),
        corner_begin(rooms.copy(m.skin.corner_begin)),
        row_begin(rooms.copy(m.skin.row_begin)),
        lanes_begin(rooms.copy(m.skin.lanes_begin)),
        pull(rooms.copy(m.skin.pull)),
        corners(rooms.copy(m.skin.corners)),
        pull_of(m.params.skin) {}

  void put_cuts(const Model& model, const State& state) {
    row_cut.upload(state.row_cut);
    cells.put(state.parts.cells), cut_skin_elements.put(state.parts.skin), uses.put(state.parts.uses);
    element_nodes.put(state.parts.nodes);
    const VirtualNodeOrdering ordering = copy_schedule(model, state);
    virtual_nodes.put(ordering.virtual_nodes), virtual_nodes_of = ordering.virtual_nodes_of;
    shifts.put(state.virtual_nodes), shifts_before.put(state.virtual_nodes_before);
    shifts_before.fit(state.virtual_nodes.size());
  }
  /// Skin may be under another tension than the one that was put.
  void keep_pull(const Model& model) {
    if (pull_of == model.params.skin) return;
    pull.upload(model.skin.pull);
    pull_of = model.params.skin;
  }
  VbdView view(const Model& model, const DeviceNodes<Side>& nodes, const Inputs& inputs, double dt) const {
    const MovingNodes body = nodes.view();
    const Vec3 fall = lattice_gravity(model, inputs) * Real(dt * dt);
    return {.rules = descent_rules(model),
            .body = body,
            .moving_of = nodes.moving_of,
            .inertia = Inertia(body, fall, Real(dt)),
            .young = model.params.tissue.law == TissueLaw::kSolid ? young.data() : nullptr,
            .row_cut = row_cut.data(),
            .skin_nodes = skin_nodes.size() > 0 ? skin_nodes.data() : nullptr,
            .corner_begin = corner_begin.data(),
            .skin_row_begin = row_begin.data(),
            .lanes_begin = lanes_begin.data(),
            .pull = pull.data(),
            .corners = corners.data(),
            .skin_cut = nodes.skin_cut.data(),
            .parts = {.nodes = body.nodes,
                      .slots = body.slots,
                      .virtual_nodes = shifts.data(),
                      .cells = cells.data(),
                      .cut_skin_elements = cut_skin_elements.data(),
                      .uses = uses.data(),
                      .triangles = nodes.triangles.data(),
                      .solid = solid_law(model.lattice.step, model.params.tissue.poisson),
                      .skin = SkinForces(model)},
            .virtual_nodes_before = shifts_before.data(),
            .element_nodes = element_nodes.data(),
            .virtual_nodes = virtual_nodes.data(),
            .part_node_count = int(element_nodes.count),
            .virtual_node_count = int(shifts.count),
            .virtual_nodes_of = virtual_nodes_of,
            .contacts = contacts.data(),
            .contact_count = int(contacts.count),
            .residual = nullptr};
  }
};

template <class Side>
class DeviceBody final : public BodyBackend {
 public:
  DeviceBody(const Model& model, DeviceAllocator<Side>& rooms, typename Side::Run run = {})
      : run_(std::move(run)), nodes_(rooms, model) {
    if (model.params.solver.method == Method::kPbd)
      pbd_.emplace(rooms, pbd_schedule(model));
    else
      vbd_.emplace(rooms, model);
    if (may_have_coarse_space(model)) coarse_.emplace(rooms, model);
  }

  void put_state(const Model& model, const State& state) override {
    nodes_.u.upload(state.u), nodes_.u_before.upload(state.u_before), nodes_.v.upload(state.v);
    put_cuts(model, state);
  }
  void put_cuts(const Model& model, const State& state) override {
    nodes_.put_cuts(state);
    resampled_.forget_cuts();
    if (vbd_) vbd_->put_cuts(model, state);
  }
  void get_state(State& state) const override {
    nodes_.u.download(state.u), nodes_.u_before.download(state.u_before), nodes_.v.download(state.v);
    if (!vbd_) return;
    state.virtual_nodes_before.resize(vbd_->shifts_before.count);
    get_copies(state);
    vbd_->shifts_before.room.download(state.virtual_nodes_before);
  }

  void get_nodes(std::span<const int> slots, State& state) override {
    looked_at_.get(run_, nodes_.view(), slots, state);
  }
  void get_copies(State& state) const override {
    if (vbd_) vbd_->shifts.room.download(state.virtual_nodes);
  }
  std::vector<int> find_places(std::span<const SurfaceSample> places, std::uint64_t version,
                               std::span<const Ball> balls) override {
    return looked_at_.find(run_, nodes_.view().nodes, places, version, balls);
  }

  StepReport step(const Model& model, const State& known, bool smooth, const Inputs& inputs,
                  double dt) override {
    put_loads(inputs.loads);
    StepMarks marks;
    nodes_.marks.upload({&marks, 1});
    StepReport report = vbd_ ? step_descent(model, known, smooth, inputs, dt) : step_pbd(model, inputs, dt);
    nodes_.marks.download({&marks, 1});
    const Real speed2 = std::bit_cast<Real>(marks.largest);
    if (std::isfinite(speed2)) {
      report.largest_speed = std::sqrt(speed2);
      return report;
    }
    run_(std::size_t(nodes_.view().slots), GoBackSlot{nodes_.view()});
    if (vbd_) {
      const VbdView view = vbd_->view(model, nodes_, inputs, dt);
      run_(std::size_t(view.virtual_node_count), GoBackCopy{view});
    }
    return {.finite = false};
  }

  std::optional<DeviceResampled> resample(const Exec& exec, const Model& model, const State& cuts,
                                          const CtVolume& ct, const Grid& grid,
                                          const ResampleOptions& options) override {
    std::optional<DeviceResampled> now =
        resampled_.make(run_, exec, model, cuts, to_resample(), ct, grid, options);
    if (!now) resampled_ = {};
    return now;
  }
  bool get_displacement(const Model& model, const State& cuts, const Grid& grid,
                        std::span<Vec3> samples) override {
    return get_field(model, cuts, grid, DisplacementOfVoxel{model.grid, grid}, samples);
  }
  bool get_jacobian(const Model& model, const State& cuts, const Grid& grid,
                    std::span<float> samples) override {
    return get_field(model, cuts, grid, JacobianOfVoxel{}, samples);
  }

 private:
  BodyToResample to_resample() const {
    BodyToResample body{nodes_.view().nodes, nodes_.removed.data(), nullptr, 0};
    if (vbd_) body.shifts = vbd_->shifts.data(), body.shift_count = vbd_->shifts.count;
    return body;
  }
  template <class Of, class Sample>
  bool get_field(const Model& model, const State& cuts, const Grid& grid, const Of& of,
                 std::span<Sample> samples) {
    const bool made = resampled_.get_field(run_, model, cuts, to_resample(), grid, of, samples);
    if (!made) resampled_ = {};
    return made;
  }
  void put_loads(std::span<const NodeLoad> loads) {
    std::vector<NodeLoad> by_slot(loads.begin(), loads.end());
    std::stable_sort(by_slot.begin(), by_slot.end(),
                     [](const NodeLoad& a, const NodeLoad& b) { return a.slot < b.slot; });
    loads_.put(by_slot);
  }

  StepReport step_pbd(const Model& model, const Inputs& inputs, double dt) {
    TURGOR_ASSERT(inputs.contacts.empty(), "contacts press with newtons, which projections do not know");
    run_together(run_, [&] {
      step_pbd_with(run_, pbd_->view(model, nodes_), loads_.values(), lattice_gravity(model, inputs),
                    model.params.solver, dt);
    });
    return {};
  }

  StepReport step_descent(const Model& model, const State& known, bool smooth, const Inputs& inputs,
                          double dt) {
    vbd_->keep_pull(model);
    if (smooth) coarse_->put(model, known);
    vbd_->contacts.put(inputs.contacts);
    VbdView view = vbd_->view(model, nodes_, inputs, dt), ahead = view;
    const auto parts = std::size_t(residuals_of_groups(view) + view.virtual_nodes_of.begin[kColorCount]);
    if (inputs.measure_residual) {
      vbd_->residual.fit(2 * parts);
      ahead.residual = vbd_->residual.data(), view.residual = ahead.residual + parts;
    }
    const Real wild = wild_from(model, Real(dt));
    const bool held = model.free_nodes < model.body_nodes;
    run_together(run_, [&] {
      predict_descent_with(run_, view, loads_.values(), {held, held && 2 * known.fastest > wild ? wild : 0});
      if (inputs.measure_residual) measure_residual_with(run_, ahead);
      sweep_and_finish_descent_with(run_, view, model.params.solver, dt, [&] {
        if (smooth) correct_smooth_part_with(run_, view, coarse_->view(model));
      });
    });
    StepReport report;
    if (inputs.measure_residual) report.residual = residual(model, parts);
    vbd_->contacts.room.download(inputs.contacts);
    return report;
  }

  /// Before the sweeps and after them, of so many parts each.
  Residual residual(const Model& model, std::size_t count) const {
    std::vector<PartOfResidual> parts(2 * count);
    vbd_->residual.room.download(parts);
    PartOfResidual all[2];
    for (std::size_t n = 0; n < parts.size(); n++) {
      PartOfResidual& sum = all[n / count];
      sum.largest2 = std::max(sum.largest2, parts[n].largest2), sum.sum2 += parts[n].sum2;
    }
    const auto rms = [&](double sum2) { return std::sqrt(sum2 / std::max(1, model.free_nodes)); };
    return {.largest = std::sqrt(all[1].largest2), .rms = rms(all[1].sum2), .before = rms(all[0].sum2)};
  }

  typename Side::Run run_;
  DeviceNodes<Side> nodes_;
  std::optional<DevicePbd<Side>> pbd_;
  std::optional<DeviceVbd<Side>> vbd_;
  std::optional<DeviceCoarse<Side>> coarse_;
  DeviceList<Side, NodeLoad> loads_;
  DeviceReadback<Side> looked_at_;
  DeviceResampling<Side> resampled_;
};

}  // namespace turgor::lattice
