// Sheet on the device: model and one state in device arrays, and the steps of step.cpp by sweeps. Backend is
// GpuBackend (gpu_sheet.cu); tests use one that runs on the host in shuffled order. Only explicit calls
// transfer data.
#pragma once

#include <bit>
#include <cmath>
#include <span>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/device/device_ccd.hpp"
#include "turgor/models/cloth/device/device_components.hpp"
#include "turgor/models/cloth/device/device_contacts.hpp"
#include "turgor/models/cloth/device/device_mesh.hpp"
#include "turgor/models/cloth/device/device_readback.hpp"
#include "turgor/models/cloth/device/device_state.hpp"
#include "turgor/models/cloth/forces/wind.hpp"
#include "turgor/models/cloth/model/contacts.hpp"
#include "turgor/models/cloth/solver/motion_kernels.hpp"
#include "turgor/models/cloth/step_sequence.hpp"

namespace turgor::cloth {

template <class Backend>
class DeviceSheet final : public SheetBackend {
 public:
  DeviceSheet(const Model& m, DeviceAllocator<Backend>& allocator)
      : rows_(allocator, m.rows),
        far_(allocator, m.far_rows),
        extra_diagonal_(allocator.copy(m.extra_diagonal)),
        x_rest_(allocator, m.mass.size()),
        triangles_(allocator, m),
        components_(allocator, m),
        x_(allocator, m.mass.size()),
        v_(allocator, m.mass.size()),
        history_x_(allocator, history_size(m)),
        history_v_(allocator, history_size(m)),
        free_mass_(allocator.copy(m.mass)),
        along_(allocator.template allocate<Real>(m.rows.stiffness.size())),
        across_(allocator.template allocate<Real>(m.rows.stiffness.size())),
        force_(allocator, m.mass.size()),
        inverse_{{allocator, m.mass.size()}, {allocator, m.mass.size()}},
        change_(allocator, m.mass.size()),
        previous_(allocator, m.mass.size()),
        air_{{allocator, m.mass.size()}, {allocator, m.mass.size()}},
        squares_(allocator.template allocate<ResidualSquares>((m.mass.size() + kSquaresAtOnce - 1) /
                                                              kSquaresAtOnce)),
        largest_(allocator.template allocate<std::uint32_t>(1)),
        contacts_(allocator, m),
        ccd_(allocator, m) {
    if (allocator.all_allocated) x_rest_.upload(m.x_rest), components_.set_held(m, {});
  }

  void upload_state(const Model&, const State& state) override {
    TURGOR_CHECK(state.x.size() == size() && state.v.size() == size(),
                 "a state has the vertices of its model");
    x_.upload(state.x), v_.upload(state.v);
    if (state.history.dt > 0) history_x_.upload(state.history.x), history_v_.upload(state.history.v);
    contacts_.upload(run_, state.contacts);
  }
  void download_state(State& state) const override {
    x_.download(state.x), v_.download(state.v);
    contacts_.download(state.contacts);
    if (history_x_.x.size() == 0) return;
    for (Vectors* last : {&state.history.x, &state.history.v}) last->resize(history_x_.x.size());
    history_x_.download(state.history.x), history_v_.download(state.history.v);
  }

  void download_vertices(std::span<const int> vertices, State& state) override {
    readback_.download_vertices(run_, cloth::view(x_), cloth::view(v_), vertices, state);
  }
  void download_loads(const Model& model, Contacts& contacts) override {
    contacts.list = readback_.download_loads(run_, contacts_.values(), holds_.values());
    list_by_vertex(model.count, contacts);
  }

  StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                  double frame) override {
    TURGOR_CHECK(is_step_length(frame), "a step has a positive length");
    Step step{*this, exec, model, state, inputs, frame};
    try {
      step_sweeps(step);
    } catch (const OutOfDeviceMemory&) {
      step.rewind();
      throw;
    }
    return step.report;
  }

 private:
  /// Phases of a step (step_sequence.hpp).
  struct Step {
    DeviceSheet& sheet;
    const Exec& exec;
    const Model& model;
    State& state;
    const Inputs& inputs;
    double frame, dt = 0;  // [s]; dt is shorter with BDF2
    StepReport report = {};
    bool has_predicted = false, has_new_velocities = false;
    Real largest_speed_before = state.largest_speed;  // [m/s]

