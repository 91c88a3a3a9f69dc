// A sheet on one side of a bus or the other: its model and one state in arrays of that side, and its steps by
// that side's run: those of step.cpp by sweeps. A side is GpuSide (gpu_sheet.cu); tests have one that is the
// host, in a shuffled order. Nothing goes over or back but what is told to.
#pragma once

#include <bit>
#include <cmath>
#include <span>

#include "turgor/core/arrays_on.hpp"
#include "turgor/models/cloth/contacts_on.hpp"
#include "turgor/models/cloth/guard_on.hpp"
#include "turgor/models/cloth/kept_state.hpp"
#include "turgor/models/cloth/membrane_tension.hpp"
#include "turgor/models/cloth/motion_loops.hpp"
#include "turgor/models/cloth/part_loops.hpp"

namespace turgor::cloth {

/// Of no length: nobody looks at it.
template <class Array>
auto* data_or_null(const Array& array) {
  return array.size() > 0 ? array.data() : nullptr;
}

template <class Side>
struct RowsOn {
  typename Side::template Array<int> slot_begin, first, gathered;
  typename Side::template Array<Real> rest, stiffness, bend;

  RowsOn(Rooms<Side>& rooms, const Rows& rows)
      : slot_begin(rooms.copy(rows.slot_begin)),
        first(rooms.copy(rows.first)),
        gathered(rooms.copy(rows.gathered)),
        rest(rooms.copy(rows.rest)),
        stiffness(rooms.copy(rows.stiffness)),
        bend(rooms.copy(rows.bend)) {}
  RowsView view() const {
    return {data_or_null(slot_begin), data_or_null(first),     data_or_null(gathered),
            data_or_null(rest),       data_or_null(stiffness), data_or_null(bend)};
  }
};

template <class Side>
VectorsView view(const VectorsOn<Side>& a) {
  return {a.x.data(), a.y.data(), a.z.data()};
}

/// The triangles of each vertex, and what the membrane knows of them.
template <class Side>
struct TrianglesOn {
  template <class T>
  using Array = typename Side::template Array<T>;

  Array<Int3> corners;
  Array<int> begin, item;  // by vertex, ascending
  MembraneLaw law;
  Array<Real> second[2], third[2];
  Array<std::array<std::uint8_t, 6>> slot;
  Array<std::array<std::uint16_t, 6>> wide_slot;

  TrianglesOn(Rooms<Side>& rooms, const Model& m)
      : TrianglesOn(rooms, m, lists_around(m.triangles, m.mass.size())) {}
  TrianglesOn(Rooms<Side>& rooms, const Model& m, const NeighbourLists& lists)
      : corners(rooms.copy(m.triangles)),
        begin(rooms.copy(lists.begin)),
        item(rooms.copy(lists.item)),
        law(m.membrane.law),
        second{rooms.copy(m.membrane.second[0]), rooms.copy(m.membrane.second[1])},
        third{rooms.copy(m.membrane.third[0]), rooms.copy(m.membrane.third[1])},
        slot(rooms.copy(m.membrane.slot)),
        wide_slot(rooms.copy(m.membrane.wide_slot)) {}

  static NeighbourLists lists_around(std::span<const Int3> triangles, std::size_t size) {
    NeighbourLists lists;
    lists.begin.assign(size + 2, 0);  // shifted by one while it is filled
    for (const Int3 t : triangles)
      for (int k = 0; k < 3; k++) lists.begin[std::size_t(t[k]) + 2]++;
    for (std::size_t v = 2; v < lists.begin.size(); v++) lists.begin[v] += lists.begin[v - 1];
    lists.item.resize(3 * triangles.size());
    for (std::size_t t = 0; t < triangles.size(); t++)
      for (int k = 0; k < 3; k++)
        lists.item[std::size_t(lists.begin[std::size_t(triangles[t][k]) + 1]++)] = int(t);
    lists.begin.pop_back();
    return lists;
  }
  TrianglesAround around() const { return {begin.data(), item.data()}; }
  MembraneView view() const {
    return {law,
            corners.data(),
            {second[0].data(), second[1].data()},
            {third[0].data(), third[1].data()},
            slot.data(),
            data_or_null(wide_slot)};
  }
};

/// The parts of a sheet, those that nothing holds with their masses.
template <class Side>
class PartsOn {
 public:
  PartsOn(Rooms<Side>& rooms, const Model& m) : PartsOn(rooms, m, parts_of(m), pieces_of(m)) {}

