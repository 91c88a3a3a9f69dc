#include "app/validate_cloth_sheet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/build/sheet.hpp"
#include "turgor/models/cloth/cloth.hpp"
#include "turgor/models/cloth/measure.hpp"

namespace turgor {

namespace {

using cloth::Model;
using cloth::Params;
using cloth::State;

constexpr double kFrame = 1.0 / 60, kGravity = 9.81;

/// A triangulation of a rectangle.
struct Cells {
  const char* name;
  double long_by;  // aspect ratio: length along the strip over width across it
  bool is_random;  // vertices displaced by up to 0.3 of a cell, random diagonals
};
constexpr Cells kCells[] = {{"squares", 1, false},
                            {"cells 4 times as long", 4, false},
                            {"cells 4 times as wide", 0.25, false},
                            {"random triangles", 1, true}};

/// Area of a triangle in the plane z = 0, negative if it is inverted [m²].
double signed_area(const TriMesh& mesh, Int3 t) {
  const auto [a, b, c] = t;
  const auto at = [&mesh](int v) { return Vec3d(mesh.vertices[std::size_t(v)]); };
  return cross(at(b) - at(a), at(c) - at(a)).z / 2;
}

/// Two triangles of a quadrilateral.
using Halves = std::array<Int3, 2>;

/// Replaces the diagonal of each quadrilateral whose smaller triangle is inverted or has less than a tenth of
/// its area, if the other diagonal is better. Triangles 2 n and 2 n + 1 are a quadrilateral: a, b, c and a,
/// c, d, or a, b, d and b, c, d.
void mend_diagonals(TriMesh& mesh) {
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 2) {
    const Halves halves{mesh.triangles[t], mesh.triangles[t + 1]};
    const bool from_a = halves[0].z == halves[1].y;
    const int a = halves[0].x, b = halves[0].y, c = halves[1].y, d = from_a ? halves[1].z : halves[0].z;
    const Halves others = from_a ? Halves{{{a, b, d}, {b, c, d}}} : Halves{{{a, b, c}, {a, c, d}}};
    const auto smaller = [&mesh](const Halves& h) {
      return std::min(signed_area(mesh, h[0]), signed_area(mesh, h[1]));
    };
    const double all = signed_area(mesh, halves[0]) + signed_area(mesh, halves[1]);
    if (smaller(halves) < 0.1 * all && smaller(others) > smaller(halves))
      mesh.triangles[t] = others[0], mesh.triangles[t + 1] = others[1];
  }
}

/// A strip from x0 to x1, with two straight columns of vertices at x0.
TriMesh strip(const Cells& cells, double x0, double x1, double width, double size) {
  const double long_cell = size * std::min(cells.long_by, 1.0),
               wide_cell = size / std::max(cells.long_by, 1.0);
  const int columns = int(std::lround((x1 - x0) / long_cell)), rows = int(std::lround(width / wide_cell));
  TriMesh mesh = cloth::make_sheet(
      {.corner = {x0, 0, 0}, .side = {x1 - x0, 0, 0}, .up = {0, width, 0}, .columns = columns, .rows = rows});
  if (!cells.is_random) return mesh;
  std::uint64_t bits = 11;
  const auto next = [&bits] {
    bits = bits * 6364136223846793005ull + 1442695040888963407ull;
    return double(bits >> 40) / double(1 << 23) - 1;
  };
  for (int r = 1; r < rows; r++)
    for (int c = 2; c < columns; c++) {
      const double along = next(), up = next();
      mesh.vertices[std::size_t(r * (columns + 1) + c)] +=
          Vec3(Vec3d{along * long_cell, up * wide_cell, 0} * 0.3);
    }
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 2) {  // a, b, c and a, c, d: or with b, d
    const auto [a, b, c] = mesh.triangles[t];
    const int d = mesh.triangles[t + 1].z;
    if (next() > 0) mesh.triangles[t] = {a, b, d}, mesh.triangles[t + 1] = {b, c, d};
  }
  mend_diagonals(mesh);
  return mesh;
}