    void predict() {
      sheet.take_holds(model, state);
      has_predicted = true;
      dt = state.impulse_time = sheet.predict_bdf2(model.params.solver, state, frame);
    }
    void assemble() { sheet.assemble(model, state, inputs, dt); }
    void start_change() { sheet.start_change(model, dt); }
    void sweep() { sheet.sweep(model.params.solver); }
    void measure_residual() {
      if (inputs.measure_residual) report.residual = sheet.residual();
    }
    void change_velocities() {
      // after the solution, the right-hand side is a workspace
      sheet.run_(sheet.size(), ChangeVelocitiesReversibly{cloth::view(sheet.v_), cloth::view(sheet.change_),
                                                          cloth::view(sheet.force_)});
      has_new_velocities = true;
    }
    void limit_strain() {
      if (model.params.solver.strain_limit > 0) sheet.limit_strain(model, dt);
    }
    void measure_speed() { state.largest_speed = report.largest_speed = sheet.largest_speed(); }
    void solve_contact_impulses() {
      if (!model.params.collision.self && inputs.obstacles.empty()) {
        sheet.contacts_.clear();
      } else if (is_finite()) {
        sheet.find_contacts(model, state, inputs, dt);
        report.contacts = int(sheet.contacts_.count());
        report.contact_iterations = sheet.contacts_.solve_velocities(sheet.run_, model, sheet.view(), dt);
        state.largest_speed = report.largest_speed = sheet.largest_speed();
      }
      report.finite = is_finite();
    }
    bool is_finite() const { return std::isfinite(state.largest_speed); }
    void undo() { sheet.restore_last_state(state); }
    /// Restores the state before the step. Its search of contacts lacked memory, so positions are those of
    /// the predictor. A predicted state loses its history.
    void rewind() {
      state.largest_speed = largest_speed_before;
      if (has_predicted && model.params.solver.integrator == Integrator::kBdf2) {
        sheet.run_(sheet.size(), CopyVectors{cloth::view(sheet.history_x_), cloth::view(sheet.x_)});
        sheet.run_(sheet.size(), CopyVectors{cloth::view(sheet.history_v_), cloth::view(sheet.v_)});
        state.history.dt = 0;
      } else if (has_new_velocities) {
        sheet.run_(sheet.size(), CopyVectors{cloth::view(sheet.force_), cloth::view(sheet.v_)});
      }
    }
    void move() { sheet.move(model, dt); }
    void solve_positions() { sheet.contacts_.solve_positions(sheet.run_, model, sheet.view(), dt); }
    void resolve_ccd() {
      if (model.params.collision.self) report.in_impact_zone = sheet.run_ccd(exec, model, state);
    }
    void advance_time() { state.time += frame; }
  };

  static std::size_t history_size(const Model& m) {
    return m.params.solver.integrator == Integrator::kBdf2 ? m.mass.size() : 0;
  }
  std::size_t size() const { return free_mass_.size(); }
  SheetView view() const {
    return {.size = size(),
            .rows = rows_.view(),
            .far = far_.view(),
            .extra_diagonal = data_or_null(extra_diagonal_),
            .x_rest = cloth::view(x_rest_),
            .x = cloth::view(x_),
            .v = cloth::view(v_),
            .free_mass = free_mass_.data(),
            .along = along_.data(),
            .across = across_.data(),
            .force = cloth::view(force_),
            .inverse = {cloth::view(inverse_[0]), cloth::view(inverse_[1])},
            .change = cloth::view(change_),
            .previous = cloth::view(previous_),
            .air = {cloth::view(air_[0]), cloth::view(air_[1])},
            .stiffness_factor = stiffness_factor_};
  }

  /// Uploads goals in every step; masses and components only when other vertices are held.
  void take_holds(const Model& model, const State& state) {
    holds_.assign(state.holds);
    std::vector<int> held;
    for (const Hold& hold : state.holds) held.push_back(hold.vertex);
    if (held == held_) return;
    held_ = std::move(held);
    free_mass_.upload(state.free_mass);
    components_.set_held(model, state.holds);
  }

  /// BDF2 predictor (step.cpp). Returns the step of backward Euler.
  double predict_bdf2(const Solver& solver, State& state, double frame) {
    if (solver.integrator != Integrator::kBdf2) return frame;
    const bool has_history = state.history.dt == frame;
    state.history.dt = frame;
    run_(size(), PredictBdf2<Real>{cloth::view(x_), cloth::view(history_x_), has_history});
    run_(size(), PredictBdf2<Real>{cloth::view(v_), cloth::view(history_v_), has_history});
    return has_history ? frame * 2 / 3 : frame;
  }

  void assemble(const Model& model, const State& state, const Inputs& inputs, double dt) {
    // factors of mass and stiffness
    const Damping& damping = model.params.damping;
    const Air& air = inputs.air;
    has_air_ = air.density > 0;
    mass_factor_ = Real(1 + dt * damping.motion), stiffness_factor_ = Real(dt * dt + dt * damping.stretch);
    // wind
    if (has_air_) {
      run_(size(), AirAt<Real>{cloth::view(x_), cloth::view(v_), cloth::view(change_),
                               gusts_at(air, state.time), is_steady(air)});
      const WindTriangles all =
          wind_triangles(air, dt, triangles_.corners.data(), cloth::view(x_), cloth::view(change_),
                         cloth::view(force_), cloth::view(inverse_[0]), cloth::view(inverse_[1]));
      run_(size(), BlowVertex{all, triangles_.around()});
      components_.sum_drag(run_, view());
    }
    // forces and matrix
    if (model.params.fabric.law == Law::kSheet)
      run_(size(), TensionsAround{view(), triangles_.view(), triangles_.around()});
    run_(size(), AssembleRow<Real>{view(), Vec3(inputs.gravity), Real(dt), Real(dt * damping.motion),
                                   has_air_, inputs.measure_residual, false});
    // warm start and held vertices
    contacts_.add_impulses(run_, view());
    run_(holds_.count, AimHolds{view(), holds_.data(), Real(dt)});
  }

