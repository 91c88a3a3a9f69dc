// Contact between two elastic bodies, compared with Hertz.
#include "turgor/contact/pair_sites.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include <gtest/gtest.h>

#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor::contact {
namespace {

constexpr double kCell = 1e-3;  // in the middle of a block [m]

/// Planes from -far to far: equal cells up to `inner`, growing ones beyond.
std::vector<double> graded_planes(double inner, double far) {
  std::vector<double> half{0};
  while (half.back() < inner - 1e-9) half.push_back(half.back() + kCell);
  for (double step = kCell; half.back() < far;) half.push_back(half.back() + (step *= 3));
  std::vector<double> all;
  for (std::size_t i = half.size(); i-- > 1;) all.push_back(-half[i]);
  all.insert(all.end(), half.begin(), half.end());
  return all;
}

/// A wide block whose top is a paraboloid with this radius of curvature around the origin; `up` = -1 hangs it
/// upside down. The mesh is shifted sideways, so that nodes of two blocks do not meet.
sfem::Model domed_block(double radius, double up, Vec3d shift, sfem::Material material) {
  const std::vector<double> across = graded_planes(7e-3, 250e-3);
  const std::vector<double> down(across.begin(), across.begin() + std::ptrdiff_t(across.size() / 2 + 1));
  sfem::Body body{.mesh = hex_block(across, across, down), .materials = {material}};
  for (Vec3d& x : body.mesh.vertices) {
    const double far = across.back() - 1e-6;
    body.fixed.push_back(std::abs(x.x) > far || std::abs(x.y) > far || x.z < -far);
    x += shift;
    const double r2 = std::min(x.x * x.x + x.y * x.y, 20e-3 * 20e-3);
    x = {x.x, x.y * up, up * (x.z - r2 / (2 * radius))};  // a half turn about x
  }
  sfem::Model model =
      sfem::build(Exec(2), std::move(body), {sfem::Formulation::kAveraged, sfem::Precision::kDouble, 0})
          .value();
  EXPECT_TRUE(sfem::prepare_columns(Exec(2), model));
  return model;
}

/// Computes the columns of Green's functions near the origin.
void fetch_near(sfem::Model& model) {
  std::vector<int> near;
  for (const Int3 t : model.surface.triangles)
    for (const int v : {t.x, t.y, t.z}) {
      const Vec3d x = model.body.mesh.vertices[std::size_t(v)];
      if (norm(x) < 12e-3) near.push_back(v);
    }
  sort_unique(near);
  sfem::fetch_columns(Exec(2), model, near);
}

// Two domes of different curvature and stiffness, pressed together by several depths: the force is that of
// Hertz within 3 %, both bodies feel the same force, and no vertex is inside the other body.
TEST(PairSites, TwoDomes_HertzWithinThreePercent) {
  constexpr double kRadius[2] = {0.15, 0.3};
  constexpr sfem::Material kMaterial[2] = {{1e5, 0.3}, {2.5e5, 0.4}};
  std::array<sfem::Model, 2> model{domed_block(kRadius[0], 1, {0.4e-3, -0.3e-3, 0}, kMaterial[0]),
                                   domed_block(kRadius[1], -1, {}, kMaterial[1])};
  for (sfem::Model& m : model) fetch_near(m);
  double soft = 0, curved = 0;
  for (int b = 0; b < 2; b++) {
    soft += (1 - kMaterial[b].poisson * kMaterial[b].poisson) / kMaterial[b].young;
    curved += 1 / kRadius[b];
  }

  double worst = 0;
  for (const double radius : {2.5e-3, 3e-3, 3.5e-3}) {
    const double depth = radius * radius * curved;
    const double hertz = 4.0 / 3 / soft / std::sqrt(curved) * std::pow(depth, 1.5);
    // the upper block is moved down as a whole
    std::vector<CoupledBody> bodies;
    std::array<std::vector<Vec3d>, 2> x;
    for (std::size_t b = 0; b < 2; b++) {
      const Vec3d moved{0, 0, b == 1 ? -depth : 0};
      bodies.push_back({&model[b], 1, std::vector<Vec3d>(model[b].body.mesh.vertices.size(), moved)});
      x[b] = model[b].body.mesh.vertices;
      for (Vec3d& p : x[b]) p += moved;
    }
    // sites are found again where the surfaces come to lie
    PairSites found;
    for (int round = 0; round < 2; round++) {
      std::array<PairSurface, 2> surfaces;
      for (std::size_t b = 0; b < 2; b++)
        surfaces[b] = {int(b), model[b].body.mesh.vertices, x[b], model[b].surface.triangles, {}};
      found =
          find_pair_sites(Exec(1), surfaces,
                          {.reach = 0.08e-3, .deepest = 2e-3, .friction = 0, .capacity = 400}, found.sites);
      ASSERT_EQ(found.dropped, 0);
      const CouplingReport report = solve_coupling(Exec(2), bodies, {}, found.sites);
      EXPECT_TRUE(report.converged);
      // move the vertices near the contact by the new forces
      for (int b = 0; b < 2; b++) {
        const std::vector<VertexForce> forces = forces_on(b, {}, found.sites);
        std::vector<double> u(3 * model[std::size_t(b)].vertex.size());
        const sfem::Model& m = model[std::size_t(b)];
        for (const auto& [v, f] : forces)
          for (int axis = 0; axis < 3; axis++)
            u[3 * std::size_t(m.free_node[std::size_t(v)]) + std::size_t(axis)] += f[axis];
        sfem::solve(*m.factor, u);
        for (std::size_t row = 0; row < m.vertex.size(); row++) {
          const auto v = std::size_t(m.vertex[row]);
          x[std::size_t(b)][v] = m.body.mesh.vertices[v] + bodies[std::size_t(b)].free[v] +
                                 Vec3d{u[3 * row], u[3 * row + 1], u[3 * row + 2]};
        }
      }
    }
    // forces
    std::array<Vec3d, 2> on;
    for (int b = 0; b < 2; b++)
      for (const auto& [v, f] : forces_on(b, {}, found.sites)) on[std::size_t(b)] += f;
    EXPECT_LT(norm(on[0] + on[1]), 1e-12 * norm(on[0]));
    worst = std::max(worst, std::abs(on[1].z / hertz - 1));
    std::printf("contact radius %.1f mm: %.5f N, Hertz %.5f N, %zu sites\n", radius * 1e3, on[1].z, hertz,
                found.sites.size());
    // overlap that remains
    std::array<PairSurface, 2> surfaces;
    for (std::size_t b = 0; b < 2; b++)
      surfaces[b] = {int(b), model[b].body.mesh.vertices, x[b], model[b].surface.triangles, {}};
    const PairSites left =
        find_pair_sites(Exec(1), surfaces, {.reach = 0, .deepest = 2e-3, .capacity = 400}, found.sites);
    EXPECT_LT(left.deepest, 0.02 * depth);
  }
  EXPECT_LT(worst, 0.03);
}

/// A bumpy sheet of triangles, with its front up or down.
struct Sheet {
  std::vector<Vec3d> x;
  std::vector<Int3> triangles;

