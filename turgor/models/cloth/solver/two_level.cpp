#include "turgor/models/cloth/solver/two_level.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "turgor/core/sort_unique.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

namespace {

constexpr int kRigid = 6;  // three ways, three turns

/// Halves a list of vertices across its longer side until the pieces are small.
void halve(const Vectors& x, std::vector<int>::iterator from, std::vector<int>::iterator to, int largest,
           std::vector<std::vector<int>>& pieces) {
  if (to - from <= largest) {
    pieces.emplace_back(from, to);
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
  halve(x, from, middle, largest, pieces);
  halve(x, middle, to, largest, pieces);
}

/// Calls visit(vertex, neighbour) for both ends of every spring: of edges, and of folds where springs resist
/// them.
template <class Visit>
void for_each_neighbor(const Rows& rows, const Visit& visit) {
  for (std::size_t batch = 0; batch < batch_count(rows); batch++)
    for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++)
      for (int l = 0; l < kLanes; l++)
        if (rows.stiffness[std::size_t(s) * std::size_t(kLanes) + std::size_t(l)] > 0)
          visit(int(batch) * kLanes + l, neighbor(rows, s, l));
}

/// Both the blocks and what is in them grow with the square root of the cloth, and the iterations hardly.
int block_size(int count) { return std::max(12, int(0.8 * std::sqrt(double(count)))); }

using Block = std::array<double, kRigid * kRigid>;

/// (I, −[r]×)ᵀ B (I, −[q]×), rows by the ways and turns of the first block.
void add_coupling(const double (&b)[3][3], Vec3d r, Vec3d q, double sign, Block& sum) {
  double left[kRigid][3];
  for (int k = 0; k < 3; k++) {
    const Vec3d column{b[0][k], b[1][k], b[2][k]};
    const Vec3d turn = cross(r, column);
    for (int d = 0; d < 3; d++) left[d][k] = column[d], left[3 + d][k] = turn[d];
  }
  for (int d = 0; d < kRigid; d++) {  // left · (I, −[q]×): the row's cross product
    const Vec3d row{left[d][0], left[d][1], left[d][2]};
    const Vec3d turn = cross(q, row);
    double* out = &sum[std::size_t(d * kRigid)];
    for (int k = 0; k < 3; k++) out[k] += sign * row[k], out[3 + k] += sign * turn[k];
  }
}

/// Calls visit(own weight, contact, how it answers) for the closed contacts of a vertex.
template <class Visit>
void for_each_bearing(const State& state, std::size_t v, const Visit& visit) {
  const Contacts& contacts = state.implicit_contacts.contacts;
  if (contacts.begin.empty()) return;
  for (int m = contacts.begin[v]; m < contacts.begin[v + 1]; m++) {
    const auto item = std::size_t(contacts.item[std::size_t(m)]);
    const ImplicitContact& answer = state.implicit_contacts.answer[item / 4];
    if (answer.normal_stiffness > 0)
      visit(double(contacts.list[item / 4].weight[item % 4]), contacts.list[item / 4], answer);
  }
}

/// d += f (firm n nᵀ + grip (1 − n nᵀ)).
void add_answer_matrix(const Contact& c, const ImplicitContact& a, double f, double (&d)[3][3]) {
  const Vec3d n(c.normal);
  for (int p = 0; p < 3; p++)
    for (int q = 0; q < 3; q++)
      d[p][q] += f * (double(a.normal_stiffness - a.tangential_stiffness) * n[p] * n[q] +
                      (p == q ? double(a.tangential_stiffness) : 0));
}

}  // namespace