  void start_change(const Model& model, double dt) {
    components_.start(run_, view(), 1 + dt * model.params.damping.motion, has_air_);
    run_(holds_.count, StartHolds{view(), holds_.data()});
  }
  void sweep(const Solver& solver) {
    run_sweeps(
        solver.method == Method::kChebyshev, solver.sweeps,
        [&](Real omega) {
          run_(size(), SweepRow<Real>{view(), omega});
          std::swap(change_, previous_);
        },
        [&] {
          run_(size(), CopyVectors{cloth::view(change_), cloth::view(previous_)});
        });
  }
  void limit_strain(const Model& model, double dt) {
    for (int pass = 0; pass < kStrainPasses; pass++) {
      run_(size(), LimitStrain<Real>{view(), cloth::strain_limit(model), Real(dt)});
      std::swap(v_, previous_);
    }
  }
  void move(const Model& model, double dt) {
    const bool two_steps = model.params.solver.integrator == Integrator::kBdf2;
    run_(size(), Move<Real>{cloth::view(x_), cloth::view(v_), cloth::view(two_steps ? history_x_ : x_),
                            cloth::view(previous_), Real(dt)});
    run_(holds_.count, MoveHolds{view(), holds_.data()});
  }

  double residual() {
    run_(squares_.size(), SumSquares{view(), mass_factor_, squares_.data()});
    std::vector<ResidualSquares> sums(squares_.size());
    squares_.download(sums);
    ResidualSquares all;
    for (const ResidualSquares& sum : sums) all.force += sum.force, all.residual += sum.residual;
    return all.force > 0 ? std::sqrt(all.residual / all.force) : 0;
  }

  /// Handles pairs of earlier CCD on the host, since they are rare.
  void find_contacts(const Model& model, State& state, const Inputs& inputs, double dt) {
    std::vector<Contact> ccd_contacts;
    if (!state.ccd.recent_pairs.empty() || !state.ccd.ccd_pairs.empty()) {
      download(state.x, x_), download(state.v, v_), download(state.system.change, change_);
      contacts_.download(state.contacts);
      find_ccd_contacts(model, state, ContactPhase::kActual, dt, ccd_contacts);
      clear_host(state);
    }
    contacts_.find(run_, model, view(), triangles_.corners.data(), inputs.obstacles, state.largest_speed, dt,
                   ccd_contacts);
  }

  /// Runs CCD; if anything collides, resolve_ccd on the host.
  int run_ccd(const Exec& exec, const Model& model, State& state) {
    CcdWorkspace& ccd = state.ccd;
    if (ccd.steps_until_check < 0 &&
        !ccd_.any_collision(run_, view(), triangles_.corners.data(), triangles_.around(),
                            model.params.collision.thickness)) {
      ccd.ccd_pairs.clear(), ccd.in_impact_zone.clear(), ccd.zone.clear();
      return 0;
    }
    download(state.x, x_), download(state.v, v_), download(state.system.previous, previous_);
    const int in_impact_zone = resolve_ccd(exec, model, state);
    if (in_impact_zone > 0) x_.upload(state.x), v_.upload(state.v);
    clear_host(state);
    return in_impact_zone;
  }
  static void download(Vectors& host, const DeviceVectors<Backend>& device) {
    host.resize(device.x.size());
    device.download(host);
  }
  static void clear_host(State& state) { state.x.resize(0), state.v.resize(0); }

  Real largest_speed() {
    std::uint32_t bits = 0;
    largest_.upload({&bits, 1});
    run_(size(), FindLargestSpeed{cloth::view(v_), largest_.data()});
    largest_.download({&bits, 1});
    return std::sqrt(std::bit_cast<Real>(bits));
  }

  void restore_last_state(State& state) {
    run_(size(), ClearVectors{cloth::view(v_)});
    if (state.history.dt > 0) run_(size(), CopyVectors{cloth::view(history_x_), cloth::view(x_)});
    state.history.dt = 0;
    state.largest_speed = 0;
    contacts_.clear();
  }

  typename Backend::Run run_{};
  DeviceRows<Backend> rows_, far_;
  typename Backend::template Array<Real> extra_diagonal_;
  DeviceVectors<Backend> x_rest_;
  DeviceTriangles<Backend> triangles_;
  DeviceComponents<Backend> components_;
  DeviceVectors<Backend> x_, v_, history_x_, history_v_;
  typename Backend::template Array<Real> free_mass_, along_, across_;
  DeviceVectors<Backend> force_, inverse_[2], change_, previous_, air_[2];
  typename Backend::template Array<ResidualSquares> squares_;
  typename Backend::template Array<std::uint32_t> largest_;
  DeviceContacts<Backend> contacts_;
  DeviceCcd<Backend> ccd_;
  DeviceReadback<Backend> readback_;
  DeviceList<Backend, Hold> holds_;
  std::vector<int> held_;  // vertices
  Real stiffness_factor_ = 0, mass_factor_ = 1;
  bool has_air_ = false;
};

}  // namespace turgor::cloth
