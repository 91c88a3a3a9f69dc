#include "turgor/sim/report/plausibility.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/triangle_point.hpp"
#include "turgor/models/sfem/elements.hpp"
#include "turgor/models/sfem/surface_strain.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr double kLargestBody = 2, kSmallestBody = 1e-3;  // largest extent [m]
constexpr double kMostStretch = 1.5;                      // woven fabric tears earlier

std::string meters(double length) {
  return length >= 1 ? fmt::format("{:.3g} m", length) : fmt::format("{:.3g} mm", 1e3 * length);
}

double across(const Box& box) {
  const Vec3d size = box.high - box.low;
  return std::max({size.x, size.y, size.z});
}

/// Moduli of the elements below a body's surface, with the present factor of its stiffness.
struct SurfaceModuli {
  explicit SurfaceModuli(const SfemBody& body)
      : model(body.model),
        material(sfem::element_materials(body.model.body)),
        scale(body.now.stiffness_scale) {}

  double of_triangle(std::size_t t) const {
    const int element = model.surface.element[t];
    return scale * model.body.materials[std::size_t(material[std::size_t(element)])].young;
  }
  double least() const {
    double young = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < model.surface.triangles.size(); t++) young = std::min(young, of_triangle(t));
    return young;
  }
  /// Modulus behind the triangle nearest to a position at rest; of several at the same distance, the largest.
  double at(Vec3d x) const {
    constexpr double kSame = 1e-9;  // [m]
    const std::vector<Vec3d>& vertices = model.body.mesh.vertices;
    double nearest = std::numeric_limits<double>::infinity(), young = 0;
    for (std::size_t t = 0; t < model.surface.triangles.size(); t++) {
      const Int3 corners = model.surface.triangles[t];
      const Vec3d a = vertices[std::size_t(corners.x)], b = vertices[std::size_t(corners.y)],
                  c = vertices[std::size_t(corners.z)];
      const Vec3d w = closest_weights(x, a, b, c);
      const double distance = norm(a * w.x + b * w.y + c * w.z - x);
      if (distance > nearest + kSame) continue;
      young = distance < nearest - kSame ? of_triangle(t) : std::max(young, of_triangle(t));
      nearest = std::min(nearest, distance);
    }
    return young;
  }

  const sfem::Model& model;
  std::vector<int> material;  // of each element
  double scale;
};

/// Pressed vertex with the largest pressure relative to the modulus below it.
struct Overpressed {
  double pressure = 0, young = 0;  // [Pa]
};
Overpressed find_overpressed(const SfemBody& body, const BodySnapshot& pressed) {
  TURGOR_CHECK(pressed.pressure.size() == pressed.rest.size(), "every vertex has a pressure");
  const SurfaceModuli moduli(body);
  const double least = moduli.least();
  Overpressed most{.pressure = 0, .young = 1};
  for (std::size_t v = 0; v < pressed.rest.size(); v++) {
    // skip pressures that cannot be the largest, whatever is below them
    const auto pressure = double(pressed.pressure[v]);
    if (!(pressure > least && pressure * most.young > most.pressure * least)) continue;
    const double young = moduli.at(Vec3d(pressed.rest[v]));
    if (pressure * most.young > most.pressure * young) most = {pressure, young};
  }
  return most;
}

}  // namespace

std::vector<std::string> odd_sizes(const WorldSnapshot& snapshot) {
  std::vector<std::string> sentences;
  double largest = 0;  // diagonal of a box, as the size of tools [m]
  for (const BodySnapshot& body : snapshot.bodies) {
    if (body.rest.empty()) continue;

    // bodies
    const double size = across(body.box);
    largest = std::max(largest, norm(body.box.high - body.box.low));
    if (size > kLargestBody)
      sentences.push_back(
          fmt::format("{}: its size is {}, larger than the plausible {}: if its file is in "
                      "millimeters, set scale = 0.001",
                      body.name, meters(size), meters(kLargestBody)));
    if (size < kSmallestBody)
      sentences.push_back(
          fmt::format("{}: its size is {}, smaller than the plausible {}: if its file is in meters "
                      "already, remove scale",
                      body.name, meters(size), meters(kSmallestBody)));
  }

  // tools
  constexpr double kNeedle = 10;  // a needle may be longer than its body
  for (const ToolSnapshot& tool : snapshot.tools)
    if (tool.size > (tool.is_needle ? kNeedle : 1) * largest)
      sentences.push_back(
          fmt::format("{}: its contacting end has a size of {}, larger than the largest body ({}): are "
                      "its lengths in millimeters? Scenes use meters",
                      tool.name, meters(tool.size), meters(largest)));
  return sentences;
}

