// A coarse view of a cloth for its solver: blocks of neighbouring vertices that move as rigid bodies. Sweeps
// and conjugate gradients carry news by one edge an iteration; what whole blocks do to each other is solved
// at once, by a sparse Cholesky factor that is made anew in each step [two-level additive Schwarz: Dryja,
// Widlund 1987; rigid modes: Vaněk, Mandel, Brezina 1996].
#pragma once

#include <memory>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

struct Model;
struct State;

/// What does not change: whose vertices belong together.
struct Blocks {
  std::vector<int> of;             // block of each vertex
  std::vector<int> begin, vertex;  // vertices of each block, and the end
  std::vector<int> pair_begin;     // of each block, and the end: itself and the smaller blocks it touches,
  std::vector<int> pair;           // ascending
};
Blocks make_blocks(const Model& model);

/// The matrix of the blocks in one step, and its factor. A copy begins without one.
class TwoLevelSystem {
 public:
  TwoLevelSystem();
  ~TwoLevelSystem();
  TwoLevelSystem(const TwoLevelSystem&);
  TwoLevelSystem& operator=(const TwoLevelSystem&);

  /// From a system that was assembled. False: it could not be factored.
  bool factor(const Exec& exec, const Model& model, const State& state);
  /// Adds what the blocks answer to r to z.
  void add_answer(const Exec& exec, const Model& model, const State& state, const Vectors& r, Vectors& z);
  std::size_t bytes() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace turgor::cloth
