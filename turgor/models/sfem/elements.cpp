#include "turgor/models/sfem/elements.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/quadratic.hpp"

namespace turgor::sfem {

namespace {

/// K of an isotropic material from the moments G_ai,bj = ∫ ∂N_a/∂x_i ∂N_b/∂x_j dV:
/// K_ai,bj = λ G_ai,bj + μ G_aj,bi + μ δ_ij Σ_k G_ak,bk with λ = bulk − 2/3 μ.
template <std::size_t kCorners>
void stiffness_of_moments(const double* g, Moduli m, double* k) {
  constexpr std::size_t n = 3 * kCorners;
  const double lambda = m.bulk - 2.0 / 3 * m.shear;
  for (std::size_t a = 0; a < n; a += 3)
    for (std::size_t b = 0; b < n; b += 3) {
      const double trace = g[a * n + b] + g[(a + 1) * n + b + 1] + g[(a + 2) * n + b + 2];
      for (std::size_t i = 0; i < 3; i++)
        for (std::size_t j = 0; j < 3; j++)
          k[(a + i) * n + b + j] = lambda * g[(a + i) * n + b + j] + m.shear * g[(a + j) * n + b + i] +
                                   (i == j ? m.shear * trace : 0);
    }
}

/// Gradient of a tetrahedron's volume by each corner's position [m²]. Divided by the volume, it is the
/// gradient of the corner's shape function.
std::array<Vec3d, 4> volume_gradients(const std::array<Vec3d, 4>& x) {
  const Vec3d a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  const Vec3d g1 = cross(b, c) / 6, g2 = cross(c, a) / 6, g3 = cross(a, b) / 6;
  return {-(g1 + g2 + g3), g1, g2, g3};
}

/// Gradients of an element's functions at its Gauss points, and the volume that each of those stands for.
template <std::size_t kNodes, std::size_t kPoints>
struct GaussPoints {
  std::array<std::array<double, 3 * kNodes>, kPoints> gradient;  // of each point [1/m]
  std::array<double, kPoints> volume;                            // [m³]