struct Clamped {
  Model model;
  State state;
};
/// A strip in vacuum, held at x < `held`. Returns the vertices with x > `from` in `end`.
Clamped clamp(const Exec& exec, const TriMesh& mesh, const Params& params, double held, double from,
              std::vector<int>& end) {
  Clamped strip{.model = cloth::build(exec, mesh, params).value(), .state = {}};
  strip.state = cloth::make_state(strip.model);
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) {
    if (double(mesh.vertices[v].x) < held) (void)hold(strip.model, strip.state, int(v));
    if (double(mesh.vertices[v].x) > from) end.push_back(int(v));
  }
  return strip;
}

/// Force per width and strain of a strip of 100 × 40 mm stretched by 2 %, relative to the stiffness of its
/// fabric.
double pulled(const Exec& exec, const Cells& cells, bool along_weft, double size) {
  Params params = sheet_params({.warp = 1000, .weft = 400, .shear = 60});
  if (along_weft) params.fabric.direction = {0, 1, 0};
  params.damping.motion = 10;
  params.collision.self = false;
  const TriMesh mesh = strip(cells, 0, 0.1, 0.04, size);
  std::vector<int> end;
  auto [model, state] = clamp(exec, mesh, params, 1e-6, 0.1 - 1e-6, end);
  for (const int v : end) {
    Vec3 goal = mesh.vertices[std::size_t(v)];
    goal.x += 0.002f;
    (void)hold(model, state, v);
    (void)move_hold(model, state, v, goal);
  }
  cloth::Inputs inputs;
  inputs.air.density = 0;
  for (int n = 0; n < 60; n++) cloth::step(exec, model, state, inputs, kFrame);
  double force = 0;
  for (const int v : end) force += cloth::hold_force(model, state, v, {}, {}, kFrame).x;
  return force / (0.04 * 0.02 * (along_weft ? 400 : 1000));
}

/// End deflection of a heavy elastica, by shooting with the Runge–Kutta method [m].
double elastica_drop(double length, double c3) {
  constexpr int kSteps = 1000;
  const double h = length / kSteps;
  struct Point {
    double angle, bend, drop;
  };
  const auto slope = [&](double s, Point p) {
    return Point{p.bend, -(length - s) / c3 * std::cos(p.angle), std::sin(p.angle)};
  };
  const auto moved = [](Point p, Point d, double by) {
    return Point{p.angle + by * d.angle, p.bend + by * d.bend, p.drop + by * d.drop};
  };
  const auto shot = [&](double bend) {
    Point p{0, bend, 0};
    for (int n = 0; n < kSteps; n++) {
      const double s = n * h;
      const Point a = slope(s, p), b = slope(s + h / 2, moved(p, a, h / 2)),
                  c = slope(s + h / 2, moved(p, b, h / 2)), d = slope(s + h, moved(p, c, h));
      p = moved(moved(moved(moved(p, a, h / 6), b, h / 3), c, h / 3), d, h / 6);
    }
    return p;
  };
  double low = 0, high = length * length / c3;
  for (int n = 0; n < 60; n++) (shot((low + high) / 2).bend < 0 ? low : high) = (low + high) / 2;
  return shot((low + high) / 2).drop;
}

