// A sheet on one side of a bus or the other: its model and one state in arrays of that side, and its steps by
// that side's run: those of step.cpp by sweeps. A side is GpuSide (gpu_sheet.cu); tests have one that is the
// host, in a shuffled order. Nothing goes over or back but what is told to.
#pragma once

#include <bit>
#include <cmath>
#include <span>

#include "turgor/models/cloth/device/device_ccd.hpp"
#include "turgor/models/cloth/device/device_components.hpp"
#include "turgor/models/cloth/device/device_contacts.hpp"
#include "turgor/models/cloth/device/device_mesh.hpp"
#include "turgor/models/cloth/device/device_state.hpp"
#include "turgor/models/cloth/solver/motion_kernels.hpp"

namespace turgor::cloth {

template <class Side>
class DeviceSheet final : public SheetBackend {
 public:
  DeviceSheet(const Model& m, DeviceAllocator<Side>& rooms)
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
    if (rooms.all_allocated) x_rest_.upload(m.x_rest), parts_.keep(m, {});
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
    const bool self = model.params.collision.self;
    if (!self && inputs.obstacles.empty())
      contacts_.forget();
    else if (std::isfinite(state.largest_speed)) {
      find_contacts(model, state, inputs, dt);
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
    contacts_.solve_places(run_, model, view(), dt);
    if (self) report.in_impact_zone = guard(exec, model, state);
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
  void find_contacts(const Model& model, State& state, const Inputs& inputs, double dt) {
    std::vector<Contact> met;
    if (!state.ccd.met.empty() || !state.ccd.ccd_pairs.empty()) {
      bring(state.x, x_), bring(state.v, v_), bring(state.system.change, change_);
      contacts_.get(state.contacts);
      find_met_contacts(model, state, Look::kActual, dt, met);
      forget(state);
    }
    contacts_.find(run_, model, view(), triangles_.corners.data(), inputs.obstacles, state.largest_speed, dt,
                   met);
  }

  /// avoid_crossings, on this side of the bus, where anything would meet.
  int guard(const Exec& exec, const Model& model, State& state) {
    CcdWorkspace& ccd = state.ccd;
    if (ccd.steps_to_look < 0 && !guard_.would_meet(run_, view(), triangles_.corners.data(),
                                                    triangles_.around(), model.params.collision.thickness)) {
      ccd.ccd_pairs.clear(), ccd.in_impact_zone.clear(), ccd.zone.clear();
      return 0;
    }
    bring(state.x, x_), bring(state.v, v_), bring(state.system.before, before_);
    const int in_impact_zone = resolve_ccd(exec, model, state);
    if (in_impact_zone > 0) x_.upload(state.x), v_.upload(state.v);
    forget(state);
    return in_impact_zone;
  }
  static void bring(Vectors& here, const DeviceVectors<Side>& there) {
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
  DeviceRows<Side> rows_, far_;
  typename Side::template Array<Real> spare_;
  DeviceVectors<Side> x_rest_;
  DeviceTriangles<Side> triangles_;
  DeviceComponents<Side> parts_;
  DeviceVectors<Side> x_, v_, last_x_, last_v_;
  typename Side::template Array<Real> free_mass_, along_, across_;
  DeviceVectors<Side> force_, inverse_[2], change_, before_, air_[2];
  typename Side::template Array<LeftSquares> squares_;
  typename Side::template Array<std::uint32_t> largest_;
  DeviceContacts<Side> contacts_;
  DeviceCcd<Side> guard_;
  DeviceList<Side, Hold> holds_;
  std::vector<int> held_;  // vertices
  Real square_ = 0, keep_ = 1;
  bool has_air_ = false;
};

}  // namespace turgor::cloth
