#include "turgor/models/cloth/solver/two_level.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/cloth/model/state.hpp"
#include "turgor/models/cloth/solver/block_cholesky.hpp"

namespace turgor::cloth {

namespace {

/// Bisects a list of vertices across its longest extent until the blocks are small.
void halve(const Vectors& x, std::vector<int>::iterator from, std::vector<int>::iterator to, int largest,
           std::vector<std::vector<int>>& lists) {
  TURGOR_CHECK(from < to && largest >= 1, "a block has vertices");
  if (to - from <= largest) {
    lists.emplace_back(from, to);
    return;
  }
  Vec3 low = x[std::size_t(*from)], high = low;
  for (auto v = from; v != to; v++) low = min(low, x[std::size_t(*v)]), high = max(high, x[std::size_t(*v)]);
  const Vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto middle = from + (to - from) / 2;
  std::nth_element(from, middle, to, [&](int a, int b) {
    const Real xa = x[std::size_t(a)][axis], xb = x[std::size_t(b)][axis];
    return xa != xb ? xa < xb : a < b;
  });
  halve(x, from, middle, largest, lists);
  halve(x, middle, to, largest, lists);
}

/// Calls visit(vertex, neighbor) for both ends of every spring, including springs across edges.
template <class Visit>
void for_each_neighbor(const Rows& rows, const Visit& visit) {
  for (std::size_t batch = 0; batch < batch_count(rows); batch++)
    for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++)
      for (int l = 0; l < kLanes; l++)
        if (rows.stiffness[std::size_t(s) * std::size_t(kLanes) + std::size_t(l)] > 0)
          visit(int(batch) * kLanes + l, neighbor(rows, s, l));
}

/// Block of each vertex.
std::vector<int> blocks_of(const Model& model, const std::vector<std::vector<int>>& lists) {
  std::vector<int> of(std::size_t(model.count));
  for (std::size_t n = 0; n < lists.size(); n++)
    for (const int v : lists[n]) of[std::size_t(v)] = int(n);
  return of;
}

/// Blocks that are joined to each block by a spring, ascending, without itself.
std::vector<std::vector<int>> adjacent_blocks(const Model& model, const std::vector<int>& of) {
  std::vector<std::set<int>> sets(of.empty() ? 0 : std::size_t(*std::max_element(of.begin(), of.end())) + 1);
  for_each_neighbor(model.rows, [&](int i, int j) {
    const int a = of[std::size_t(i)], b = of[std::size_t(j)];
    if (a != b) sets[std::size_t(a)].insert(b);
  });
  std::vector<std::vector<int>> adjacent;
  for (const std::set<int>& set : sets) adjacent.emplace_back(set.begin(), set.end());
  return adjacent;
}

/// Vertices of a block. Number and size of blocks both grow with the square root of the cloth, and iterations
/// hardly grow.
int block_size(int count) { return std::max(12, int(0.7 * std::sqrt(double(count)))); }

/// Galerkin coupling of two vertices: (I, −[r]×)ᵀ B (I, −[q]×), rows by the translations and rotations of the
/// first block.
void add_coupling(const double (&b)[3][3], Vec3d r, Vec3d q, double sign, Block& sum) {
  double left[kRigidModes][3];
  for (int k = 0; k < 3; k++) {
    const Vec3d column{b[0][k], b[1][k], b[2][k]};
    const Vec3d moment = cross(r, column);
    for (int d = 0; d < 3; d++) left[d][k] = column[d], left[3 + d][k] = moment[d];
  }
  for (int d = 0; d < kRigidModes; d++) {  // times (I, −[q]×): cross product of the row
    const Vec3d row{left[d][0], left[d][1], left[d][2]};
    const Vec3d moment = cross(q, row);
    double* out = &sum[std::size_t(d * kRigidModes)];
    for (int k = 0; k < 3; k++) out[k] += sign * row[k], out[3 + k] += sign * moment[k];
  }
}

/// Calls visit(own weight, contact, its terms) for the closed contacts of a vertex.
template <class Visit>
void for_each_closed_contact(const State& state, std::size_t v, const Visit& visit) {
  const Contacts& contacts = state.implicit_contacts.contacts;
  if (contacts.begin.empty()) return;
  for (int m = contacts.begin[v]; m < contacts.begin[v + 1]; m++) {
    const auto item = std::size_t(contacts.item[std::size_t(m)]);
    const ImplicitContact& terms = state.implicit_contacts.terms[item / 4];
    if (terms.normal_stiffness > 0)
      visit(double(contacts.list[item / 4].weight[item % 4]), contacts.list[item / 4], terms);
  }
}

/// d += f (k_n n nᵀ + k_t (I − n nᵀ)).
void add_contact_stiffness(const Contact& c, const ImplicitContact& a, double f, double (&d)[3][3]) {
  const Vec3d n(c.normal);
  for (int p = 0; p < 3; p++)
    for (int q = 0; q < 3; q++)
      d[p][q] += f * (double(a.normal_stiffness - a.tangential_stiffness) * n[p] * n[q] +
                      (p == q ? double(a.tangential_stiffness) : 0));
}

}  // namespace

