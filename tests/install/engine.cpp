// A minimal simulator: a voxelized ball of tissue under gravity for one second.
#include <cmath>
#include <cstdio>

#include <turgor/models/lattice/lattice.hpp>

int main() {
  using namespace turgor;
  CtVolume ct{{.size = {48, 48, 48}, .spacing = {1e-3, 1e-3, 1e-3}}, {}};
  for (int k = 0; k < 48; k++)
    for (int j = 0; j < 48; j++)
      for (int i = 0; i < 48; i++) {
        const double r = std::hypot(i - 23.5, j - 23.5, k - 23.5);
        ct.samples.push_back(r < 6 ? 700 : r < 18 ? 40 : -1000);
      }
  const Exec exec;
  const auto model = lattice::build(exec, ct, {}, {});
  if (!model) return std::fprintf(stderr, "%s\n", model.error().message.c_str()), 1;
  auto state = lattice::make_state(*model);
  for (int frame = 0; frame < 60; frame++)
    lattice::step(exec, *model, state, {.gravity = {0, 0, -9.81}}, 1.0 / 60);
  const double sag = -lattice::position(*model, state.motion, {6, 6, 2}).z + 2 * 4e-3;
  std::printf("%d nodes, the underside sags by %.2f mm\n", model->anatomy.body_nodes, sag * 1e3);
  return sag > 0 ? 0 : 1;
}