  /// Which of them are held. The force's sums come from what is not.
  void keep(const Model& m, std::span<const Hold> holds) {
    any_free_ = false;
    for (std::size_t p = 0; p < whole_.size(); p++) {
      const auto at = std::lower_bound(holds.begin(), holds.end(), m.part_begin[p],
                                       [](const Hold& h, int v) { return h.vertex < v; });
      const bool is_held = at != holds.end() && at->vertex < m.part_begin[p + 1];
      whole_[p].mass = is_held ? 0 : masses_[p];
      any_free_ = any_free_ || !is_held;
    }
    parts_.upload(whole_);
  }
  template <class Run>
  void sum_drag(const Run& run, const SheetView& sheet) {
    if (any_free_) run(pieces_.size(), SumDrag{pieces_.data(), sheet.inverse[0], sums_.data()});
  }
  template <class Run>
  void start(const Run& run, const SheetView& sheet, double keep, bool has_air) {
    if (any_free_) {
      run(pieces_.size(), SumForce{pieces_.data(), sheet.force, sums_.data()});
      run(parts_.size(), FindPartVelocity{parts_.data(), sums_.data(), keep, has_air, velocity_.data()});
    }
    run(sheet.size, StartChange{sheet, part_of_.data(), any_free_ ? velocity_.data() : nullptr});
  }

 private:
  static constexpr int kPiece = 512;

  PartsOn(Rooms<Side>& rooms, const Model& m, std::vector<int> part_of, std::vector<PartPiece> pieces)
      : part_of_(rooms.copy(part_of)),
        pieces_(rooms.copy(pieces)),
        sums_(rooms.template room<PartSum>(pieces.size())),
        velocity_(rooms.template room<Vec3>(m.part_begin.size() - 1)),
        parts_(rooms.template room<WholePart>(m.part_begin.size() - 1)) {
    int piece = 0;
    for (std::size_t p = 0; p + 1 < m.part_begin.size(); p++) {
      const int begin = m.part_begin[p], end = m.part_begin[p + 1];
      const int count = (end - begin + kPiece - 1) / kPiece;
      whole_.push_back({piece, piece + count, 0});
      piece += count;
      double mass = 0;
      for (int v = begin; v < end; v++) mass += double(m.mass[std::size_t(v)]);
      masses_.push_back(mass);
    }
  }
  static std::vector<int> parts_of(const Model& m) {
    std::vector<int> of(m.mass.size(), -1);
    for (std::size_t p = 0; p + 1 < m.part_begin.size(); p++)
      std::fill(of.begin() + m.part_begin[p], of.begin() + m.part_begin[p + 1], int(p));
    return of;
  }
  static std::vector<PartPiece> pieces_of(const Model& m) {
    std::vector<PartPiece> pieces;
    for (std::size_t p = 0; p + 1 < m.part_begin.size(); p++)
      for (int v = m.part_begin[p]; v < m.part_begin[p + 1]; v += kPiece)
        pieces.push_back({v, std::min(v + kPiece, m.part_begin[p + 1])});
    return pieces;
  }

  typename Side::template Array<int> part_of_;
  typename Side::template Array<PartPiece> pieces_;
  typename Side::template Array<PartSum> sums_;
  typename Side::template Array<Vec3> velocity_;
  typename Side::template Array<WholePart> parts_;
  std::vector<WholePart> whole_;
  std::vector<double> masses_;  // [kg]
  bool any_free_ = true;
};

template <class Side>
class SheetOn final : public SheetThere {
 public:
  SheetOn(const Model& m, Rooms<Side>& rooms)
      : rows_(rooms, m.rows),
        far_(rooms, m.far_rows),
        spare_(rooms.copy(m.spare)),
        x_rest_(rooms, m.mass.size()),
        triangles_(rooms, m),
        parts_(rooms, m),
        x_(rooms, m.mass.size()),
        v_(rooms, m.mass.size()),
        last_x_(rooms, last_size(m)),
        last_v_(rooms, last_size(m)),
        free_mass_(rooms.copy(m.mass)),
        along_(rooms.template room<Real>(m.rows.stiffness.size())),
        across_(rooms.template room<Real>(m.rows.stiffness.size())),
        force_(rooms, m.mass.size()),
        inverse_{{rooms, m.mass.size()}, {rooms, m.mass.size()}},
        change_(rooms, m.mass.size()),
        before_(rooms, m.mass.size()),
        air_{{rooms, m.mass.size()}, {rooms, m.mass.size()}},
        squares_(rooms.template room<LeftSquares>((m.mass.size() + kSquaresAtOnce - 1) / kSquaresAtOnce)),
        largest_(rooms.template room<std::uint32_t>(1)),
        contacts_(rooms, m),
        guard_(rooms, m) {
    if (rooms.all_there) x_rest_.upload(m.x_rest), parts_.keep(m, {});
  }