/// End deflection of a strip clamped between its first two columns, relative to the elastica.
double hanging(const Exec& exec, const Cells& cells, double c, double size) {
  constexpr double kDensity = 0.2, kLength = 0.06;
  Params params = sheet_params({.density = kDensity, .warp = 2000, .weft = 2000, .shear = 400});
  params.fabric.rigidity_warp = kDensity * kGravity * c * c * c;
  params.fabric.rigidity_weft = 4 * params.fabric.rigidity_warp;
  params.damping = {10, 0};
  params.solver.tolerance = 1e-3;
  params.collision.self = false;
  const double cell = size * std::min(cells.long_by, 1.0);
  const TriMesh mesh = strip(cells, -cell / 2, kLength, 0.02, size);
  std::vector<int> end;
  auto [model, state] = clamp(exec, mesh, params, 0.6 * cell, kLength - 1e-6, end);
  cloth::Inputs inputs{.gravity = {0, 0, -kGravity}};
  inputs.air.density = 0;
  for (int n = 0; n < 240; n++) cloth::step(exec, model, state, inputs, kFrame);
  double drop = 0;
  for (const int v : end)
    drop -= double(state.x.z[std::size_t(model.model_vertex[std::size_t(v)])]) / double(end.size());
  return drop / elastica_drop(kLength, c * c * c);
}

constexpr double kTable = 0.09, kRim = 0.15, kPi = 3.14159265358979;  // radii of Cusick's drapemeter [m]

/// Radius of the last held vertices. A clamp acts half a cell inside them, since the area of such a vertex
/// reaches half a cell into the held sheet.
double held_radius(double size) { return kTable + size / 2; }

/// A disc of 30 cm on a table of 18 cm (Cusick's drapemeter), mapped from a square. Vertices near the circle
/// of the last held ones are moved onto it, before those of random triangles are displaced: the clamp would
/// else end between vertices, up to a cell from there.
TriMesh disc(const Cells& cells, double size) {
  const double held = held_radius(size);
  const TriMesh squares = strip(kCells[0], -1, 1, 2, size / kRim);
  TriMesh mesh = strip(cells, -1, 1, 2, size / kRim);
  const auto on_disc = [](Vec3 x) {
    const double a = double(x.x), b = double(x.y) - 1;
    return Vec3d{a * std::sqrt(1 - b * b / 2), b * std::sqrt(1 - a * a / 2), 0} * kRim;
  };
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) {
    const Vec3d x = on_disc(squares.vertices[v]);
    const bool is_last = std::abs(norm(x) - held) < 0.45 * size;
    mesh.vertices[v] = Vec3(is_last ? x * (held / norm(x)) : on_disc(mesh.vertices[v]));
  }
  mend_diagonals(mesh);
  return mesh;
}

/// Area of the projection along z, rasterized at 1 mm [m²].
double shadow(const TriMesh& mesh) {
  constexpr int kSide = 360;
  constexpr double kPixel = 1e-3;
  std::vector<bool> dark(std::size_t(kSide * kSide), false);
  const auto pixel = [&mesh](int v) {
    return Vec3d(mesh.vertices[std::size_t(v)]) / kPixel + Vec3d{1, 1, 0} * (kSide / 2.0);
  };
  for (const Int3 t : mesh.triangles) {
    const Vec3d a = pixel(t.x), p = pixel(t.y) - a, q = pixel(t.z) - a, low = min(a, min(a + p, a + q)),
                high = max(a, max(a + p, a + q));
    const double area = p.x * q.y - p.y * q.x;
    for (int y = std::max(0, int(low.y)); y <= std::min(kSide - 1, int(high.y)); y++)
      for (int x = std::max(0, int(low.x)); x <= std::min(kSide - 1, int(high.x)); x++) {
        const double dx = x + 0.5 - a.x, dy = y + 0.5 - a.y;
        const double u = (dx * q.y - dy * q.x) / area, w = (p.x * dy - p.y * dx) / area;
        if (u >= 0 && w >= 0 && u + w <= 1) dark[std::size_t(y * kSide + x)] = true;
      }
  }
  return kPixel * kPixel * double(std::count(dark.begin(), dark.end(), true));
}

/// Initial height of a throw at a position: waves of two to eight folds of 1 mm together at the rim, the same
/// on all meshes. [m]
double thrown_height(Vec3 x, int throw_number) {
  constexpr double kHeight = 1e-3;
  constexpr int kFewest = 2, kMost = 8;
  const double angle = std::atan2(double(x.y), double(x.x)), radius = std::hypot(double(x.x), double(x.y));
  double sum = 0;
  for (int folds = kFewest; folds <= kMost; folds++)
    sum += std::sin(folds * angle + 2.4 * throw_number * folds * folds);
  return kHeight * sum / std::sqrt(double(kMost - kFewest + 1)) * (radius - kTable) / (kRim - kTable);
}