Blocks make_blocks(const Model& model) {
  Blocks blocks;
  std::vector<std::vector<int>> pieces;
  const int size = block_size(model.count);
  for (std::size_t p = 0; p + 1 < model.part_begin.size(); p++) {
    std::vector<int> part(std::size_t(model.part_begin[p + 1] - model.part_begin[p]));
    std::iota(part.begin(), part.end(), model.part_begin[p]);
    halve(model.x_rest, part.begin(), part.end(), size, pieces);
  }
  blocks.of.resize(std::size_t(model.count));
  blocks.begin.push_back(0);
  for (std::size_t n = 0; n < pieces.size(); n++) {
    std::sort(pieces[n].begin(), pieces[n].end());
    for (const int v : pieces[n]) blocks.of[std::size_t(v)] = int(n);
    blocks.vertex.insert(blocks.vertex.end(), pieces[n].begin(), pieces[n].end());
    blocks.begin.push_back(int(blocks.vertex.size()));
  }
  std::vector<std::set<int>> touched(pieces.size());
  for (std::size_t n = 0; n < pieces.size(); n++) touched[n].insert(int(n));
  for_each_neighbor(model.rows, [&](int i, int j) {
    const int a = blocks.of[std::size_t(i)], b = blocks.of[std::size_t(j)];
    touched[std::size_t(std::max(a, b))].insert(std::min(a, b));
  });
  blocks.pair_begin.push_back(0);
  for (const std::set<int>& list : touched) {
    blocks.pair.insert(blocks.pair.end(), list.begin(), list.end());
    blocks.pair_begin.push_back(int(blocks.pair.size()));
  }
  return blocks;
}

struct TwoLevelSystem::Parts {
  std::vector<std::array<int, 2>> touching;  // blocks, the larger first, that only contacts join, ascending
  std::vector<int> pair_begin, pair;         // as of Blocks, with these
  std::vector<Vec3d> center;                 // of each block's vertices [m]
  std::vector<Block> coupling;               // by pair
  Eigen::SparseMatrix<double> matrix;        // lower triangle
  std::vector<int> entry;                    // of each value: 36 · pair + place
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;
  Eigen::VectorXd load, answer;

  void lay_out(const Blocks& blocks, std::vector<std::array<int, 2>> by_contacts);
  void couple(const Model& model, const State& state, int block);
};

