#include <atomic>
#include <bit>
#include <cmath>

#include "turgor/core/hash.hpp"
#include "turgor/models/cloth/model/fields.hpp"
#include "turgor/models/cloth/solver/motion_kernels.hpp"
#include "turgor/models/cloth/solver/strain_limit.hpp"
#include "turgor/models/cloth/solver/system.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 64;  // batches

template <class Loop>
void for_batches(const Exec& exec, const State& state, const Loop& loop) {
  parallel_for(exec, state.v.size() / std::size_t(kLanes), loop, kGrain);
}

/// Not finite when any velocity is not: bit patterns of positive numbers are in order, and those of no
/// numbers come last.
Real largest_speed(const Exec& exec, const State& state) {
  std::atomic<std::uint32_t> largest{0};
  exec.run_ranges(state.v.size(), kGrain * std::size_t(kLanes), [&](std::size_t begin, std::size_t end) {
    std::uint32_t found = 0;
    for (std::size_t i = begin; i < end; i++) {
      const Vec3 v = state.v[i];
      const std::uint32_t bits = std::bit_cast<std::uint32_t>(dot(v, v)) & 0x7fffffffu;
      found = bits > found ? bits : found;
    }
    std::uint32_t seen = largest.load();
    while (seen < found && !largest.compare_exchange_weak(seen, found)) {
    }
  });
  return std::sqrt(std::bit_cast<Real>(largest.load()));
}

/// `from` is where the cloth was when the step began.
void move(const Exec& exec, State& state, Vectors& from, Real dt) {
  for_batches(exec, state,
              Move<Lanes>{view(state.x), view(state.v), view(from), view(state.system.before), dt});
  for (const Hold& hold : state.holds) state.x.set(std::size_t(hold.vertex), hold.goal);
}

/// The two-step formula asks for x = 4/3 x₁ − 1/3 x₀ + 2/3 dt v, and v likewise: that is backward Euler by
/// 2/3 dt from where the two steps before lead. Returns the time of that step; all of dt where there is none
/// before.
double lead_on(const Exec& exec, State& state, double dt) {
  Bdf2History& last = state.last;
  const bool leads = last.dt == dt;
  last.dt = dt;
  last.x.resize(state.x.size()), last.v.resize(state.v.size());
  for_batches(exec, state, LeadOn<Lanes>{view(state.x), view(last.x), leads});
  for_batches(exec, state, LeadOn<Lanes>{view(state.v), view(last.v), leads});
  return leads ? dt * 2 / 3 : dt;
}

void lay_to_rest(State& state) {
  for (auto* values : {&state.v.x, &state.v.y, &state.v.z})
    std::fill(values->begin(), values->end(), Real(0));
  if (state.last.dt > 0) state.x = state.last.x;
  state.last.dt = 0;
  state.contacts.list.clear();
  state.contacts.begin.clear();
  state.largest_speed = 0;
}

}  // namespace

StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double frame) {
  StepReport report;
  const bool two_steps = model.params.solver.integrator == Integrator::kBdf2;
  const double dt = state.impulse_time = two_steps ? lead_on(exec, state, frame) : frame;
  assemble(exec, model, state, inputs, dt);
  if (uses_gradients(model.params.solver.method)) find_implicit_contacts(exec, model, state, inputs, dt);
  solve_change(exec, model, state, dt);
  if (uses_gradients(model.params.solver.method)) solve_what_turned(exec, model, state, inputs, dt);
  if (uses_gradients(model.params.solver.method))
    report.iterations = state.system.iterations, report.residual = state.system.residual;
  else if (inputs.measure_residual)
    report.residual = residual(exec, model, state);
  for_batches(exec, state, ChangeVelocities<Lanes>{view(state.v), view(state.system.change)});
  if (model.params.solver.strain_limit > 0) limit_strain(exec, model, state, dt);
  state.largest_speed = largest_speed(exec, state);
  if (uses_gradients(model.params.solver.method) && !std::isfinite(state.system.residual))
    state.largest_speed = NAN;  // they did not begin
  if (std::isfinite(state.largest_speed)) {
    find_contacts(exec, model, state, inputs, dt);
    report.contact_iterations = solve_velocities(exec, model, state, dt);
    state.largest_speed = largest_speed(exec, state);
  }
  report.finite = std::isfinite(state.largest_speed);
  report.largest_speed = state.largest_speed;
  report.contacts = int(state.contacts.list.size());
  if (!report.finite) {
    lay_to_rest(state);
    return report;
  }
  move(exec, state, two_steps ? state.last.x : state.x, Real(dt));
  solve_places(exec, model, state, dt);
  if (model.params.collision.self) report.in_impact_zone = resolve_ccd(exec, model, state);
  state.time += frame;
  return report;
}

TriMesh model_surface(const Model& model, const State& state) {
  TriMesh mesh{.triangles = model.triangles};
  for (int v = 0; v < model.count; v++) mesh.vertices.push_back(state.x[std::size_t(v)]);
  return mesh;
}

TriMesh surface(const Model& model, const State& state, std::vector<Int3> mesh_triangles) {
  const std::vector<Vec3> normals = vertex_normals(model_surface(model, state));  // smooth over welded seams
  TriMesh mesh{.triangles = std::move(mesh_triangles)};
  for (const int v : model.place) {
    mesh.vertices.push_back(state.x[std::size_t(v)]);
    mesh.normals.push_back(normals[std::size_t(v)]);
  }
  return mesh;
}

std::vector<Vec3> displacements(const Model& model, const State& state) {
  std::vector<Vec3> moved;
  for (const int v : model.place) moved.push_back(state.x[std::size_t(v)] - model.x_rest[std::size_t(v)]);
  return moved;
}

std::uint64_t state_hash(const Model& model, const State& state) {
  return hash_of_fields(state, 0, std::size_t(model.count), kHashSeed);
}

}  // namespace turgor::cloth