  Sheet(int cells, double size, double phase, bool is_upper) {
    for (int j = 0; j <= cells; j++)
      for (int i = 0; i <= cells; i++) {
        const double u = size * (double(i) / cells - 0.5), v = size * (double(j) / cells - 0.5);
        x.push_back({u, 2e-4 * std::sin(300 * u + phase) * std::cos(200 * v), v});
      }
    for (int j = 0; j < cells; j++)
      for (int i = 0; i < cells; i++) {
        const int v = j * (cells + 1) + i;
        for (Int3 t : {Int3{v, v + cells + 1, v + 1}, Int3{v + 1, v + cells + 1, v + cells + 2}}) {
          if (is_upper) std::swap(t.y, t.z);
          triangles.push_back(t);
        }
      }
  }
  PairSurface surface(int body) const { return {body, x, x, triangles, {}}; }
};

/// Shortest edge of the triangles around a vertex [m].
double shortest_edge_at(const Sheet& sheet, int vertex) {
  double shortest = 1;
  for (const Int3 t : sheet.triangles) {
    if (t.x != vertex && t.y != vertex && t.z != vertex) continue;
    const Vec3d a = sheet.x[std::size_t(t.x)], b = sheet.x[std::size_t(t.y)], c = sheet.x[std::size_t(t.z)];
    shortest = std::min({shortest, norm(b - a), norm(c - b), norm(a - c)});
  }
  return shortest;
}

// Vertices of the second surface have a site exactly if they are not near a vertex of the first one that has
// a site: within 0.3 of the shortest edge around both.
TEST(PairSites, NearVertices_HaveOneSite) {
  const Sheet low(20, 0.04, 0, false), high(23, 0.04, 0.4, true);
  const PairParams params{.reach = 5e-4, .deepest = 2e-3, .capacity = 10000};
  // alone, each direction has all its sites
  const auto sites_of = [&](const Sheet& a, int body_a, const Sheet& b, int body_b) {
    return find_pair_sites(Exec(1), {a.surface(body_a), b.surface(body_b)}, params, {}).sites;
  };
  const auto from = [](const std::vector<PairSite>& sites, int body) {
    std::vector<PairSite> of;
    std::copy_if(sites.begin(), sites.end(), std::back_inserter(of),
                 [body](const PairSite& s) { return s.a.body == body && s.a.vertex.y < 0; });
    return of;
  };
  const std::vector<PairSite> both = sites_of(low, 0, high, 1), reversed = sites_of(high, 1, low, 0);
  const std::vector<PairSite> first = from(both, 0), second = from(both, 1), all_second = from(reversed, 1);
  ASSERT_GT(first.size(), 100U);
  // expected sites
  const double mean = std::min(mean_edge(low.x, low.triangles), mean_edge(high.x, high.triangles));
  std::vector<int> expected;
  for (const PairSite& site : all_second) {
    Vec3d on;
    for (int c = 0; c < 3; c++) on += low.x[std::size_t(site.b.vertex[c])] * site.b.weight[c];
    bool is_double = false;
    for (const PairSite& other : first) {
      const double edge =
          std::min({mean, shortest_edge_at(low, other.a.vertex.x), shortest_edge_at(high, site.a.vertex.x)});
      is_double |= norm(low.x[std::size_t(other.a.vertex.x)] - on) < 0.3 * edge;
    }
    if (!is_double) expected.push_back(site.a.vertex.x);
  }
  EXPECT_LT(expected.size(), all_second.size());
  std::vector<int> found;
  for (const PairSite& site : second) found.push_back(site.a.vertex.x);
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace turgor::contact
