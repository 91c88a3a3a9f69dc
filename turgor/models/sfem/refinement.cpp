#include "turgor/models/sfem/refinement.hpp"

#include <algorithm>
#include <map>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

namespace {

/// Subdivision of one element, the same for all elements of a kind.
struct Subdivision {
  std::vector<std::array<int, 8>> weight;  // of each corner at each point; their sum is `denominator`
  int denominator = 1;
  std::vector<int> corners;             // points of the fine elements
  std::vector<int> shape;               // of each: the order of axes in Kuhn's rule
  std::vector<std::vector<Int3>> face;  // triangles of points on each face
};

/// Points and elements of a tetrahedron in r³ parts: it is the simplex r ≥ a ≥ b ≥ c ≥ 0 of a grid whose
/// cells are cut by Kuhn's rule, with corners (0,0,0), (r,0,0), (r,r,0), (r,r,r).
void subdivide_tet(int r, Subdivision& sub) {
  std::map<std::array<int, 3>, int> number;
  sub.denominator = r;
  for (int a = 0; a <= r; a++)
    for (int b = 0; b <= a; b++)
      for (int c = 0; c <= b; c++) {
        number[{a, b, c}] = int(sub.weight.size());
        sub.weight.push_back({r - a, a - b, b - c, c});
      }
  static constexpr std::array<std::array<int, 3>, 6> kOrders{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};  // even ones first
  for (int a = 0; a < r; a++)
    for (int b = 0; b <= a; b++)
      for (int c = 0; c <= b; c++)
        for (std::size_t o = 0; o < kOrders.size(); o++) {
          std::array<int, 3> p{a, b, c};
          std::array<int, 4> tet{number[p]};
          bool inside = true;
          for (std::size_t step = 0; step < 3; step++) {
            p[std::size_t(kOrders[o][step])]++;
            inside = inside && p[0] >= p[1] && p[1] >= p[2] && p[0] <= r;
            if (inside) tet[step + 1] = number[p];
          }
          if (!inside) continue;
          if (o >= 3) std::swap(tet[2], tet[3]);  // an odd order turns the simplex inside out
          sub.corners.insert(sub.corners.end(), tet.begin(), tet.end());
          sub.shape.push_back(int(o));
        }
}

void subdivide_hex(int r, Subdivision& sub) {
  // trilinear weights of the points
  const auto number = [r](int i, int j, int k) { return (k * (r + 1) + j) * (r + 1) + i; };
  sub.denominator = r * r * r;
  for (int k = 0; k <= r; k++)
    for (int j = 0; j <= r; j++)
      for (int i = 0; i <= r; i++) {
        const int x0 = r - i, y0 = r - j, z0 = r - k;
        sub.weight.push_back({x0 * y0 * z0, i * y0 * z0, i * j * z0, x0 * j * z0, x0 * y0 * k, i * y0 * k,
                              i * j * k, x0 * j * k});
      }
  // elements
  for (int k = 0; k < r; k++)
    for (int j = 0; j < r; j++)
      for (int i = 0; i < r; i++)
        for (const Int3 c :
             {Int3{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}})
          sub.corners.push_back(number(i + c.x, j + c.y, k + c.z));
  sub.shape.assign(std::size_t(r * r * r), 0);
}

/// The triangles of fine elements that lie on each face of the coarse one.
void find_faces(const SolidMesh& kind, Subdivision& sub) {
  const auto table = element_faces(kind);
  const std::size_t n = std::size_t(kind.corners), size = n == 4 ? 3 : 4;
  sub.face.resize(table.size());
  const auto on_face = [&](int point, std::size_t face) {
    for (std::size_t c = 0; c < n; c++) {
      const bool of_face = std::find(table[face].begin(), table[face].end(), int(c)) != table[face].end();
      if (!of_face && sub.weight[std::size_t(point)][c] != 0) return false;
    }
    return true;
  };
  for (std::size_t e = 0; e < sub.corners.size(); e += n)
    for (const auto& fine : table) {
      const auto point = [&](std::size_t c) { return sub.corners[e + std::size_t(fine[c])]; };
      for (std::size_t f = 0; f < table.size(); f++) {
        bool all = true;
        for (std::size_t c = 0; c < size; c++) all = all && on_face(point(c), f);
        for (std::size_t t = 0; all && t + 2 < size; t++)
          sub.face[f].push_back({point(0), point(t + 1), point(t + 2)});
      }
    }
}

/// The parts of a tetrahedron with the middles of their edges: points of a grid twice as fine, whose
/// triangles are those of the faces.
void subdivide_quadratic(const SolidMesh& linear, int r, Subdivision& sub) {
  Subdivision linear_sub;
  // elements of the coarse grid, points of the fine one
  subdivide_tet(r, linear_sub);
  subdivide_tet(2 * r, sub);
  find_faces(linear, sub);
  // points by their weights
  std::map<std::array<int, 8>, int> number;
  for (const auto& weight : sub.weight) number[weight] = int(number.size());
  sub.corners.clear();
  sub.shape = linear_sub.shape;
  // corners and edge midpoints of each element
  for (std::size_t e = 0; e < linear_sub.corners.size(); e += 4) {
    const auto middle = [&](int a, int b) {
      std::array<int, 8> sum = linear_sub.weight[std::size_t(linear_sub.corners[e + std::size_t(a)])];
      for (std::size_t c = 0; c < 4; c++)
        sum[c] += linear_sub.weight[std::size_t(linear_sub.corners[e + std::size_t(b)])][c];
      return number.at(sum);
    };
    for (int c = 0; c < 4; c++) sub.corners.push_back(middle(c, c));
    for (const auto [a, b] : kTetEdges) sub.corners.push_back(middle(a, b));
  }
}

constexpr int kMaxRefinement = 4;

const Subdivision& subdivision(const SolidMesh& kind, int r) {
  TURGOR_CHECK(r >= 1 && r <= kMaxRefinement, "an edge has 1 to kMaxRefinement parts");
  // build all levels once
  static const auto kAll = [] {
    std::array<std::array<Subdivision, kMaxRefinement + 1>, 3> all;
    const SolidMesh tet{{}, 4, {}, {}}, hex{{}, 8, {}, {}};
    for (int level = 1; level <= kMaxRefinement; level++) {
      const auto n = std::size_t(level);
      subdivide_tet(level, all[0][n]), find_faces(tet, all[0][n]);
      subdivide_hex(level, all[1][n]), find_faces(hex, all[1][n]);
      subdivide_quadratic(tet, level, all[2][n]);
    }
    return all;
  }();
  // select by element type
  return kAll[kind.corners == 4 ? 0 : kind.corners == 8 ? 1 : 2][std::size_t(r)];
}

/// Finds nodes by key; open addressing, never more than half full.
class NodeTable {
 public:
  explicit NodeTable(std::size_t most) {
    std::size_t size = 64;
    while (size < 2 * most) size *= 2;
    slots_.assign(size, -1);
  }
  /// Number stored for a key; a new key stores `next`.
  int find_or_add(std::uint64_t key, int next, const std::vector<FineNode>& nodes) {
    for (std::size_t at = key & (slots_.size() - 1);; at = (at + 1) & (slots_.size() - 1)) {
      if (slots_[at] < 0) return slots_[at] = next;
      if (nodes[std::size_t(slots_[at])].key == key) return slots_[at];
    }
  }