void record_stretch(const WorldSnapshot& snapshot, std::vector<ClothStretch>& seen) {
  for (const BodySnapshot& body : snapshot.bodies) {
    if (body.look != Look::kCloth) continue;
    // record of this body, created at its first snapshot
    auto at =
        std::find_if(seen.begin(), seen.end(), [&](const ClothStretch& s) { return s.body == body.name; });
    if (at == seen.end()) at = seen.insert(seen.end(), {body.name, 1, 0});
    // largest ratio of edge length to rest length
    TURGOR_CHECK(body.x.size() == body.rest.size(), "every vertex has a rest position");
    for (const Int3 t : body.triangles)
      for (int corner = 0; corner < 3; corner++) {
        const auto a = std::size_t(t[corner]), b = std::size_t(t[(corner + 1) % 3]);
        const double stretch =
            double(norm(body.x[b] - body.x[a])) / double(norm(body.rest[b] - body.rest[a]));
        if (stretch > at->most) at->most = stretch, at->time = snapshot.time;
      }
  }
}

std::vector<std::string> overstretched(const std::vector<ClothStretch>& seen) {
  std::vector<std::string> sentences;
  for (const ClothStretch& s : seen)
    if (s.most > kMostStretch)
      sentences.push_back(fmt::format(
          "{}: its longest edge was stretched to {:.3g} times its rest length (at {:.2f} s); fabric "
          "does not stretch beyond {}: a larger stiffness, more sweeps or a higher frame "
          "rate limit the stretch",
          s.body, s.most, s.time, kMostStretch));
  return sentences;
}

std::vector<std::string> overpressed(const World& world, const std::vector<Pressed>& pressed) {
  std::vector<std::string> sentences;
  for (const Pressed& one : pressed) {
    if (one.body.id.kind != BodyKind::kSfem || one.body.pressure.empty()) continue;

    TURGOR_CHECK(is_index(one.body.id.index, world.sfem_bodies.size()),
                 "a pressed organ is a body of the world");
    const SfemBody& body = world.sfem_bodies[std::size_t(one.body.id.index)];
    if (body.law) continue;
    const auto [most, young] = find_overpressed(body, one.body);
    if (most > young)
      sentences.push_back(
          fmt::format("{}: the contact pressure was {:.3g} kPa at {:.2f} s, above Young's modulus "
                      "({:.3g} kPa): the linear law does not stiffen, and this force is too "
                      "small; a smaller depth stays within the law",
                      one.body.name, 1e-3 * most, one.time, 1e-3 * young));
  }
  return sentences;
}

/// Advice for a linear body that is strained too much.
std::string less_strain(const SfemBody& body) {
  const std::string advice = body.tool_indices.empty()
                                 ? "a smaller load, or a stiffer body"
                                 : "law = \"neo_hookean\" or \"exponential\", or a smaller depth";
  if (!body.flight) return advice;
  return advice + "; a body with fixed = \"none\" also swells where it turns, by 10 % at 26 degrees";
}

std::vector<std::string> overstrained(const World& world) {
  constexpr double kBorderStrain = 0.1, kMostUnconverged = 0.2;
  std::vector<std::string> sentences;
  for (const SfemBody& body : world.sfem_bodies) {
    const LawSummary& law = body.law_summary;
    if (!body.law && body.surface_strain > sfem::kLinearStrain)
      sentences.push_back(
          fmt::format("{}: its surface was strained by {:.0f} %; beyond {:.0f} % the force of a linear body "
                      "is off by more "
                      "than about 5 %: {}",
                      body.name, 100 * body.surface_strain, 100 * sfem::kLinearStrain, less_strain(body)));
    if (body.law && law.border_strain > kBorderStrain)
      sentences.push_back(fmt::format(
          "{}: beside the border of the nonlinear patch, tissue was strained by {:.0f} %, where the body is "
          "linear: a larger patch.radius",
          body.name, 100 * law.border_strain));
    if (body.law && law.unconverged > kMostUnconverged * law.solutions)
      sentences.push_back(fmt::format(
          "{}: {} of {} solutions of its law were not converged when they were used: a slower tool, or a "
          "smaller depth",
          body.name, law.unconverged, law.solutions));
  }
  return sentences;
}

}  // namespace turgor