  /// Sets point p from the functions' derivatives in element coordinates and the weight of the point.
  void set(std::size_t p, const std::array<Vec3d, kNodes>& x, const std::array<Vec3d, kNodes>& slope,
           double weight) {
    Mat3d map{{{}, {}, {}}};
    for (std::size_t c = 0; c < kNodes; c++)
      for (int axis = 0; axis < 3; axis++) map.column[axis] += x[c] * slope[c][axis];
    volume[p] = weight * determinant(map);
    const Mat3d to_space = transposed(inverse(map));
    for (std::size_t c = 0; c < kNodes; c++) {
      const Vec3d g = to_space * slope[c];
      for (int axis = 0; axis < 3; axis++) gradient[p][3 * c + std::size_t(axis)] = g[axis];
    }
  }
};

constexpr std::array<Vec3d, 8> kHexCorner{
    {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};
constexpr double kGauss = 0.57735026918962576451;  // 1/√3

GaussPoints<8, 8> hex_points(const std::array<Vec3d, 8>& x) {
  GaussPoints<8, 8> points;
  for (std::size_t p = 0; p < 8; p++) {
    std::array<Vec3d, 8> slope;  // of each shape function in the cube [-1, 1]³
    for (std::size_t c = 0; c < 8; c++) {
      const Vec3d s = kHexCorner[c], t = Vec3d{1, 1, 1} + hadamard(s, kHexCorner[p] * kGauss);
      slope[c] = Vec3d{s.x * t.y * t.z, s.y * t.x * t.z, s.z * t.x * t.y} / 8;
    }
    points.set(p, x, slope, 1);
  }
  return points;
}

/// In the tetrahedron 0 ≤ x, y, z, x + y + z ≤ 1, whose linear functions are 1 − x − y − z, x, y, z.
GaussPoints<10, 4> quadratic_points(const std::array<Vec3d, 10>& x) {
  static constexpr double kNear = 0.58541019662496845446, kFar = 0.13819660112501051518;  // (5 ± 3√5, −√5)/20
  GaussPoints<10, 4> points;
  for (std::size_t p = 0; p < 4; p++) {
    std::array<double, 4> linear{kFar, kFar, kFar, kFar};
    linear[p] = kNear;
    points.set(p, x, quadratic_slopes(linear), 1.0 / 24);
  }
  return points;
}

/// Moments of an element, summed over its Gauss points.
template <std::size_t kNodes>
struct Moments {
  std::array<double, 9 * kNodes * kNodes> of_gradients{};
  std::array<double, 3 * kNodes> swelling{};  // volume gradient by each node's position [m²]
  double volume = 0;                          // [m³]
};

template <std::size_t kNodes, std::size_t kPoints>
Moments<kNodes> moments_of(const GaussPoints<kNodes, kPoints>& points) {
  constexpr std::size_t n = 3 * kNodes;
  Moments<kNodes> moments;
  for (std::size_t p = 0; p < kPoints; p++) {
    const double root = std::sqrt(points.volume[p]);  // shared by both factors: exactly symmetric
    std::array<double, n> g = points.gradient[p];
    for (double& slope : g) slope *= root;
    moments.volume += points.volume[p];
    for (std::size_t a = 0; a < n; a++) {
      moments.swelling[a] += root * g[a];
      for (std::size_t b = 0; b < n; b++) moments.of_gradients[a * n + b] += g[a] * g[b];
    }
  }
  return moments;
}

/// Contribution of one corner of a tetrahedron to the nodal volume of one of its vertices.
struct VolumeShare {
  int material, vertex;
  double volume;   // [m³]
  Vec3d gradient;  // [m²]

  bool operator<(const VolumeShare& other) const {
    return std::pair(material, vertex) < std::pair(other.material, other.vertex);
  }
};

void add_shares(const SolidMesh& mesh, std::size_t e, int material, std::vector<VolumeShare>& shares) {
  std::array<Vec3d, 4> x;
  for (std::size_t c = 0; c < 4; c++) x[c] = mesh.vertices[std::size_t(element(mesh, e)[c])];
  const std::array<Vec3d, 4> g = volume_gradients(x);
  for (std::size_t c = 0; c < 4; c++)
    shares.push_back({material, element(mesh, e)[c], volume(mesh, e) / 16, g[c] / 4});
}

}  // namespace

void tet_stiffness(const std::array<Vec3d, 4>& x, Moduli m, std::span<double, 144> k) {
  const std::array<Vec3d, 4> g = volume_gradients(x);
  const double volume = orientation(x[0], x[1], x[2], x[3]) / 6;
  TURGOR_CHECK(volume > 0, "a tetrahedron has a volume");
  std::array<double, 144> moments;
  for (std::size_t a = 0; a < 12; a++)
    for (std::size_t b = 0; b < 12; b++)
      moments[a * 12 + b] = g[a / 3][int(a % 3)] * g[b / 3][int(b % 3)] / volume;
  stiffness_of_moments<4>(moments.data(), m, k.data());
}

void hex_stiffness(const std::array<Vec3d, 8>& x, const Material& material, Formulation formulation,
                   std::span<double, 576> k) {
  const Moments<8> moments = moments_of(hex_points(x));
  const bool averaged = formulation == Formulation::kAveraged;
  const Moduli m = moduli(material);
  stiffness_of_moments<8>(moments.of_gradients.data(), {averaged ? 0 : m.bulk, m.shear}, k.data());
  if (!averaged) return;
  TURGOR_CHECK(moments.volume > 0, "a hexahedron has a volume");
  for (std::size_t a = 0; a < 24; a++)
    for (std::size_t b = 0; b < 24; b++)
      k[a * 24 + b] += m.bulk / moments.volume * (moments.swelling[a] * moments.swelling[b]);
}

void quadratic_stiffness(const std::array<Vec3d, 10>& x, const Material& material, std::span<double, 900> k) {
  const Moments<10> moments = moments_of(quadratic_points(x));
  stiffness_of_moments<10>(moments.of_gradients.data(), moduli(material), k.data());
}

double least_hex_volume(const std::array<Vec3d, 8>& x) {
  const std::array<double, 8> volume = hex_points(x).volume;
  return 8 * *std::min_element(volume.begin(), volume.end());
}

double least_quadratic_volume(const std::array<Vec3d, 10>& x) {
  const std::array<double, 4> volume = quadratic_points(x).volume;
  return 4 * *std::min_element(volume.begin(), volume.end());
}

namespace {

template <std::size_t kNodes, std::size_t kPoints>
void append_points(const GaussPoints<kNodes, kPoints>& points, std::vector<double>& gradient,
                   std::vector<double>& volume) {
  for (const auto& g : points.gradient) gradient.insert(gradient.end(), g.begin(), g.end());
  volume.insert(volume.end(), points.volume.begin(), points.volume.end());
}

template <std::size_t kNodes>
std::array<Vec3d, kNodes> first_nodes(std::span<const Vec3d> x) {
  std::array<Vec3d, kNodes> nodes;
  std::copy_n(x.begin(), kNodes, nodes.begin());
  return nodes;
}

}  // namespace

void append_gauss_points(std::span<const Vec3d> x, std::vector<double>& gradient,
                         std::vector<double>& volume) {
  TURGOR_ASSERT(x.size() == 4 || x.size() == 8 || x.size() == 10, "an element has 4, 8 or 10 nodes");
  if (x.size() == 8) return append_points(hex_points(first_nodes<8>(x)), gradient, volume);
  if (x.size() == 10) return append_points(quadratic_points(first_nodes<10>(x)), gradient, volume);
  const std::array<Vec3d, 4> g = volume_gradients(first_nodes<4>(x));
  const double whole = orientation(x[0], x[1], x[2], x[3]) / 6;
  for (const Vec3d& slope : g)
    for (int axis = 0; axis < 3; axis++) gradient.push_back(slope[axis] / whole);
  volume.push_back(whole);
}

std::array<double, 10> quadratic_weights(const std::array<double, 4>& linear) {
  std::array<double, 10> weights;
  for (std::size_t c = 0; c < 4; c++) weights[c] = linear[c] * (2 * linear[c] - 1);
  for (std::size_t e = 0; e < kTetEdges.size(); e++)
    weights[4 + e] = 4 * linear[std::size_t(kTetEdges[e][0])] * linear[std::size_t(kTetEdges[e][1])];
  return weights;
}

Lists element_lists(const SolidMesh& mesh) {
  Lists lists{{}, mesh.elements};
  for (std::size_t i = 0; i <= mesh.elements.size(); i += std::size_t(mesh.corners)) lists.begin.push_back(i);
  return lists;
}

std::vector<int> element_materials(const Body& body) {
  const std::size_t count = element_count(body.mesh);
  std::vector<int> material = body.material;
  material.resize(count, 0);
  for (std::size_t e = 0; e < count; e++)
    for (const Inclusion& inclusion : body.inclusions)
      if (norm(centroid(body.mesh, e) - inclusion.center) <= inclusion.radius)
        material[e] = inclusion.material;
  return material;
}

NodalVolumes nodal_volumes(const SolidMesh& mesh, std::span<const int> material) {
  const Lists around = holders(element_lists(mesh), mesh.vertices.size());
  NodalVolumes result;
  std::vector<VolumeShare> shares;
  for (std::size_t v = 0; v < around.count(); v++) {
    // contributions around the vertex, by material and vertex
    shares.clear();
    for (const int e : around[v]) add_shares(mesh, std::size_t(e), material[std::size_t(e)], shares);
    std::stable_sort(shares.begin(), shares.end());
    // one volume a material, one gradient a vertex
    for (std::size_t i = 0; i < shares.size(); i++) {
      const bool new_material = i == 0 || shares[i].material != shares[i - 1].material;
      if (new_material) {
        result.material.push_back(shares[i].material);
        result.center.push_back(int(v));
        result.volume.push_back(0);
        result.vertices.begin.push_back(result.vertices.begin.back());
      }
      if (new_material || shares[i].vertex != shares[i - 1].vertex) {
        result.vertices.item.push_back(shares[i].vertex);
        result.vertices.begin.back()++;
        result.gradient.push_back({});
      }
      result.volume.back() += shares[i].volume;
      result.gradient.back() += shares[i].gradient;
    }
  }
  TURGOR_CHECK(std::all_of(result.volume.begin(), result.volume.end(), [](double v) { return v > 0; }),
               "nodal volumes are not empty");
  TURGOR_CHECK(is_csr(result.vertices.begin, result.vertices.item.size()),
               "the nodal volumes cover all their vertices");
  return result;
}

}  // namespace turgor::sfem