  void put_state(const Model&, const State& state) override {
    x_.upload(state.x), v_.upload(state.v);
    if (state.last.dt > 0) last_x_.upload(state.last.x), last_v_.upload(state.last.v);
    contacts_.put(run_, state.contacts);
  }
  void get_state(State& state) const override {
    x_.download(state.x), v_.download(state.v);
    contacts_.get(state.contacts);
    if (last_x_.x.size() == 0) return;
    for (Vectors* last : {&state.last.x, &state.last.v}) last->resize(last_x_.x.size());
    last_x_.download(state.last.x), last_v_.download(state.last.v);
  }

  StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                  double frame) override {
    const Solver& solver = model.params.solver;
    take_holds(model, state);
    const double dt = state.impulse_time = lead_on(solver, state, frame);
    assemble(model, state, inputs, dt);
    solve(model, dt);
    StepReport report;
    if (inputs.measure_residual) report.residual = residual();
    run_(size(), ChangeVelocities<Real>{cloth::view(v_), cloth::view(change_)});
    if (solver.strain_limit > 0)
      for (int pass = 0; pass < kStrainPasses; pass++) {
        run_(size(), LimitStrain<Real>{view(), cloth::strain_limit(model), Real(dt)});
        std::swap(v_, before_);
      }
    state.largest_speed = report.largest_speed = largest_speed();
    const bool keeps_out = model.params.collision.self;
    if (keeps_out && std::isfinite(state.largest_speed)) {
      find_contacts(model, state, dt);
      report.contacts = int(contacts_.count());
      report.contact_iterations = contacts_.solve_velocities(run_, model, view(), dt);
      state.largest_speed = report.largest_speed = largest_speed();
    }
    report.finite = std::isfinite(state.largest_speed);
    if (!report.finite) {
      lay_to_rest(state);
      return report;
    }
    const bool two_steps = solver.integrator == Integrator::kBdf2;
    run_(size(), Move<Real>{cloth::view(x_), cloth::view(v_), cloth::view(two_steps ? last_x_ : x_),
                            cloth::view(before_), Real(dt)});
    run_(holds_.count, PlaceHolds{view(), holds_.data()});
    if (keeps_out) {
      contacts_.solve_places(run_, model, view(), dt);
      report.caught = guard(exec, model, state);
    }
    state.time += frame;
    return report;
  }

 private:
  static std::size_t last_size(const Model& m) {
    return m.params.solver.integrator == Integrator::kBdf2 ? m.mass.size() : 0;
  }
  std::size_t size() const { return free_mass_.size(); }
  SheetView view() const {
    return {.size = size(),
            .rows = rows_.view(),
            .far = far_.view(),
            .spare = data_or_null(spare_),
            .x_rest = cloth::view(x_rest_),
            .x = cloth::view(x_),
            .v = cloth::view(v_),
            .free_mass = free_mass_.data(),
            .along = along_.data(),
            .across = across_.data(),
            .force = cloth::view(force_),
            .inverse = {cloth::view(inverse_[0]), cloth::view(inverse_[1])},
            .change = cloth::view(change_),
            .before = cloth::view(before_),
            .air = {cloth::view(air_[0]), cloth::view(air_[1])},
            .square = square_};
  }

  /// Their goals in every step; masses and parts when others are held.
  void take_holds(const Model& model, const State& state) {
    holds_.put(state.holds);
    std::vector<int> held;
    for (const Hold& hold : state.holds) held.push_back(hold.vertex);
    if (held == held_) return;
    held_ = std::move(held);
    free_mass_.upload(state.free_mass);
    parts_.keep(model, state.holds);
  }

  /// Returns the time of the step.
  double lead_on(const Solver& solver, State& state, double frame) {
    if (solver.integrator != Integrator::kBdf2) return frame;
    const bool leads = state.last.dt == frame;
    state.last.dt = frame;
    run_(size(), LeadOn<Real>{cloth::view(x_), cloth::view(last_x_), leads});
    run_(size(), LeadOn<Real>{cloth::view(v_), cloth::view(last_v_), leads});
    return leads ? frame * 2 / 3 : frame;
  }