Blocks make_blocks(const Model& model) {
  // blocks of each component
  std::vector<std::vector<int>> lists;
  const int size = block_size(model.count);
  for (std::size_t p = 0; p + 1 < model.component_begin.size(); p++) {
    std::vector<int> component(std::size_t(model.component_begin[p + 1] - model.component_begin[p]));
    std::iota(component.begin(), component.end(), model.component_begin[p]);
    halve(model.x_rest, component.begin(), component.end(), size, lists);
  }
  // numbers in the order of elimination
  std::vector<std::vector<int>> ordered;
  for (const int n : elimination_order(adjacent_blocks(model, blocks_of(model, lists))))
    ordered.push_back(std::move(lists[std::size_t(n)]));
  Blocks blocks{.of = blocks_of(model, ordered)};
  // vertices of each block
  blocks.begin.push_back(0);
  for (std::vector<int>& list : ordered) {
    std::sort(list.begin(), list.end());
    blocks.vertex.insert(blocks.vertex.end(), list.begin(), list.end());
    blocks.begin.push_back(int(blocks.vertex.size()));
  }
  // pairs of adjacent blocks
  blocks.pair_begin.push_back(0);
  const std::vector<std::vector<int>> adjacent = adjacent_blocks(model, blocks.of);
  for (std::size_t n = 0; n < adjacent.size(); n++) {
    std::copy_if(adjacent[n].begin(), adjacent[n].end(), std::back_inserter(blocks.pair),
                 [&](int other) { return other < int(n); });
    blocks.pair.push_back(int(n));
    blocks.pair_begin.push_back(int(blocks.pair.size()));
  }
  TURGOR_CHECK(is_permutation(blocks.vertex, std::size_t(model.count)), "every vertex is in one block");
  return blocks;
}

struct TwoLevelSystem::Storage {
  std::vector<std::array<int, 2>>
      touching;                       // pairs of blocks joined by contacts only, the larger first, ascending
  std::vector<int> pair_begin, pair;  // as in Blocks, with these
  std::vector<Vec3d> center;          // of each block's vertices [m]
  std::vector<Vec3d> lever;           // by Blocks::vertex: from the center of its block [m]
  std::vector<Block> coupling;        // by pair
  BlockCholesky factor;

  /// Sparsity pattern for the given contact pairs.
  void set_pattern(const Blocks& blocks, std::vector<std::array<int, 2>> by_contacts);
  /// Values of the pairs of one block.
  void set_values(const Model& model, const State& state, int block);
};

/// Pairs of blocks joined by closed contacts but by no edge.
std::vector<std::array<int, 2>> touching_blocks(const Blocks& blocks,
                                                const ImplicitContacts& implicit_contacts) {
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t n = 0; n < implicit_contacts.terms.size(); n++) {
    const Contact& c = implicit_contacts.contacts.list[n];
    if (c.obstacle >= 0 || !(implicit_contacts.terms[n].normal_stiffness > 0)) continue;
    for (const int i : c.vertex)
      for (const int j : c.vertex) {
        if (i < 0 || j < 0 || blocks.of[std::size_t(i)] <= blocks.of[std::size_t(j)]) continue;
        const int a = blocks.of[std::size_t(i)], b = blocks.of[std::size_t(j)];
        const auto begin = blocks.pair.begin() + blocks.pair_begin[std::size_t(a)],
                   end = blocks.pair.begin() + blocks.pair_begin[std::size_t(a) + 1];
        if (!std::binary_search(begin, end, b)) pairs.push_back({a, b});
      }
  }
  sort_unique(pairs);
  return pairs;
}

void TwoLevelSystem::Storage::set_pattern(const Blocks& blocks, std::vector<std::array<int, 2>> by_contacts) {
  const int count = int(blocks.begin.size()) - 1;
  // pairs of blocks, with those of contacts
  touching = std::move(by_contacts);
  pair.clear(), pair_begin.assign(1, 0);
  auto joined = touching.begin();
  for (std::size_t a = 0; a < std::size_t(count); a++) {
    const auto from = std::ptrdiff_t(pair.size());
    pair.insert(pair.end(), blocks.pair.begin() + blocks.pair_begin[a],
                blocks.pair.begin() + blocks.pair_begin[a + 1]);
    for (; joined != touching.end() && (*joined)[0] == int(a); ++joined) pair.push_back((*joined)[1]);
    std::sort(pair.begin() + from, pair.end());
    pair_begin.push_back(int(pair.size()));
  }
  // symbolic factorization and sizes
  analyze(pair_begin, pair, factor);
  coupling.resize(pair.size());
  center.resize(std::size_t(count)), lever.resize(blocks.vertex.size());
}

