#include <cmath>
#include <mutex>

#include "turgor/core/gpu_run.cuh"
#include "turgor/models/lattice/gpu_body.hpp"
#include "turgor/models/lattice/pbd_loops.hpp"
#include "turgor/models/lattice/sweeps.hpp"

namespace turgor::lattice {

namespace {

struct GpuVectors {
  GpuArray<Real> x, y, z;

  explicit GpuVectors(std::size_t slots) : x(slots), y(slots), z(slots) {}
  bool is_there() const { return x.is_there() && y.is_there() && z.is_there(); }
  void upload(const VecField& from) { x.upload(from.x), y.upload(from.y), z.upload(from.z); }
  void download(VecField& to) const { x.download(to.x), y.download(to.y), z.download(to.z); }
};

/// An array with what a vector holds.
template <class Values>
auto there(const Values& values) {
  using T = typename Values::value_type;
  GpuArray<T> array(values.size());
  if (array.is_there()) array.upload(std::span<const T>(values.data(), values.size()));
  return array;
}

}  // namespace

struct GpuBody {
  PbdSchedule schedule;
  PbdRules rules;
  GpuVectors u, u_before, v;
  GpuArray<Real> w, root;
  GpuArray<std::uint8_t> cut, removed, skin_cut;
  GpuArray<int> moving, joining, heads, next;
  GpuArray<SkinTriangle> triangles;
  GpuArray<std::uint32_t> largest;
  std::mutex in_use;

  explicit GpuBody(const Model& m)
      : schedule(pbd_schedule(m)),
        rules(pbd_rules(m)),
        u(m.inverse_mass.size()),
        u_before(m.inverse_mass.size()),
        v(m.inverse_mass.size()),
        w(there(m.inverse_mass)),
        root(there(m.root_stiffness)),
        cut(m.inverse_mass.size()),
        removed(m.inverse_mass.size()),
        skin_cut(m.skin.triangles.size()),
        moving(there(schedule.moving)),
        joining(there(schedule.joining)),
        heads(there(schedule.heads)),
        next(there(schedule.next)),
        triangles(there(m.skin.triangles)),
        largest(1) {}

  bool is_there() const {
    return u.is_there() && u_before.is_there() && v.is_there() && w.is_there() && root.is_there() &&
           cut.is_there() && removed.is_there() && skin_cut.is_there() && moving.is_there() &&
           joining.is_there() && heads.is_there() && next.is_there() && triangles.is_there() &&
           largest.is_there();
  }
  PbdView view() const {
    return {.rules = rules,
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
            .joining = joining.data(),
            .joining_of = schedule.joining_of,
            .triangles = triangles.data(),
            .skin_cut = skin_cut.data(),
            .next = next.data(),
            .heads = heads.data(),
            .heads_of = schedule.heads_of,
            .largest = largest.data()};
  }
};

namespace {

/// What put allocates.
std::size_t bytes_there(const Model& model) {
  constexpr std::size_t kSlot = 9 * sizeof(Real) + 2 * sizeof(Real) + 2;
  std::size_t groups = 0;
  for (const Runs* runs : {&model.moving, &model.joining})
    for (const Run run : runs->all) groups += std::size_t(run.count / kGroup);
  return model.inverse_mass.size() * kSlot + groups * sizeof(int) +
         model.skin.triangles.size() * (sizeof(SkinTriangle) + 2 * sizeof(int) + 1);
}

}  // namespace

Result<std::shared_ptr<GpuBody>> put(const Gpu& gpu, const Model& model) {
  TURGOR_ASSERT(runs_on_gpu(model.params), "asked before by runs_on_gpu");
  const std::size_t bytes = bytes_there(model);
  const auto megabytes = [](std::size_t b) { return std::to_string(b / 1000000) + " MB"; };
  const Error full{"the body needs " + megabytes(bytes) + " of a GPU's memory; " + gpu.name + " has " +
                   megabytes(gpu.free_bytes) + " free"};
  if (bytes > gpu.free_bytes) return full;
  auto body = std::make_shared<GpuBody>(model);
  if (!body->is_there()) return full;
  return body;
}

void put_state(GpuBody& body, const State& state) {
  body.u.upload(state.u), body.v.upload(state.v);
  body.cut.upload(state.cut), body.removed.upload(state.removed), body.skin_cut.upload(state.skin_cut);
}

void get_state(const GpuBody& body, State& state) {
  body.u.download(state.u), body.v.download(state.v), body.u_before.download(state.u_before);
}

StepReport step(GpuBody& body, const Model& model, const Inputs& inputs, double dt) {
  TURGOR_ASSERT(inputs.loads.empty() && inputs.contacts.empty(), "a GPU knows neither loads nor contacts yet");
  std::uint32_t largest = 0;
  body.largest.upload({&largest, 1});
  body.rules = pbd_rules(model);
  const PbdView view = body.view();
  step_pbd_with(GpuRun{}, view, lattice_gravity(model, inputs), model.params.solver, dt);
  body.largest.download({&largest, 1});  // waits
  const Real speed2 = std::bit_cast<Real>(largest);
  if (std::isfinite(speed2)) return {.largest_speed = std::sqrt(speed2)};
  go_back_with(GpuRun{}, view);
  return {.finite = false};
}

StepReport step_on_gpu(GpuBody& body, const Model& model, State& state, const Inputs& inputs, double dt) {
  const std::lock_guard lock(body.in_use);
  put_state(body, state);
  const StepReport report = step(body, model, inputs, dt);
  get_state(body, state);
  state.fastest = report.largest_speed;
  if (report.finite) state.time += dt;
  return report;
}

}  // namespace turgor::lattice
