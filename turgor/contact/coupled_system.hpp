// System of a coupling: compliance between all ties and sites of coupled bodies, and their separations
// without forces.
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/coupling.hpp"

namespace turgor::contact {

/// The whole system: all ties that are not broken, then all sites.
struct CoupledSystem {
  std::vector<std::size_t> tie;    // index of each tie
  std::size_t count = 0;           // ties and sites
  std::vector<double> compliance;  // C, 3·count square, column-major, lower blocks [m/N]
  std::vector<Vec3d> free;         // d of each tie, and separation of each site, without forces [m]
  std::vector<double> softness;    // own compliance of each, 0 for ties [m/N]
};
/// Fills a system, whose storage may be that of an earlier one.
void fill_system(const Exec& exec, std::span<const CoupledBody> bodies, std::span<const Tie> ties,
                 std::span<const PairSite> sites, CoupledSystem& system);

/// Storage of solve_coupling, kept between calls, since its matrices have megabytes. A copy starts without.
struct CouplingStorage {
  CoupledSystem system;
  FrictionalContactProblem problem;
  int capacity = 0;  // of `problem`

  CouplingStorage() = default;
  CouplingStorage(const CouplingStorage&) {}
  CouplingStorage& operator=(const CouplingStorage&) { return *this; }
  CouplingStorage(CouplingStorage&&) = default;
  CouplingStorage& operator=(CouplingStorage&&) = default;
  ~CouplingStorage() = default;
};

}  // namespace turgor::contact