 private:
  std::vector<int> slots_;
};

/// Order-free, so that every element that shares a node finds the same key.
std::uint64_t key_of(std::span<const int> element, const std::array<int, 8>& weight, int r) {
  std::uint64_t key = detail::mix(kHashSeed, std::uint64_t(r));
  for (std::size_t c = 0; c < std::min(element.size(), weight.size()); c++)
    if (weight[c] != 0)
      key += detail::mix(detail::mix(kHashSeed, std::uint64_t(element[c]) + 1), std::uint64_t(weight[c]));
  return key;
}

/// The values of an element's functions at a point of its subdivision.
std::array<double, 10> functions_at(const SolidMesh& kind, const std::array<int, 8>& weight,
                                    int denominator) {
  std::array<double, 10> value{};
  for (std::size_t c = 0; c < 8; c++) value[c] = double(weight[c]) / denominator;
  TURGOR_CHECK(sums_to_one(value), "the weights of a point sum to one");
  return kind.corners == 10 ? quadratic_weights({value[0], value[1], value[2], value[3]}) : value;
}

FineNode make_node(const Model& model, std::span<const int> element, const std::array<double, 10>& value,
                   std::uint64_t key) {
  FineNode node;
  node.key = key;
  for (std::size_t c = 0; c < element.size(); c++) {
    if (value[c] == 0) continue;
    node.x += model.body.mesh.vertices[std::size_t(element[c])] * value[c];
    node.at_vertex = node.at_vertex || value[c] == 1;
    if (model.free_node[std::size_t(element[c])] < 0) continue;
    TURGOR_CHECK(is_index(node.supports, node.coarse.size()), "the supports of a node fit its storage");
    node.coarse[std::size_t(node.supports)] = element[c];
    node.weight[std::size_t(node.supports++)] = value[c];
  }
  return node;
}

bool is_fixed_face(const Model& model, std::span<const int> element, const std::array<int, 4>& face) {
  const auto is_fixed = [&](int node) {
    return node < 0 || model.body.fixed[std::size_t(element[std::size_t(node)])];
  };
  if (element.size() == 10)
    for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {2, 0}})
      if (!is_fixed(node_between(face[std::size_t(a)], face[std::size_t(b)]))) return false;
  return std::all_of(face.begin(), face.end(), is_fixed);
}

}  // namespace

