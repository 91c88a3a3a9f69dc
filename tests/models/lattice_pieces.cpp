// Into how many parts blades cut a body: by its nodes, by the pieces of its cells, by what is drawn.
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "block_body.hpp"
#include "ct_body.hpp"
#include "turgor/models/lattice/incision.hpp"
#include "turgor/models/lattice/surface.hpp"

namespace turgor::lattice {
namespace {

class Joined {
 public:
  int add() { return parent_.push_back(int(parent_.size())), int(parent_.size()) - 1; }
  int root(int n) {
    while (parent_[std::size_t(n)] != n)
      n = parent_[std::size_t(n)] = parent_[std::size_t(parent_[std::size_t(n)])];
    return n;
  }
  void join(int a, int b) { parent_[std::size_t(root(a))] = root(b); }
  int count() {
    int count = 0;
    for (int n = 0; n < int(parent_.size()); n++) count += root(n) == n;
    return count;
  }

 private:
  std::vector<int> parent_;
};

template <class Key>
struct JoinedKeys {
  std::map<Key, int> index;
  Joined joined;

  int of(const Key& key) {
    const auto [at, is_new] = index.try_emplace(key, 0);
    if (is_new) at->second = joined.add();
    return at->second;
  }
};

template <class Visit>
void for_nodes(Int3 size, const Visit& visit) {
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) visit(Int3{i, j, k});
}

/// By edges that are not cut.
int parts_of_nodes(const Model& model, const State& state) {
  JoinedKeys<int> nodes;
  for_nodes(model.lattice.size, [&](Int3 a) {
    const int slot = node_slot(model.lattice, a);
    if (!is_solid(model, state, slot)) return;
    const int here = nodes.of(slot);
    for (std::size_t f = 0; f < kFamilyCount; f++) {
      const Int3 b = a + kFamilies[f];
      if (!contains(model.lattice, b) || state.cut[std::size_t(slot)] >> f & 1) continue;
      const int other = node_slot(model.lattice, b);
      if (is_solid(model, state, other)) nodes.joined.join(here, nodes.of(other));
    }
  });
  return nodes.joined.count();
}

/// By the corners that pieces have in common.
int parts_of_pieces(const Model& model, const State& state) {
  const Pieces pieces = make_pieces(model, state);
  JoinedKeys<int> corners;
  for_nodes(model.lattice.size - Int3{1, 1, 1}, [&](Int3 cell) {
    const int slot = node_slot(model.lattice, cell);
    const CutCell* cut = find_cell(pieces, slot);
    for (int p = 0; p < (cut ? cut->piece_count : 1); p++) {
      const auto own = corners_of(model, pieces, slot, cut ? p : -1);
      const auto is_tissue = [&](int c) {
        const int nodes = slot_count(model.lattice);
        return is_solid(model, state, c < nodes ? c : pieces.copies[std::size_t(c - nodes)].slot);
      };
      int first = -1;
      for (const int c : own)
        if (is_tissue(c))
          first = first < 0 ? corners.of(c) : (corners.joined.join(first, corners.of(c)), first);
    }
  });
  return corners.joined.count();
}

/// By triangles; skin, caps and walls meet where their vertices are carried alike.
int parts_of_surface(const Model& model, const State& state) {
  const BodySurface surface = build_surface(model, state);
  JoinedKeys<std::array<int, 12>> vertices;
  std::vector<int> name;
  for (std::size_t v = 0; v < surface.rest.size(); v++) {
    const Vec3 x = surface.rest[v];
    const auto corners = corners_of(model, surface.pieces, surface.carrier[v].cell, surface.carrier[v].piece);
    std::array<int, 12> key{int(std::lround(x.x * 1e7)), int(std::lround(x.y * 1e7)),
                            int(std::lround(x.z * 1e7)), surface.carrier[v].cell};
    std::copy(corners.begin(), corners.end(), key.begin() + 4);
    name.push_back(vertices.of(key));
  }
  for (const Int3 t : surface.triangles) {
    vertices.joined.join(name[std::size_t(t.x)], name[std::size_t(t.y)]);
    vertices.joined.join(name[std::size_t(t.y)], name[std::size_t(t.z)]);
  }
  return vertices.joined.count();
}

/// A block of 96 × 80 × 24 mm under skin, its bottom held.
Model block_of(double step) {
  const Int3 size{int(std::lround(0.096 / step)) + 1, int(std::lround(0.08 / step)) + 1,
                  int(std::lround(0.024 / step)) + 1};
  Block block{.size = size, .step = step, .is_fixed = [](Int3 p) { return p.z == 0; }};
  Params params;
  params.tissue.volume = 1;
  return block_model(block, params);
}

struct Blade {
  std::vector<Vec3d> path;  // on the skin, x and y [m]
  double depth, tilt = 0;
};

void cut(const Model& model, State& state, const Blade& blade, int index) {
  Incision incision{
      .name = "blade", .from = {}, .to = {}, .path = blade.path, .depth = blade.depth, .tilt = blade.tilt};
  for (Vec3d& p : incision.path) p.z = (model.lattice.size.z - 2) * double(model.lattice.step.z);
  if (incision.path.size() == 2)
    incision.from = incision.path[0], incision.to = incision.path[1], incision.path.clear();
  const Result<BladePath> path = lay_blade(model, state, incision);
  ASSERT_TRUE(path) << path.error().message;
  // In parts, as a blade that moves does.
  for (const double part : {0.0, 0.25, 0.6})
    cut_edges(model, state, *path, part, part == 0 ? 0.25 : part < 0.5 ? 0.6 : 1, index);
}

std::vector<Vec3d> ellipse(Vec3d middle, double a, double b, double turn) {
  std::vector<Vec3d> points;
  for (int n = 0; n <= 12; n++) {  // clockwise from above
    const double w = -2 * std::numbers::pi * (n % 12) / 12, x = a * std::cos(w), y = b * std::sin(w);
    points.push_back(
        middle + Vec3d{x * std::cos(turn) - y * std::sin(turn), x * std::sin(turn) + y * std::cos(turn), 0});
  }
  return points;
}

constexpr double kDeep = 0.03;  // deeper than the block [m]

struct Pattern {
  const char* name;
  std::vector<Blade> blades;
  int parts;
};

std::vector<Pattern> patterns() {
  const Vec3d m{0.0481, 0.0397, 0};
  const auto line = [&](double x0, double y0, double x1, double y1, double depth, double tilt = 0) {
    return Blade{{m + Vec3d{x0, y0, 0}, m + Vec3d{x1, y1, 0}}, depth, tilt};
  };
  return {
      {"a T", {line(-0.025, 0.003, 0.025, 0.003, 0.01), line(0.002, -0.025, 0.002, 0.003, 0.01)}, 1},
      {"an X", {line(-0.025, -0.02, 0.025, 0.02, 0.01), line(-0.025, 0.02, 0.025, -0.02, 0.01)}, 1},
      {"a T all through",
       {line(-0.0481, 0.0031, 0.0479, 0.0031, kDeep), line(0.0013, -0.0397, 0.0013, 0.0031, kDeep)},
       3},
      {"an X all through",
       {line(-0.0481, -0.03, 0.0479, 0.03, kDeep), line(-0.0481, 0.03, 0.0479, -0.03, kDeep)},
       4},
      {"one oblique, all through", {line(-0.0481, -0.011, 0.0479, -0.011, kDeep, 35)}, 2},
      {"an ellipse", {{ellipse(m, 0.02, 0.012, 0.4), 0.01, 0}}, 1},
      {"an ellipse and a cut below it",
       {{ellipse(m, 0.02, 0.012, 0.4), 0.015, 0}, line(0.03, -0.026, -0.03, -0.026, 0.014, 72)},
       2},
      {"an S",
       {{{m + Vec3d{-0.03, -0.01, 0}, m + Vec3d{-0.015, 0.012, 0}, m, m + Vec3d{0.015, -0.012, 0},
          m + Vec3d{0.03, 0.01, 0}},
         0.01,
         0}},
       1},
  };
}

TEST(lattice_pieces, blades_leave_as_many_parts_as_their_geometry_says_at_once_and_when_wounds_gape) {
  for (const double size : {0.004, 0.0032})
    for (const Pattern& pattern : patterns())
      for (const bool gaping : {false, true}) {
        const Model model = block_of(size);
        State state = make_state(model);
        for (std::size_t n = 0; n < pattern.blades.size(); n++) {
          cut(model, state, pattern.blades[n], int(n));
          const bool ends_inside =
              pattern.blades[n].depth < kDeep;  // else what moves moves beyond the blade's ends
          for (int frame = 0; gaping && ends_inside && frame < 6; frame++)
            step(Exec(2), model, state, {}, 1.0 / 60);
        }
        const std::string where = std::string(pattern.name) + (gaping ? ", gaping" : "");
        EXPECT_EQ(parts_of_nodes(model, state), pattern.parts) << where << ", nodes, step " << size;
        EXPECT_EQ(parts_of_pieces(model, state), pattern.parts) << where << ", pieces, step " << size;
        EXPECT_EQ(parts_of_surface(model, state), pattern.parts) << where << ", surface, step " << size;
      }
}

}  // namespace
}  // namespace turgor::lattice
