#include "app/bench_growth.hpp"

#include "app/machine.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor {

namespace {

using lattice::Model;
using lattice::State;

constexpr double kBlockSpacing = 0.004, kDt = 1.0 / 60, kSleep = 1e-4;

/// A block under tense skin, held at its sides and below.
Model tense_block(Int3 size, double sleep) {
  lattice::Block block{.size = size, .spacing = kBlockSpacing};
  block.is_fixed = [size](Int3 p) {
    return p.x == 0 || p.y == 0 || p.z == 0 || p.x == size.x - 1 || p.y == size.y - 1;
  };
  lattice::Params params;
  params.solver.sleep_speed = sleep;
  return lattice::block_model(block, params);
}

/// Median time of a frame [ms] in the second after a cut of 40 mm. The body is at rest before the cut.
double frame_after_cut(const Exec& exec, const Model& model, double& asleep) {
  State state = make_state(model);
  for (int n = 0; n < 10; n++) lattice::step(exec, model, state, {}, kDt);
  const Int3 size = model.anatomy.lattice.size;
  const int middle = size.x / 2;
  const Vec3d from{(middle - 0.5) * kBlockSpacing, 0.1, (size.z - 2) * kBlockSpacing};
  const auto path =
      lay_blade(model, state, {.name = {}, .from = from, .to = from + Vec3d{0, 0.04, 0}}).value();
  cut_edges(model, state, path, 0, 1, 0);
  int frames = 0;
  asleep = 0;
  const double ms = median_ms(60, [&] {
    const lattice::StepReport report = lattice::step(exec, model, state, {}, kDt);
    asleep += report.rows > 0 ? double(report.rows_asleep) / report.rows : 0, frames++;
  });
  asleep /= frames;
  return ms;
}

}  // namespace

std::vector<GrowthRow> bench_growth(const Exec& exec) {
  std::vector<GrowthRow> rows;
  for (const int times : {1, 2, 4}) {
    const Int3 size{65, 65 * times, 25};
    GrowthRow row;
    double none = 0;
    row.awake_ms = frame_after_cut(exec, tense_block(size, 0), none);
    const Model model = tense_block(size, kSleep);
    row.nodes = model.anatomy.body_nodes;
    row.ms = frame_after_cut(exec, model, row.asleep);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace turgor