FineMesh refine(const Model& model, std::span<const int> elements, int refinement) {
  TURGOR_ASSERT(refinement >= 1 && refinement <= kMaxRefinement, "a patch has 1 to 4 parts an edge");
  const SolidMesh& mesh = model.body.mesh;
  const Subdivision& sub = subdivision(mesh, refinement);
  const auto faces = element_faces(mesh);
  FineMesh fine;
  NodeTable table(elements.size() * sub.weight.size());
  std::vector<int> number(sub.weight.size());  // of the points of the present element
  fine.nodes.reserve(elements.size() * sub.weight.size());
  for (const int e : elements) {
    const auto corners = element(mesh, std::size_t(e));
    for (std::size_t p = 0; p < sub.weight.size(); p++) {
      const std::uint64_t key = key_of(corners, sub.weight[p], refinement);
      number[p] = table.find_or_add(key, int(fine.nodes.size()), fine.nodes);
      if (number[p] == int(fine.nodes.size()))
        fine.nodes.push_back(
            make_node(model, corners, functions_at(mesh, sub.weight[p], sub.denominator), key));
    }
    for (const int point : sub.corners) fine.corners.push_back(number[std::size_t(point)]);
    fine.parent.insert(fine.parent.end(), sub.shape.size(), e);
    fine.shape.insert(fine.shape.end(), sub.shape.begin(), sub.shape.end());
    for (std::size_t f = 0; f < faces.size(); f++) {
      const int across = model.neighbors[std::size_t(e) * faces.size() + f];
      if (across >= 0 && std::binary_search(elements.begin(), elements.end(), across)) continue;
      const bool fixed = across < 0 && is_fixed_face(model, corners, faces[f]);
      for (const Int3 points : sub.face[f]) {
        const Int3 triangle{number[std::size_t(points.x)], number[std::size_t(points.y)],
                            number[std::size_t(points.z)]};
        if (across < 0) fine.outer.push_back(triangle);
        for (const int node : {triangle.x, triangle.y, triangle.z}) {
          FineNode& touched = fine.nodes[std::size_t(node)];
          touched.on_border = touched.on_border || across >= 0;
          touched.fixed = touched.fixed || fixed;
        }
      }
    }
  }
  TURGOR_CHECK(fine.parent.size() == fine.shape.size(), "every fine element has a shape");
  return fine;
}

}  // namespace turgor::sfem