/// Pairs of blocks that closed contacts join and no edge does.
std::vector<std::array<int, 2>> touching_blocks(const Blocks& blocks,
                                                const ImplicitContacts& implicit_contacts) {
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t n = 0; n < implicit_contacts.answer.size(); n++) {
    const Contact& c = implicit_contacts.contacts.list[n];
    if (c.obstacle >= 0 || !(implicit_contacts.answer[n].normal_stiffness > 0)) continue;
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

void TwoLevelSystem::Parts::lay_out(const Blocks& blocks, std::vector<std::array<int, 2>> by_contacts) {
  const int count = int(blocks.begin.size()) - 1;
  touching = std::move(by_contacts);
  pair.clear(), pair_begin.assign(1, 0), entry.clear();
  auto joined = touching.begin();
  for (std::size_t a = 0; a < std::size_t(count); a++) {
    const auto from = std::ptrdiff_t(pair.size());
    pair.insert(pair.end(), blocks.pair.begin() + blocks.pair_begin[a],
                blocks.pair.begin() + blocks.pair_begin[a + 1]);
    for (; joined != touching.end() && (*joined)[0] == int(a); ++joined) pair.push_back((*joined)[1]);
    std::sort(pair.begin() + from, pair.end());
    pair_begin.push_back(int(pair.size()));
  }
  std::vector<Eigen::Triplet<double>> places;
  for (int a = 0; a < count; a++)
    for (int n = pair_begin[std::size_t(a)]; n < pair_begin[std::size_t(a) + 1]; n++)
      for (int r = 0; r < kRigid; r++)
        for (int c = 0; c < kRigid; c++) {
          const int row = kRigid * a + r, column = kRigid * pair[std::size_t(n)] + c;
          if (row >= column) places.emplace_back(row, column, double(kRigid * kRigid * n + kRigid * r + c));
        }
  matrix.resize(kRigid * count, kRigid * count);
  matrix.setFromTriplets(places.begin(), places.end());
  for (int n = 0; n < matrix.nonZeros(); n++) entry.push_back(int(matrix.valuePtr()[n]));
  for (int n = 0; n < matrix.nonZeros(); n++) matrix.valuePtr()[n] = 1;
  factor.analyzePattern(matrix);
  coupling.resize(pair.size());
  center.resize(std::size_t(count));
  load.resize(kRigid * count), answer.resize(kRigid * count);
}

void TwoLevelSystem::Parts::couple(const Model& model, const State& state, int block) {
  const Blocks& blocks = model.blocks;
  const Rows& rows = model.rows;
  const System& system = state.system;
  const auto a = std::size_t(block);
  const int first = pair_begin[a], last = pair_begin[a + 1];
  for (int n = first; n < last; n++) coupling[std::size_t(n)].fill(0);
  Block& own = coupling[std::size_t(last - 1)];  // the block itself is the largest of its pairs
  for (int m = blocks.begin[a]; m < blocks.begin[a + 1]; m++) {
    const auto i = std::size_t(blocks.vertex[std::size_t(m)]);
    if (state.free_mass[i] == 0) continue;
    const Vec3d x(state.x[i]), r = x - center[a];
    const double mass = double(state.free_mass[i]) * double(system.keep);
    double d[3][3] = {{mass, 0, 0}, {0, mass, 0}, {0, 0, mass}};
    for (int k = 0; k < 3; k++) d[k][k] += double(system.air[0][i][k]);
    const Vec3d off(system.air[1][i]);
    d[0][1] += off.x, d[1][0] += off.x, d[0][2] += off.y, d[2][0] += off.y, d[1][2] += off.z,
        d[2][1] += off.z;
    for_each_bearing(state, i, [&](double w, const Contact& c, const ImplicitContact& its) {
      add_answer_matrix(c, its, w * w, d);
      for (std::size_t k = 0; k < 4; k++) {
        if (c.vertex[k] < 0 || c.vertex[k] == int(i)) continue;
        const auto j = std::size_t(c.vertex[k]);
        if (blocks.of[j] > block || state.free_mass[j] == 0) continue;
        const auto other = std::size_t(blocks.of[j]);
        const auto pair_at = std::lower_bound(pair.begin() + first, pair.begin() + last, int(other));
        double b[3][3] = {};
        add_answer_matrix(c, its, w * double(c.weight[k]), b);
        add_coupling(b, r, Vec3d(state.x[j]) - center[other], 1,
                     coupling[std::size_t(pair_at - pair.begin())]);
      }
    });
    double turn[3][3] = {};  // by sides within the block
    const std::size_t batch = i / std::size_t(kLanes), l = i % std::size_t(kLanes);
    for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++) {
      const std::size_t e = std::size_t(s) * std::size_t(kLanes) + l;
      if (!(rows.stiffness[e] > 0)) continue;
      const auto j = std::size_t(neighbor(rows, s, int(l)));
      const double along = double(system.along[e]), across = std::max(0.0, double(system.across[e]));
      const Vec3d way = Vec3d(state.x[j]) - x;
      if (blocks.of[j] == block && state.free_mass[j] > 0) {
        const double half = across / 2, square = half * dot(way, way);
        for (int p = 0; p < 3; p++)
          for (int q = 0; q < 3; q++) turn[p][q] += (p == q ? square : 0) - half * way[p] * way[q];
        continue;
      }
      double b[3][3];
      for (int p = 0; p < 3; p++)
        for (int q = 0; q < 3; q++) b[p][q] = along * way[p] * way[q] + (p == q ? across : 0);
      for (int p = 0; p < 3; p++)
        for (int q = 0; q < 3; q++) d[p][q] += b[p][q];
      if (blocks.of[j] >= block || state.free_mass[j] == 0) continue;
      const auto other = std::size_t(blocks.of[j]);
      const auto pair_at = std::lower_bound(pair.begin() + first, pair.begin() + last, int(other));
      add_coupling(b, r, Vec3d(state.x[j]) - center[other], -1,
                   coupling[std::size_t(pair_at - pair.begin())]);
    }
    add_coupling(d, r, r, 1, own);
    for (int p = 0; p < 3; p++)
      for (int q = 0; q < 3; q++) own[std::size_t(kRigid * (3 + p) + 3 + q)] += turn[p][q];
  }
  // What has no mass, and what cannot be turned, being on one line, stays.
  double ways = 0, turns = 0;
  for (int k = 0; k < 3; k++) ways += own[std::size_t(7 * k)], turns += own[std::size_t(7 * (3 + k))];
  for (int k = 0; k < 3; k++) {
    own[std::size_t(7 * k)] += ways > 0 ? 0 : 1;
    own[std::size_t(7 * (3 + k))] += turns > 0 ? 1e-6 * turns : 1;
  }
}

