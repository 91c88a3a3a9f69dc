// Frames by colours of bodies as large as the paper's and larger ones, up to a node a voxel, on a GPU where
// there is one, and of the smallest on this processor: what of a machine's two limits, measured here, they
// reach. A line of JSON each, which scripts/roofline draws. Bytes are those of the arrays that each loop goes
// over, where nothing stays in a cache from one loop to the next; operations are those of single precision in
// what nvcc makes of a node (-ptx), a fused one as two.
#include <cstdio>
#include <string_view>

#include "app/machine.hpp"
#include "turgor/core/gpu_limits.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"

namespace {

using namespace turgor;
using namespace turgor::lattice;

constexpr double kDt = 1.0 / 60;
constexpr int kFrames = 31;

/// What a frame asks for, a slot that a thread looks at.
struct Cost {
  double bytes = 0, operations = 0, loops = 0;

  Cost operator+(Cost b) const { return {bytes + b.bytes, operations + b.operations, loops + b.loops}; }
  Cost operator*(double by) const { return {bytes * by, operations * by, loops * by}; }
};
constexpr double kReal = sizeof(Real), kVector = 3 * kReal, kByte = 1;
/// u, u_before, v, w, removed in; u, u_before out. Then u, u_before in; v out.
constexpr Cost kPredictAndFinish{4 * kVector + kReal + kByte + kVector + 3 * kVector, 30, 2};
/// Eight passes over u, which they move, and over w and root, or what kind of node each is; each cell's cuts
/// once; and over the skin, which is little.
constexpr Cost kPbdSweepHere{8 * (2 * kVector + 2 * kReal) + kByte, 7 * 32, 16};
constexpr Cost kPbdSweepThere{8 * (2 * kVector + 2 * kByte) + kByte, 7 * 32, 16};
/// Eight passes over u and root or Young's moduli of all; of the node itself u_before, v, w, removed and cut,
/// and u, which moves.
constexpr double kVbdBytes = 8 * (kVector + kReal) + 2 * kVector + kReal + 2 * kByte + kVector;
constexpr Cost kSpringsSweep{kVbdBytes, 704, 8};
constexpr Cost kSolidSweep{kVbdBytes, 2180, 8};
/// Twice forces, to which u, moduli, u_before, v, w and removed lead, and their sums over blocks; twice the
/// way of every node. Loops over unknowns are among those of forces.
constexpr Cost kForces{kVector + kReal + 2 * kVector + kReal + kByte + kVector, 1789, 19};
constexpr Cost kSums{kVector + sizeof(int), 8 * 20, 1};
constexpr Cost kWay{sizeof(int) + 2 * kVector, 8 * 11, 1};

struct Kind {
  const char* name;
  Method method;
  TissueLaw law;
};
struct Body {
  const char* name;
  PhantomKind phantom;
  int block;               // voxels a step
  bool pbd_alone = false;  // as the paper steps it
};
constexpr Body kBodies[] = {{"A abdomen", PhantomKind::kTorso, 4},
                            {"B head", PhantomKind::kHead, 4},
                            {"C leg", PhantomKind::kLeg, 4},
                            {"A in steps of 2 voxels", PhantomKind::kTorso, 2},
                            {"A, a node a voxel", PhantomKind::kTorso, 1, true}};
constexpr Kind kKinds[] = {{"pbd", Method::kPbd, TissueLaw::kSprings},
                           {"descent, springs", Method::kVbd, TissueLaw::kSprings},
                           {"descent, solid", Method::kVbd, TissueLaw::kSolid}};

Cost cost_of_frame(const Kind& kind, bool there, int sweeps) {
  const bool solid = kind.law == TissueLaw::kSolid;
  const Cost projections = there ? kPbdSweepThere : kPbdSweepHere;
  const Cost sweep = kind.method == Method::kPbd ? projections : solid ? kSolidSweep : kSpringsSweep;
  const Cost coarse = (kForces + kSums + kWay) * 2;
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
/// Kernel by kernel: 0 where there are none.
void print_frame(const char* kind, const Body& body, const Kind& of, const Model& model, double ms,
                 double one_by_one, double copy) {
  const auto slots = double(slots_in(model.moving));
  const int sweeps = model.params.solver.sweeps;
  const Cost there = cost_of_frame(of, true, sweeps);
  const Cost cost = kind == std::string_view("gpu") ? there : cost_of_frame(of, false, sweeps);
  std::printf(R"({"machine": "%s", "body": "%s", "frame": "%s", )", kind, body.name, of.name);
  std::printf(R"("nodes": %d, "slots": %.0f, )", model.body_nodes, slots);
  std::printf(R"("ms": %.4g, "ms_one_by_one": %.4g, )", ms, one_by_one);
  std::printf(R"("bytes_a_slot": %.0f, "operations_a_slot": %.0f, )", cost.bytes, cost.operations);
  std::printf(R"("bytes_a_slot_on_a_gpu": %.0f, )", there.bytes);
  std::printf(R"("loops": %.0f, "of_copy": %.3f})", cost.loops, slots * cost.bytes / (ms * 1e-3) / copy);
  std::puts("");
  std::fflush(stdout);
}

}  // namespace

int main() {
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
    std::fprintf(stderr, "bench_gpu_frames: this processor alone: %s\n", gpu.error().message.c_str());
  }
  for (const Body& body : kBodies) {
    const bool is_small = &body == kBodies;
    if (!is_small && !gpu) continue;
    const CtVolume ct = make_phantom(exec, default_phantom(body.phantom));
    for (const Kind& kind : kKinds) {
      if (body.pbd_alone && kind.method != Method::kPbd) continue;
      const Model model = model_of(exec, ct, kind, body.block);
      if (is_small)
        print_frame("cpu", body, kind, model, frame_ms(exec, model, make_state(model), kFrames / 3), 0, copy);
      if (!gpu) continue;
      double ms[2] = {};
      for (const Frames frames : {Frames::kAsGraphs, Frames::kOneByOne}) {
        const Result<std::shared_ptr<BodyBackend>> there = put(*gpu, model, frames);
        if (!there) return std::fprintf(stderr, "bench_gpu_frames: %s\n", there.error().message.c_str()), 2;
        DeviceState state = make_state(model);
        state.step_on(*there);
        ms[frames == Frames::kOneByOne] = frame_ms(exec, model, std::move(state), kFrames);
      }
      print_frame("gpu", body, kind, model, ms[0], ms[1], limits.copy_bandwidth);
    }
  }
}