void TwoLevelSystem::Storage::set_values(const Model& model, const State& state, int block) {
  const Blocks& blocks = model.blocks;
  const Rows& rows = model.rows;
  const System& system = state.system;
  const auto a = std::size_t(block);
  const int first = pair_begin[a], last = pair_begin[a + 1];
  for (int n = first; n < last; n++) coupling[std::size_t(n)].fill(0);
  TURGOR_CHECK(last > first && pair[std::size_t(last - 1)] == block,
               "the last pair of a block is the block itself");
  Block& own = coupling[std::size_t(last - 1)];  // last, since the block itself is the largest of its pairs
  for (int m = blocks.begin[a]; m < blocks.begin[a + 1]; m++) {
    const auto i = std::size_t(blocks.vertex[std::size_t(m)]);
    // diagonal block of a vertex: mass and wind
    if (state.free_mass[i] == 0) continue;
    const Vec3d x(state.x[i]), r = x - center[a];
    const double mass = double(state.free_mass[i]) * double(system.mass_factor);
    double d[3][3] = {{mass, 0, 0}, {0, mass, 0}, {0, 0, mass}};
    for (int k = 0; k < 3; k++) d[k][k] += double(system.air[0][i][k]);
    const Vec3d off(system.air[1][i]);
    d[0][1] += off.x, d[1][0] += off.x, d[0][2] += off.y, d[2][0] += off.y, d[1][2] += off.z,
        d[2][1] += off.z;
    // contacts
    for_each_closed_contact(state, i, [&](double w, const Contact& c, const ImplicitContact& terms) {
      add_contact_stiffness(c, terms, w * w, d);
      for (std::size_t k = 0; k < 4; k++) {
        if (c.vertex[k] < 0 || c.vertex[k] == int(i)) continue;
        const auto j = std::size_t(c.vertex[k]);
        if (blocks.of[j] > block || state.free_mass[j] == 0) continue;
        const auto other = std::size_t(blocks.of[j]);
        const auto pair_at = std::lower_bound(pair.begin() + first, pair.begin() + last, int(other));
        TURGOR_CHECK(pair_at != pair.begin() + last && *pair_at == int(other),
                     "blocks that touch are a pair");
        double b[3][3] = {};
        add_contact_stiffness(c, terms, w * double(c.weight[k]), b);
        add_coupling(b, r, Vec3d(state.x[j]) - center[other], 1,
                     coupling[std::size_t(pair_at - pair.begin())]);
      }
    });
    double rotational[3][3] = {};  // rotational stiffness of sides within the block
    // springs to neighbors
    const std::size_t batch = i / std::size_t(kLanes), l = i % std::size_t(kLanes);
    for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++) {
      const std::size_t e = std::size_t(s) * std::size_t(kLanes) + l;
      if (!(rows.stiffness[e] > 0)) continue;
      const auto j = std::size_t(neighbor(rows, s, int(l)));
      const double along = double(system.along[e]), across = std::max(0.0, double(system.across[e]));
      const Vec3d offset = Vec3d(state.x[j]) - x;
      if (blocks.of[j] == block && state.free_mass[j] > 0) {
        const double half = across / 2, square = half * dot(offset, offset);
        for (int p = 0; p < 3; p++)
          for (int q = 0; q < 3; q++)
            rotational[p][q] += (p == q ? square : 0) - half * offset[p] * offset[q];
        continue;
      }
      double b[3][3];
      for (int p = 0; p < 3; p++)
        for (int q = 0; q < 3; q++) b[p][q] = along * offset[p] * offset[q] + (p == q ? across : 0);
      for (int p = 0; p < 3; p++)
        for (int q = 0; q < 3; q++) d[p][q] += b[p][q];
      if (blocks.of[j] >= block || state.free_mass[j] == 0) continue;
      const auto other = std::size_t(blocks.of[j]);
      const auto pair_at = std::lower_bound(pair.begin() + first, pair.begin() + last, int(other));
      TURGOR_CHECK(pair_at != pair.begin() + last && *pair_at == int(other), "adjacent blocks are a pair");
      add_coupling(b, r, Vec3d(state.x[j]) - center[other], -1,
                   coupling[std::size_t(pair_at - pair.begin())]);
    }
    // own block
    add_coupling(d, r, r, 1, own);
    for (int p = 0; p < 3; p++)
      for (int q = 0; q < 3; q++) own[std::size_t(kRigidModes * (3 + p) + 3 + q)] += rotational[p][q];
  }
  // Modes without mass, and rotations about the line of collinear vertices, are fixed.
  double translations = 0, rotations = 0;
  for (int k = 0; k < 3; k++)
    translations += own[std::size_t(7 * k)], rotations += own[std::size_t(7 * (3 + k))];
  for (int k = 0; k < 3; k++) {
    own[std::size_t(7 * k)] += translations > 0 ? 0 : 1;
    own[std::size_t(7 * (3 + k))] += rotations > 0 ? 1e-6 * rotations : 1;
  }
}