TwoLevelSystem::TwoLevelSystem() = default;
TwoLevelSystem::~TwoLevelSystem() = default;
TwoLevelSystem::TwoLevelSystem(const TwoLevelSystem&) {}
TwoLevelSystem& TwoLevelSystem::operator=(const TwoLevelSystem&) { return parts_.reset(), *this; }

bool TwoLevelSystem::factor(const Exec& exec, const Model& model, const State& state) {
  const Blocks& blocks = model.blocks;
  std::vector<std::array<int, 2>> touching = touching_blocks(blocks, state.implicit_contacts);
  const bool is_new = !parts_;
  if (is_new) parts_ = std::make_unique<Parts>();
  if (is_new || touching != parts_->touching) parts_->lay_out(blocks, std::move(touching));
  const std::size_t count = blocks.begin.size() - 1;
  parallel_for(exec, count, [&](std::size_t a) {
    Vec3d sum;
    for (int m = blocks.begin[a]; m < blocks.begin[a + 1]; m++)
      sum += Vec3d(state.x[std::size_t(blocks.vertex[std::size_t(m)])]);
    parts_->center[a] = sum / double(blocks.begin[a + 1] - blocks.begin[a]);
  });
  parallel_for(exec, count, [&](std::size_t a) { parts_->couple(model, state, int(a)); });
  const double* values = parts_->coupling.empty() ? nullptr : parts_->coupling[0].data();
  for (std::size_t n = 0; n < parts_->entry.size(); n++)
    parts_->matrix.valuePtr()[n] = values[parts_->entry[n]];
  parts_->factor.factorize(parts_->matrix);
  return parts_->factor.info() == Eigen::Success;
}

void TwoLevelSystem::add_answer(const Exec& exec, const Model& model, const State& state, const Vectors& r,
                                Vectors& z) {
  const Blocks& blocks = model.blocks;
  const std::size_t count = blocks.begin.size() - 1;
  parallel_for(exec, count, [&](std::size_t a) {
    Vec3d way, turn;
    for (int m = blocks.begin[a]; m < blocks.begin[a + 1]; m++) {
      const auto i = std::size_t(blocks.vertex[std::size_t(m)]);
      if (state.free_mass[i] == 0) continue;
      const Vec3d f(r[i]);
      way += f, turn += cross(Vec3d(state.x[i]) - parts_->center[a], f);
    }
    for (int k = 0; k < 3; k++)
      parts_->load[kRigid * int(a) + k] = way[k], parts_->load[kRigid * int(a) + 3 + k] = turn[k];
  });
  parts_->answer = parts_->factor.solve(parts_->load);
  parallel_for(exec, count, [&](std::size_t a) {
    const double* y = parts_->answer.data() + kRigid * int(a);
    const Vec3d way{y[0], y[1], y[2]}, turn{y[3], y[4], y[5]};
    for (int m = blocks.begin[a]; m < blocks.begin[a + 1]; m++) {
      const auto i = std::size_t(blocks.vertex[std::size_t(m)]);
      if (state.free_mass[i] > 0) z.add(i, Vec3(way + cross(turn, Vec3d(state.x[i]) - parts_->center[a])));
    }
  });
}

std::size_t TwoLevelSystem::bytes() const {
  if (!parts_) return 0;
  return parts_->coupling.size() * sizeof(Block) + 12 * std::size_t(parts_->matrix.nonZeros()) * 6;
}

}  // namespace turgor::cloth
