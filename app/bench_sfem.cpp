#include "app/bench_sfem.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>

#include "app/commands.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor {

namespace {

using sfem::Model;

constexpr std::size_t kMemory = std::size_t(16) << 30;  // [bytes]

double median_seconds(int runs, const std::function<void()>& work) {
  std::vector<double> times;
  for (int n = 0; n < runs; n++) {
    const Timer timer;
    work();
    times.push_back(timer.seconds());
  }
  return median(times);
}

double dense_flops() {
  constexpr Eigen::Index kSide = 768;
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(kSide, kSide), b = Eigen::MatrixXd::Random(kSide, kSide);
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(kSide, kSide);
  return 2.0 * kSide * kSide * kSide / median_seconds(5, [&] { c.noalias() += a * b; });
}

/// Bandwidth of y = A x with A in float [B/s].
double gemv_bandwidth(const Exec& exec, Eigen::Index rows, Eigen::Index columns) {
  const Eigen::MatrixXf a = Eigen::MatrixXf::Random(rows, columns);
  const Eigen::VectorXf x = Eigen::VectorXf::Random(columns);
  Eigen::VectorXf y = Eigen::VectorXf::Zero(rows);
  constexpr Eigen::Index kBlock = 1024;
  const double seconds = median_seconds(21, [&] {
    parallel_for(exec, std::size_t((rows + kBlock - 1) / kBlock), [&](std::size_t block) {
      const Eigen::Index begin = Eigen::Index(block) * kBlock, count = std::min(kBlock, rows - begin);
      y.segment(begin, count).noalias() = a.middleRows(begin, count) * x;
    });
  });
  return double(rows) * double(columns) * sizeof(float) / seconds;
}

Model built(const Exec& exec, SolidMesh mesh, sfem::Material material,
            const std::function<bool(Vec3d)>& is_fixed) {
  sfem::Body body;
  body.mesh = std::move(mesh);
  body.materials = {material};
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(is_fixed(x));
  return required(sfem::build(exec, std::move(body), {.touch_depth = 1}));
}

void compute(const Exec& exec, Model& model) { required(sfem::compute_green(exec, model, kMemory)); }

bool is_bottom(Vec3d x) { return x.z < 1e-9; }

PrecomputeRow measure_precompute(const Exec& exec, Int3 cells, double flops) {
  const Timer timer;
  Model model = built(exec, tetrahedralize(hex_block({0.1, 0.1, 0.1}, cells)), {3e3, 0.45}, is_bottom);
  compute(exec, model);
  const sfem::GreenCost cost = sfem::green_cost(model);
  PrecomputeRow row{int(model.vertex.size()), timer.seconds(), double(cost.factor_bytes),
                    double(cost.store_bytes), 0};
  row.flops_fraction = (cost.factor_flops + cost.solve_flops) / row.seconds / (flops * exec.threads());
  return row;
}

/// Ticks of a fingertip of 15 mm that slides in a circle at 100 mm/s, pressed in by `depth`.
TickRow measure_tick(const sfem::Patch& patch, Vec3d center, double depth) {
  constexpr double kRadius = 0.015, kCircle = 0.003, kTick = 1e-3;
  constexpr int kWarm = 200, kTicks = 2000;
  const std::vector<contact::Tool> tools{{contact::Sphere{kRadius}, 0.3}};
  contact::TouchState state = contact::make_touch_state(patch, 1, {.capacity = 48});
  std::vector<contact::ToolPose> poses(1);
  std::vector<contact::ToolForce> forces(1);
  std::vector<double> seconds, contacts;
  for (int n = 0; n < kWarm + kTicks; n++) {
    const double angle = 0.1 * kTick / kCircle * n,
                 pressed = std::min(1.0, double(n) / kWarm) * (depth + 0.001);
    poses[0].pose.position =
        center + Vec3d{kCircle * std::cos(angle), kCircle * std::sin(angle), kRadius + 0.001 - pressed};
    const Timer timer;
    contact::solve_touch_tick(patch, state, tools, poses, kTick, forces);
    if (n < kWarm) continue;
    seconds.push_back(timer.seconds());
    contacts.push_back(forces[0].contacts);
  }
  return {int(median(contacts)), int(patch.points.size()), percentile(seconds, 0.5),
          percentile(seconds, 0.99), percentile(seconds, 1)};
}

std::vector<TickRow> measure_ticks(const Exec& exec) {
  const Vec3d size{0.12, 0.12, 0.06}, center{0.06, 0.06, 0.06};
  Model model = built(exec, hex_block(size, {12, 12, 6}), {3e3, 0.45}, is_bottom);
  compute(exec, model);
  const std::vector<Vec3d> touches{center};
  const std::vector<int> elements = sfem::patch_elements(model, touches, 0.02);
  const sfem::Patch patch = sfem::build_patch(model, elements, 3, touches).value();
  std::vector<TickRow> rows;
  for (const double depth : {0.0003, 0.001, 0.002, 0.004, 0.006, 0.008})
    rows.push_back(measure_tick(patch, center, depth));
  return rows;
}

std::vector<PatchRow> measure_patches(const Exec& exec) {
  const auto is_side = [](Vec3d x) { return std::min(x.x, x.y) < 1e-9 || std::max(x.x, x.y) > 0.1 - 1e-9; };
  Model model = built(exec, hex_block({0.1, 0.1, 0.01}, {4, 4, 1}), {1e5, 0.4}, is_side);
  compute(exec, model);
  const std::vector<Vec3d> touches{{0.05, 0.05, 0.01}};
  const std::vector<int> elements = sfem::patch_elements(model, touches, 0.03);
  std::vector<PatchRow> rows;
  for (const int refinement : {2, 3, 4}) {
    sfem::Patch patch;
    const double seconds =
        median_seconds(41, [&] { patch = sfem::build_patch(model, elements, refinement, touches).value(); });
    rows.push_back({refinement, patch.local_nodes, int(patch.points.size()), seconds});
  }
  return rows;
}

/// Surface of a plate with 5100 free vertices, all of them on the surface, under forces on the 40 vertices of
/// a patch.
SurfaceRow measure_surface(const Exec& exec) {
  constexpr int kForces = 40;
  Model model =
      built(exec, hex_block({0.2, 0.2, 0.008}, {50, 50, 1}), {3e3, 0.45}, [](Vec3d x) { return x.x < 1e-9; });
  required(sfem::prepare_columns(exec, model));
  std::vector<int> vertices(model.green.nodes.begin(), model.green.nodes.begin() + kForces);
  sfem::fetch_columns(exec, model, vertices);
  const std::vector<double> forces(3 * kForces, 1e-3);
  std::vector<float> u(3 * model.green.surface_count);
  const double seconds =
      median_seconds(41, [&] { sfem::surface_displacements(exec, model, vertices, forces, u); });
  const double bytes = double(u.size()) * 3 * kForces * sizeof(float);
  const double bandwidth = gemv_bandwidth(exec, Eigen::Index(u.size()), 3 * kForces);
  return {int(model.green.surface_count), seconds, bytes / seconds / bandwidth};
}

}  // namespace

SfemBench bench_sfem(const Exec& exec, int largest, const Progress& progress) {
  const auto done = [&](double fraction) {
    if (progress) progress(fraction);
  };
  const Exec one(1);
  SfemBench bench{.threads = exec.threads(), .dense_flops = dense_flops()};
  bench.gemv_bandwidth = gemv_bandwidth(one, 15300, 120);
  bench.patches = measure_patches(one);
  bench.ticks = measure_ticks(one);
  bench.surface = measure_surface(exec);
  done(0.05);
  for (const Int3 cells : {Int3{9, 9, 10}, Int3{14, 19, 10}, Int3{24, 19, 20}}) {
    const int nodes = (cells.x + 1) * (cells.y + 1) * cells.z;
    if (nodes > largest * 1.1) continue;
    bench.precompute.push_back(measure_precompute(exec, cells, bench.dense_flops));
    done(std::min(1.0, 0.05 + 0.95 * nodes / largest));
  }
  return bench;
}

}  // namespace turgor
