#include "turgor/models/lattice/specimen.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/rim.hpp"

namespace turgor::lattice {

namespace {

/// The piece alone, without tension of the CT: a model without prestress, and a state at zero speed.
struct PieceAlone {
  Model model;
  State state;
};
PieceAlone piece_alone(const Model& model, const State& state, const FreePiece& piece) {
  PieceAlone alone{model, state};
  std::fill(alone.model.prestress_force.begin(), alone.model.prestress_force.end(), Vec3{});
  constexpr double kRestSpeed = 1e-5;  // [m/s]
  alone.model.params.solver.sleep_speed = kRestSpeed;
  Motion& motion = alone.state.motion;
  for (aligned_vector<Real>* axis : {&motion.v.x, &motion.v.y, &motion.v.z})
    std::fill(axis->begin(), axis->end(), Real(0));
  excise(alone.model, alone.state, rest_of_body(model, state.cuts, piece));
  // sweeps leave out the rest of the body
  alone.model.anatomy.free_runs = find_runs(model.anatomy.lattice, [&](int slot) {
    return model.anatomy.inverse_mass[std::size_t(slot)] > 0 &&
           std::binary_search(piece.nodes.begin(), piece.nodes.end(), slot);
  });
  return alone;
}

/// Steps a piece until it rests. Returns its largest speed then [m/s].
double come_to_rest(const Exec& exec, PieceAlone& alone) {
  constexpr int kMostSteps = 400, kLeastSteps = 10;
  constexpr double kStep = 1.0 / 60, kSlow = 2e-5;  // [s] [m/s]
  double speed = 0;
  for (int n = 0; n < kMostSteps; n++) {
    const StepReport report = step(exec, alone.model, alone.state, {}, kStep);
    speed = double(report.largest_speed);
    if (!report.finite || (n >= kLeastSteps && speed < kSlow)) break;
  }
  return speed;
}

}  // namespace

Result<Specimen> excise_piece(const Exec& exec, const Model& model, State& state, const BladePath& path,
                              int incision) {
  TURGOR_ASSERT(path.is_excision, "a piece has an outline");
  Result<FreePiece> piece = find_piece(model, state.cuts, incision);
  if (!piece) return piece.error();
  Specimen specimen;
  const PieceMass mass = mass_of(model, state.cuts, *piece);
  specimen.volume = mass.volume, specimen.mass = mass.mass;
  // size before the cut and free
  const double aside = kAsideOfBlade * smallest_spacing(model.anatomy.lattice);
  PieceAlone alone = piece_alone(model, state, *piece);
  const auto skin = embed_all(alone.model, alone.state.cuts, points_inside(rim_points(path, -aside)),
                              points_inside(path.points));
  if (!skin)
    return Error{"the skin of the piece is not resolved: expected a larger piece or a smaller spacing"};
  specimen.in_place = size_along_surface(skin->rest);
  specimen.speed = come_to_rest(exec, alone);
  specimen.free = size_along_surface(skin->now(alone.state.motion));
  excise(model, state, *piece);
  return specimen;
}

}  // namespace turgor::lattice