/// Covered fraction of the ring beyond the table. Vertices up to `held` from the middle are held.
double drape_coefficient(const Exec& exec, const TriMesh& mesh, double held, int throw_number) {
  Params params = sheet_params({.density = 0.15, .shear = 50});
  params.damping.motion = 2;
  params.collision.self = false;
  Model model = cloth::build(exec, mesh, params).value();
  State state = cloth::make_state(model);
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) {
    const Vec3 x = mesh.vertices[v];
    if (std::hypot(double(x.x), double(x.y)) <= held * (1 + 1e-5))
      (void)hold(model, state, int(v));
    else
      state.x.z[std::size_t(model.model_vertex[v])] += Real(thrown_height(x, throw_number));
  }
  cloth::Inputs inputs{.gravity = {0, 0, -kGravity}};
  inputs.air.density = 0;
  for (int n = 0; n < 240; n++) cloth::step(exec, model, state, inputs, kFrame);
  const double table = kPi * kTable * kTable, ring = kPi * kRim * kRim - table;
  return (shadow(cloth::model_surface(model, state)) - table) / ring;
}

/// Mean over six throws, as in the measurement of fabrics: the number of folds is chance.
double mean_drape_coefficient(const Exec& exec, const Cells& cells, double size) {
  constexpr int kThrows = 6;
  const TriMesh mesh = disc(cells, size);
  double sum = 0;
  for (int n = 1; n <= kThrows; n++) sum += drape_coefficient(exec, mesh, held_radius(size), n);
  return sum / kThrows;
}

std::string millimeters(double size) { return std::to_string(int(std::lround(1000 * size))) + " mm"; }

/// Drape coefficients of squares and of random triangles of 10 and 6 mm, to those of 4 mm and to each other.
void add_drape_figures(const Exec& exec, std::vector<Figure>& figures) {
  const Cells &squares = kCells[0], &random = kCells[3];
  const double fine =
      (mean_drape_coefficient(exec, squares, 0.004) + mean_drape_coefficient(exec, random, 0.004)) / 2;
  const std::string name = "drape coefficient (Cusick's disc, mean of six throws), ";
  double least = 1, most = 0;
  for (const double size : {0.01, 0.006})
    for (const Cells* cells : {&squares, &random}) {
      const double found = mean_drape_coefficient(exec, *cells, size);
      least = narrowest(least, found), most = widest(most, found);
      figures.push_back(near_figure(name + cells->name + " of " + millimeters(size),
                                    "squares and random triangles of 4 mm", found, fine, 0.05));
    }
  figures.push_back(near_figure(name + "largest of these four", "the least of them", most, least, 0.05));
}

}  // namespace

void add_sheet_figures(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  for (const Cells& cells : kCells) {
    for (const double size : {0.02, 0.01, 0.005})
      for (const bool along_weft : {false, true})
        if (!quick || size == 0.01)
          figures.push_back(near_figure(std::string("strip pulled along its ") +
                                            (along_weft ? "weft" : "warp") + ", " + cells.name + " of " +
                                            millimeters(size) + ": stiffness",
                                        "fabric", pulled(exec, cells, along_weft, size), 1, 0.02));
    for (const double c : {0.015, 0.02})
      figures.push_back(near_figure(std::string("strip over an edge, c = ") + millimeters(c) + ", " +
                                        cells.name + " of 4 mm: end deflection",
                                    "heavy elastica (Peirce)", hanging(exec, cells, c, 0.06 / 14.5), 1,
                                    0.05));
  }
  if (quick) return;
  add_drape_figures(exec, figures);
}

}  // namespace turgor