TwoLevelSystem::TwoLevelSystem() = default;
TwoLevelSystem::~TwoLevelSystem() = default;
TwoLevelSystem::TwoLevelSystem(const TwoLevelSystem&) {}
TwoLevelSystem& TwoLevelSystem::operator=(const TwoLevelSystem&) {
  storage.reset(), is_factored = false;
  return *this;
}

void factor_coarse_system(const Exec& exec, const Model& model, const State& state, TwoLevelSystem& system) {
  const Blocks& blocks = model.blocks;
  // pattern
  std::vector<std::array<int, 2>> touching = touching_blocks(blocks, state.implicit_contacts);
  const bool is_new = !system.storage;
  if (is_new) system.storage = std::make_unique<TwoLevelSystem::Storage>();
  if (is_new || touching != system.storage->touching)
    system.storage->set_pattern(blocks, std::move(touching));
  const std::size_t count = blocks.begin.size() - 1;
  // centers of the blocks
  parallel_for(exec, count, [&](std::size_t a) {
    Vec3d sum;
    for (int m = blocks.begin[a]; m < blocks.begin[a + 1]; m++)
      sum += Vec3d(state.x[std::size_t(blocks.vertex[std::size_t(m)])]);
    TURGOR_CHECK(blocks.begin[a + 1] > blocks.begin[a], "a block has vertices");
    const Vec3d center = sum / double(blocks.begin[a + 1] - blocks.begin[a]);
    system.storage->center[a] = center;
    for (auto m = std::size_t(blocks.begin[a]); m < std::size_t(blocks.begin[a + 1]); m++)
      system.storage->lever[m] = Vec3d(state.x[std::size_t(blocks.vertex[m])]) - center;
  });
  // coarse operator and its factor
  parallel_for(exec, count, [&](std::size_t a) { system.storage->set_values(model, state, int(a)); });
  factorize(system.storage->pair_begin, system.storage->pair, system.storage->coupling,
            system.storage->factor);
  system.is_factored = true;
}

void add_coarse_correction(const Exec& exec, const Model& model, const State& state, TwoLevelSystem& system,
                           const Vectors& r, Vectors& z) {
  TURGOR_ASSERT(system.storage != nullptr, "the coarse system was factored");
  const Blocks& blocks = model.blocks;
  const std::size_t count = blocks.begin.size() - 1;
  const Vec3d* lever = system.storage->lever.data();
  std::vector<BlockColumn>& x = system.storage->factor.right_side;
  TURGOR_CHECK(r.size() == z.size(), "a residual and a correction are of the same cloth");
  // restriction: total force and moment of each block
  parallel_for(exec, count, [&](std::size_t a) {
    Vec3d force, moment;
    for (int m = blocks.begin[a]; m < blocks.begin[a + 1]; m++) {
      const auto i = std::size_t(blocks.vertex[std::size_t(m)]);
      if (state.free_mass[i] == 0) continue;
      const Vec3d f(r[i]);
      force += f, moment += cross(lever[m], f);
    }
    x[a] = BlockColumn{force.x, force.y, force.z, moment.x, moment.y, moment.z};
  });
  // coarse solution
  solve(system.storage->factor);
  // prolongation: rigid motion of each block
  parallel_for(exec, count, [&](std::size_t a) {
    const Vec3d translation{x[a][0], x[a][1], x[a][2]}, rotation{x[a][3], x[a][4], x[a][5]};
    for (int m = blocks.begin[a]; m < blocks.begin[a + 1]; m++) {
      const auto i = std::size_t(blocks.vertex[std::size_t(m)]);
      if (state.free_mass[i] > 0) z.add(i, Vec3(translation + cross(rotation, lever[m])));
    }
  });
}

std::size_t coarse_system_bytes(const TwoLevelSystem& system) {
  if (!system.storage) return 0;
  const BlockCholesky& factor = system.storage->factor;
  return system.storage->coupling.size() * sizeof(Block) + system.storage->lever.size() * sizeof(Vec3d) +
         (factor.below.size() + factor.inverse.size()) * sizeof(BlockColumns);
}

}  // namespace turgor::cloth
