// Frames with colored ordering on a GPU, for bodies of the paper's size and larger, up to one node per voxel.
// On the CPU, only the smallest body. Prints one line of JSON each, with the fraction of the two measured
// limits of the machine; scripts/roofline draws them. `bench_gpu_frames BODY FRAME` runs only bodies and
// frames whose names begin with these words.
//
// Bytes are those of the arrays that each loop reads and writes, without reuse of the cache between loops.
// Operations are those of single precision in nvcc's code for a node (-ptx); a fused multiply-add counts as
// two.
#include <cstdio>
#include <string_view>

#include "app/machine.hpp"
#include "turgor/core/gpu_limits.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace {

using namespace turgor;
using namespace turgor::lattice;

constexpr double kDt = 1.0 / 60;
constexpr int kFrames = 31;

/// Cost of a frame per slot.
struct Cost {
  double bytes = 0, operations = 0, loops = 0;

  Cost operator+(Cost b) const { return {bytes + b.bytes, operations + b.operations, loops + b.loops}; }
  Cost operator*(double by) const { return {bytes * by, operations * by, loops * by}; }
};
constexpr double kReal = sizeof(Real), kVector = 3 * kReal, kByte = 1;
/// Predictor: reads u, u_before, v, w, removed; writes u, u_before. End of the frame: reads u, u_before;
/// writes v.
constexpr Cost kPredictAndFinish{4 * kVector + kReal + kByte + kVector + 3 * kVector, 30, 2};
/// Eight passes that read and write u and read w and root, or on a GPU the kind of each node. They read the
/// cuts of each cell once; the skin is negligible.
constexpr Cost kPbdSweepHost{8 * (2 * kVector + 2 * kReal) + kByte, 7 * 32, 16};
constexpr Cost kPbdSweepDevice{8 * (2 * kVector + 2 * kByte) + kByte, 7 * 32, 16};
/// Eight passes over u and root or Young's moduli of all nodes. Each node also reads u_before, v, w, removed
/// and cut, and writes u.
constexpr double kVbdBytes = 8 * (kVector + kReal) + 2 * kVector + kReal + 2 * kByte + kVector;
constexpr Cost kSpringsSweep{kVbdBytes, 704, 16};
constexpr Cost kSolidSweep{kVbdBytes, 2180, 16};
/// Two force passes (u, moduli, u_before, v, w, removed) with their sums over aggregates, and two
/// prolongations to all nodes. Loops over coarse unknowns count as loops of the forces.
constexpr Cost kForces{kVector + kReal + 2 * kVector + kReal + kByte + kVector, 1789, 20};
constexpr Cost kSums{kVector + sizeof(int), 8 * 20, 1};
constexpr Cost kProlongation{sizeof(int) + 2 * kVector, 8 * 11, 1};

struct Kind {
  const char* name;
  Method method;
  TissueLaw law;
};
struct Body {
  const char* name;
  PhantomKind phantom;
  int block;               // voxels per cell along an axis
  bool pbd_alone = false;  // as in the paper
};
constexpr Body kBodies[] = {{"A abdomen", PhantomKind::kTorso, 4},
                            {"B head", PhantomKind::kHead, 4},
                            {"C leg", PhantomKind::kLeg, 4},
                            {"A, spacing of 2 voxels", PhantomKind::kTorso, 2},
                            {"A, one node per voxel", PhantomKind::kTorso, 1, true}};
constexpr Kind kKinds[] = {{"pbd", Method::kPbd, TissueLaw::kSprings},
                           {"vbd, springs", Method::kVbd, TissueLaw::kSprings},
                           {"vbd, solid", Method::kVbd, TissueLaw::kSolid}};

Cost cost_of_frame(const Kind& kind, bool on_gpu, int sweeps) {
  const bool solid = kind.law == TissueLaw::kSolid;
  const Cost projections = on_gpu ? kPbdSweepDevice : kPbdSweepHost;
  const Cost sweep = kind.method == Method::kPbd ? projections : solid ? kSolidSweep : kSpringsSweep;
  const Cost coarse = (kForces + kSums + kProlongation) * 2;
  return kPredictAndFinish + sweep * sweeps + coarse * (solid ? 2 : 0);
}