  void assemble(const Model& model, const State& state, const Inputs& inputs, double dt) {
    const Damping& damping = model.params.damping;
    const Air& air = inputs.air;
    has_air_ = air.density > 0;
    keep_ = Real(1 + dt * damping.motion), square_ = Real(dt * dt + dt * damping.stretch);
    if (has_air_) {
      run_(size(),
           AirAt<Real>{cloth::view(x_), cloth::view(change_), gusts_at(air, state.time), is_steady(air)});
      const Sails all =
          sails(air, dt, triangles_.corners.data(), cloth::view(x_), cloth::view(v_), cloth::view(change_),
                cloth::view(force_), cloth::view(inverse_[0]), cloth::view(inverse_[1]));
      run_(size(), BlowVertex{all, triangles_.around()});
      parts_.sum_drag(run_, view());
    }
    if (model.params.fabric.law == Law::kSheet)
      run_(size(), TensionsAround{view(), triangles_.view(), triangles_.around()});
    run_(size(), AssembleRow<Real>{view(), Vec3(inputs.gravity), Real(dt), Real(dt * damping.motion),
                                   has_air_, inputs.measure_residual});
    contacts_.add_impulses(run_, view());
    run_(holds_.count, AimHolds{view(), holds_.data(), Real(dt)});
  }

  void solve(const Model& model, double dt) {
    const Solver& solver = model.params.solver;
    parts_.start(run_, view(), 1 + dt * model.params.damping.motion, has_air_);
    run_(holds_.count, StartHolds{view(), holds_.data()});
    go_through_sweeps(
        solver.method == Method::kChebyshev, solver.sweeps,
        [&](Real omega) {
          run_(size(), SweepRow<Real>{view(), omega});
          std::swap(change_, before_);
        },
        [&] {
          run_(size(), CopyVectors{cloth::view(change_), cloth::view(before_)});
        });
  }

  double residual() {
    run_(squares_.size(), SumSquares{view(), keep_, squares_.data()});
    std::vector<LeftSquares> sums(squares_.size());
    squares_.download(sums);
    LeftSquares all;
    for (const LeftSquares& sum : sums) all.force += sum.force, all.left += sum.left;
    return all.force > 0 ? std::sqrt(all.left / all.force) : 0;
  }

  /// What would have met in steps before is looked for on this side of the bus: there is hardly any.
  void find_contacts(const Model& model, State& state, double dt) {
    std::vector<Contact> met;
    if (!state.crossing.met.empty() || !state.crossing.meetings.empty()) {
      bring(state.x, x_), bring(state.v, v_), bring(state.system.change, change_);
      contacts_.get(state.contacts);
      find_met_contacts(model, state, Look::kLeft, dt, met);
      forget(state);
    }
    contacts_.find(run_, model, view(), state.largest_speed, dt, met);
  }

  /// avoid_crossings, on this side of the bus, where anything would meet.
  int guard(const Exec& exec, const Model& model, State& state) {
    Crossing& crossing = state.crossing;
    if (crossing.steps_to_look < 0 &&
        !guard_.would_meet(run_, view(), triangles_.corners.data(), triangles_.around(),
                           model.params.collision.thickness)) {
      crossing.meetings.clear(), crossing.caught.clear(), crossing.zone.clear();
      return 0;
    }
    bring(state.x, x_), bring(state.v, v_), bring(state.system.before, before_);
    const int caught = avoid_crossings(exec, model, state);
    if (caught > 0) x_.upload(state.x), v_.upload(state.v);
    forget(state);
    return caught;
  }
  static void bring(Vectors& here, const VectorsOn<Side>& there) {
    here.resize(there.x.size());
    there.download(here);
  }
  static void forget(State& state) { state.x.resize(0), state.v.resize(0); }

  Real largest_speed() {
    std::uint32_t bits = 0;
    largest_.upload({&bits, 1});
    run_(size(), FindLargestSpeed{cloth::view(v_), largest_.data()});
    largest_.download({&bits, 1});
    return std::sqrt(std::bit_cast<Real>(bits));
  }

  void lay_to_rest(State& state) {
    run_(size(), ClearVectors{cloth::view(v_)});
    if (state.last.dt > 0) run_(size(), CopyVectors{cloth::view(last_x_), cloth::view(x_)});
    state.last.dt = 0;
    state.largest_speed = 0;
    contacts_.forget();
  }

  typename Side::Run run_{};
  RowsOn<Side> rows_, far_;
  typename Side::template Array<Real> spare_;
  VectorsOn<Side> x_rest_;
  TrianglesOn<Side> triangles_;
  PartsOn<Side> parts_;
  VectorsOn<Side> x_, v_, last_x_, last_v_;
  typename Side::template Array<Real> free_mass_, along_, across_;
  VectorsOn<Side> force_, inverse_[2], change_, before_, air_[2];
  typename Side::template Array<LeftSquares> squares_;
  typename Side::template Array<std::uint32_t> largest_;
  ContactsOn<Side> contacts_;
  GuardOn<Side> guard_;
  ListOn<Side, Hold> holds_;
  std::vector<int> held_;  // vertices
  Real square_ = 0, keep_ = 1;
  bool has_air_ = false;
};

}  // namespace turgor::cloth
