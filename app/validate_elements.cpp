// Element types on organ meshes: force under a fingertip and cost of the precomputation. Compares them with
// the converged force, and measures the dependence of the force on the patch refinement.
#include <cmath>

#include <fmt/format.h>

#include "app/pressed_organs.hpp"
#include "app/validate_sfem.hpp"

namespace turgor {

namespace {

using sfem::Formulation;

/// Radius of the reference's patch, relative to the organ's. Its elements are small on the border as well. On
/// the liver the force is within 0.2 % of the whole patch, which takes six times as long.
constexpr double kReferenceReach = 0.75;

ElementChoice quadratic(int refinement) {
  return {refinement == 1 ? "quadratic, no patch" : fmt::format("quadratic, patch r = {}", refinement), true,
          Formulation::kStandard, refinement};
}

/// The last one is the reference.
std::vector<ElementChoice> kinds() {
  return {{"standard, patch r = 2", false, Formulation::kStandard, 2},
          {"averaged, patch r = 2", false, Formulation::kAveraged, 2},
          {"averaged, cut in eight, patch r = 2", false, Formulation::kAveraged, 2, true},
          quadratic(1),
          quadratic(2),
          {"quadratic, cut in eight", true, Formulation::kStandard, 1, true}};
}
std::vector<ElementChoice> levels() {
  return {quadratic(1),
          quadratic(2),
          quadratic(3),
          quadratic(4),
          {"quadratic, cut in eight, patch r = 2", true, Formulation::kStandard, 2, true, kReferenceReach}};
}

struct Presses {
  PressedOrgan organ;
  double poisson = 0;
  std::vector<ElementChoice> choices;
};

Result<std::vector<Presses>> all_presses(const Exec& exec, bool quick) {
  std::vector<Presses> all;
  const Result<PressedOrgan> tongue = pressed_tongue(exec, 0.009);
  if (!tongue) return tongue.error();
  all.push_back({*tongue, 0.45, kinds()});
  if (quick) return all;
  all.push_back({*tongue, 0.3, kinds()});
  all.push_back({*tongue, 0.49, kinds()});
  const Result<PressedOrgan> coarse = pressed_tongue(exec, 0.010), liver = pressed_liver(exec, 0.022);
  if (!coarse) return coarse.error();
  if (!liver) return liver.error();
  all.push_back({*liver, 0.45, kinds()});
  for (const PressedOrgan& organ : {*coarse, *liver, pressed_tet_block(0.010)})
    all.push_back({organ, 0.45, levels()});
  return all;
}

ElementsRow row_of(const Presses& presses, const ElementChoice& choice, const OrganForces& found) {
  return {.organ = presses.organ.name,
          .elements = choice.name,
          .reference = presses.choices.back().name,
          .to_patch = presses.choices.back().refinement > 1,
          .quadratic = choice.quadratic,
          .refinement = choice.refinement,
          .poisson = presses.poisson,
          .tetrahedra = int(element_count(presses.organ.mesh)),
          .nodes = found.nodes,
          .flops = found.cost.factor_flops + found.cost.solve_flops,
          .store_bytes = double(found.cost.store_bytes),
          .factor_bytes = double(found.cost.factor_bytes),
          .expected_error = found.expected_error};
}

void set_errors(const std::vector<double>& force, const std::vector<double>& reference, ElementsRow& row) {
  for (std::size_t p = 0; p < force.size(); p++) {
    const double error = force[p] / reference[p] - 1;
    row.mean += error / double(force.size());
    // an error that is not finite is kept
    if (std::isfinite(row.worst) && !(std::abs(error) <= std::abs(row.worst))) row.worst = error;
  }
}

}  // namespace

Result<std::vector<ElementsRow>> validate_elements(const Exec& exec, bool quick, const Progress& progress) {
  const Result<std::vector<Presses>> all = all_presses(exec, quick);
  if (!all) return all.error();
  double total = 0, done = 0;
  for (const Presses& presses : *all)
    for (const ElementChoice& choice : presses.choices) total += press_flops(presses.organ, choice);
  std::vector<ElementsRow> rows;
  for (const Presses& presses : *all) {
    std::vector<std::vector<double>> forces;
    for (const ElementChoice& choice : presses.choices) {
      const Result<OrganForces> found = press_organ(exec, presses.organ, choice, presses.poisson);
      if (!found) return found.error();
      forces.push_back(found->force);
      rows.push_back(row_of(presses, choice, *found));
      done += press_flops(presses.organ, choice);
      if (progress) progress(done / total);
    }
    for (std::size_t w = 0; w < forces.size(); w++)
      set_errors(forces[w], forces.back(), rows[rows.size() - forces.size() + w]);
  }
  return rows;
}

}  // namespace turgor