Model model_of(const Exec& exec, const CtVolume& ct, const Kind& kind, int block) {
  Params params;
  params.block = {block, block, block};
  params.tissue.law = kind.law;
  params.skin.law = kind.method == Method::kPbd ? SkinLaw::kArea : SkinLaw::kFiber;
  params.solver.method = kind.method, params.solver.ordering = Ordering::kColors;
  return build(exec, ct, {}, params).value();
}

double frame_ms(const Exec& exec, const Model& model, DeviceState state, int frames) {
  const auto step = [&] { state.step(exec, model, {.gravity = {0, 0, -1}}, kDt); };
  step(), step();
  return median_ms(frames, step);
}

void print_machine(const char* kind, const std::string& name, double copy, double arithmetic) {
  std::printf(R"({"machine": "%s", "name": "%s", )", kind, name.c_str());
  std::printf(R"("copy_bytes_a_second": %.4g, "operations_a_second": %.4g})", copy, arithmetic);
  std::puts("");
}
/// `one_by_one`: time with single kernel launches instead of a graph; 0 on the CPU.
void print_frame(const char* kind, const Body& body, const Kind& of, const Model& model, double ms,
                 double one_by_one, double copy) {
  const auto slots = double(slots_in(model.anatomy.free_runs));
  const int sweeps = model.params.solver.sweeps;
  const Cost gpu_cost = cost_of_frame(of, true, sweeps);
  const Cost cost = kind == std::string_view("gpu") ? gpu_cost : cost_of_frame(of, false, sweeps);
  std::printf(R"({"machine": "%s", "body": "%s", "frame": "%s", )", kind, body.name, of.name);
  std::printf(R"("nodes": %d, "slots": %.0f, )", model.anatomy.body_nodes, slots);
  std::printf(R"("ms": %.4g, "ms_one_by_one": %.4g, )", ms, one_by_one);
  std::printf(R"("bytes_a_slot": %.0f, "operations_a_slot": %.0f, )", cost.bytes, cost.operations);
  std::printf(R"("bytes_a_slot_on_a_gpu": %.0f, )", gpu_cost.bytes);
  std::printf(R"("loops": %.0f, "of_copy": %.3f})", cost.loops, slots * cost.bytes / (ms * 1e-3) / copy);
  std::puts("");
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
  const auto wanted = [&](int argument, std::string_view name) {
    return count <= argument || name.starts_with(arguments[argument]);
  };
  const Exec exec;
  const double copy = copy_bandwidth(exec);
  print_machine("cpu", std::to_string(exec.threads()) + " threads", copy, arithmetic_rate(exec));
  const Result<Gpu> gpu = open_gpu();
  GpuLimits limits;
  if (gpu) {
    const Result<GpuLimits> measured = measure_limits(*gpu);
    if (!measured) return std::fprintf(stderr, "bench_gpu_frames: %s\n", measured.error().message.c_str()), 2;
    limits = *measured;
    print_machine("gpu", gpu->name, limits.copy_bandwidth, limits.arithmetic_rate);
  } else {
    std::fprintf(stderr, "bench_gpu_frames: CPU only: %s\n", gpu.error().message.c_str());
  }
  for (const Body& body : kBodies) {
    const bool is_small = &body == kBodies;
    if ((!is_small && !gpu) || !wanted(1, body.name)) continue;
    const CtVolume ct = make_phantom(exec, default_phantom(body.phantom));
    for (const Kind& kind : kKinds) {
      if ((body.pbd_alone && kind.method != Method::kPbd) || !wanted(2, kind.name)) continue;
      const Model model = model_of(exec, ct, kind, body.block);
      if (is_small)
        print_frame("cpu", body, kind, model, frame_ms(exec, model, make_state(model), kFrames / 3), 0, copy);
      if (!gpu) continue;
      double ms[2] = {};
      for (const Frames frames : {Frames::kAsGraphs, Frames::kOneByOne}) {
        const Result<std::shared_ptr<BodyBackend>> backend = upload_model(*gpu, model, frames);
        if (!backend)
          return std::fprintf(stderr, "bench_gpu_frames: %s\n", backend.error().message.c_str()), 2;
        DeviceState state = make_state(model);
        state.use_backend(*backend);
        ms[frames == Frames::kOneByOne] = frame_ms(exec, model, std::move(state), kFrames);
      }
      print_frame("gpu", body, kind, model, ms[0], ms[1], limits.copy_bandwidth);
    }
  }
}
