// Numbers of components of a cut body: by its nodes, by the fragments of its cells, and by its drawn surface.
#pragma once

#include <array>
#include <cmath>
#include <map>

#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {

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

/// Connected by edges that are not cut.
inline int components_of_nodes(const Model& model, const State& state) {
  JoinedKeys<int> nodes;
  for_nodes(model.anatomy.lattice.size, [&](Int3 a) {
    const int slot = node_slot(model.anatomy.lattice, a);
    if (!is_solid(model, state.cuts, slot)) return;
    const int current = nodes.of(slot);
    for (std::size_t f = 0; f < kFamilyCount; f++) {
      const Int3 b = a + kFamilies[f];
      if (!contains(model.anatomy.lattice, b) || state.cuts.cut[std::size_t(slot)] >> f & 1) continue;
      const int other = node_slot(model.anatomy.lattice, b);
      if (is_solid(model, state.cuts, other)) nodes.joined.join(current, nodes.of(other));
    }
  });
  return nodes.joined.count();
}

/// Connected by common corners of fragments.
inline int components_of_fragments(const Model& model, const State& state) {
  const Fragments fragments = make_fragments(model, state.cuts);
  JoinedKeys<int> corners;
  for_nodes(model.anatomy.lattice.size - Int3{1, 1, 1}, [&](Int3 cell) {
    const int slot = node_slot(model.anatomy.lattice, cell);
    const CutCell* cut = find_cell(fragments, slot);
    for (int p = 0; p < (cut ? cut->fragment_count : 1); p++) {
      const auto own = corners_of(model, fragments, slot, cut ? p : -1);
      const auto is_tissue = [&](int c) {
        const int nodes = slot_count(model.anatomy.lattice);
        return is_solid(model, state.cuts,
                        c < nodes ? c : fragments.virtual_nodes[std::size_t(c - nodes)].slot);
      };
      int first = -1;
      for (const int c : own)
        if (is_tissue(c))
          first = first < 0 ? corners.of(c) : (corners.joined.join(first, corners.of(c)), first);
    }
  });
  return corners.joined.count();
}

/// Connected by triangles; skin, caps and walls join where their vertices have the same embedding.
inline int components_of_surface(const Model& model, const State& state) {
  const BodySurface surface = build_surface(model, state.cuts);
  JoinedKeys<std::array<int, 12>> vertices;
  std::vector<int> name;
  for (std::size_t v = 0; v < surface.rest.size(); v++) {
    const Vec3 x = surface.rest[v];
    const auto corners =
        corners_of(model, *surface.fragments, surface.embedding[v].cell, surface.embedding[v].fragment);
    std::array<int, 12> key{int(std::lround(x.x * 1e7)), int(std::lround(x.y * 1e7)),
                            int(std::lround(x.z * 1e7)), surface.embedding[v].cell};
    std::copy(corners.begin(), corners.end(), key.begin() + 4);
    name.push_back(vertices.of(key));
  }
  for (const Int3 t : surface.triangles) {
    vertices.joined.join(name[std::size_t(t.x)], name[std::size_t(t.y)]);
    vertices.joined.join(name[std::size_t(t.y)], name[std::size_t(t.z)]);
  }
  return vertices.joined.count();
}

}  // namespace turgor::lattice
