#include "turgor/sim/bodies/sfem/choose_patch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/sfem/expected_error.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"
#include "turgor/sim/tools/press_path.hpp"

namespace turgor {

namespace {

constexpr double kUsualRadius = 0.02;  // of a patch [m]
constexpr int kUsualRefinement = 2, kMostRefinement = 4;
constexpr double kErrorGoal = 0.04;     // expected force error, below the promised 5 %
constexpr double kUsualElements = 800;  // fine elements of a patch that is built in about a tenth of a second
constexpr double kMostElements = 4000;  // fine elements of a patch that is built in seconds
constexpr double kLawElements = 400;    // fine elements of a nonlinear patch that is solved in 13 to 28 ms

/// Contact of one tool with the body.
struct ExpectedContact {
  double contact = 0;  // radius by Hertz [m]
  double reach = 0;    // of the touched surface around the tool's position [m]
};

/// Deepest position of a ball on its path below the surface at rest [m].
double deepest_of_path(const TouchingTool& tool, const RestSurface& surface, double radius) {
  constexpr std::size_t kMostRows = 64;
  const std::vector<PathRow>& rows = tool.path.rows;
  const std::size_t stride = std::max<std::size_t>(1, rows.size() / kMostRows);
  double deepest = 0;
  for (std::size_t i = 0; i < rows.size(); i += stride) {
    const SurfaceSample under = sample_surface(surface, rows[i].position, false, radius);
    deepest = std::max(deepest, radius - dot(rows[i].position - under.point, under.normal));
  }
  return deepest;
}

/// Contact radius by Hertz. A depth that no path gives is taken as half of the tool's radius.
ExpectedContact expected_contact(const TouchingTool& tool, const RestSurface& surface) {
  const contact::Shape& shape = tool.tool.shape;
  // depth of the path
  const double radius = contact::tip_radius(shape);
  double depth = 0, beside = 0;
  if (std::holds_alternative<contact::Sphere>(shape) && tool.hand.empty())
    depth = deepest_of_path(tool, surface, radius);
  if (!(depth > 0 && depth < 2 * radius)) depth = radius / 2;
  // extent of tools that are not balls
  if (const auto* rod = std::get_if<contact::Capsule>(&shape)) beside = rod->half_length;
  if (std::holds_alternative<contact::MeshShape>(shape)) beside = contact::bounding_radius(shape);
  const double contact = std::sqrt(radius * depth);
  return {contact, contact + beside};
}

/// A radius and a refinement under consideration.
struct Candidate {
  double radius = kUsualRadius;  // [m]
  int refinement = kUsualRefinement;
  double fine_elements = 0;  // fine elements
  double error = 0;          // expected, relative
};

/// All candidates that cover the contact, the cheapest first.
std::vector<Candidate> candidates_of(const SfemBody& body, double contact, double reach) {
  constexpr std::array kRadii{0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0, 1.25, 1.5, 2.0};  // relative
  const double least = std::min(kUsualRadius, reach / (1 - std::min(body.follow.hysteresis, 0.5)));
  std::vector<Candidate> candidates;
  for (const double factor : kRadii) {
    const double radius = body.radius_is_open ? factor * kUsualRadius : body.follow.radius;
    if (body.radius_is_open && (radius < least - 1e-12 || radius > body.model.params.touch_depth)) continue;
    const std::vector<int> elements = sfem::patch_elements(body.model, body.centers, radius);
    if (elements.empty()) continue;
    for (int r = 1; r <= kMostRefinement; r++) {
      if (!body.refinement_is_open && r != body.refinement) continue;
      Candidate candidate{radius, r, double(elements.size()) * r * r * r, 0};
      candidate.error =
          sfem::expected_error(sfem::touched_elements(body.model, elements, r, radius, contact));
      candidates.push_back(candidate);
    }
    if (!body.radius_is_open) break;
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.fine_elements < b.fine_elements; });
  return candidates;
}

bool is_usual(const SfemBody& body, const Candidate& c) {
  const int refinement = body.refinement_is_open ? kUsualRefinement : body.refinement;
  return (!body.radius_is_open || c.radius == kUsualRadius) && c.refinement == refinement;
}

void use(SfemBody& body, const Candidate& c) {
  body.follow.radius = c.radius, body.refinement = c.refinement;
}

bool fits(SfemBody& body, const Candidate& c) {
  use(body, c);
  return needs_of_patch(body, body.centers).bytes <= double(body.patch_memory);
}

/// Best candidate: the usual one if it is accurate and small, else the cheapest accurate one, else the most
/// accurate one that is built in seconds, else the smallest. None if no candidate fits into memory.
std::optional<Candidate> best_of(SfemBody& body, const std::vector<Candidate>& candidates) {
  // linear elements have locking errors that no patch removes: the usual patch
  const bool is_refined = body.refinement_is_open || body.refinement > 1;
  const bool by_error = body.model.body.mesh.corners == 10 && is_refined;
  const double most = body.law ? kLawElements : kMostElements;
  for (const Candidate& c : candidates)
    if (!body.law && is_usual(body, c) &&
        (!by_error || (c.error <= kErrorGoal && c.fine_elements <= kUsualElements)) && fits(body, c))
      return c;
  // cheapest accurate one
  for (const Candidate& c : candidates)
    if (by_error && c.error <= kErrorGoal && c.fine_elements <= most && fits(body, c)) return c;
  // most accurate one that fits
  std::vector<Candidate> by_accuracy = candidates;
  std::stable_sort(by_accuracy.begin(), by_accuracy.end(), [&](const Candidate& a, const Candidate& b) {
    return std::pair(a.fine_elements > most, a.error) < std::pair(b.fine_elements > most, b.error);
  });
  for (const Candidate& c : by_accuracy)
    if (fits(body, c)) return c;
  return {};
}

/// Sentence about a choice that differs from the usual one.
std::string note_of(const SfemBody& body, const Candidate& chosen, const Candidate& usual,
                    double usual_bytes) {
  const double bytes = needs_of_patch(body, body.centers).bytes;
  const std::string error = chosen.error > sfem::kForceUnknown
                                ? fmt::format("more than {:.0f} %", 100 * sfem::kForceUnknown)
                                : fmt::format("{:.1f} %", 100 * chosen.error);
  std::string note = fmt::format(
      "the patch was chosen: radius {:.3g} mm, refinement {}; expected force error {}, memory {:.3g} GB",
      1e3 * chosen.radius, chosen.refinement, error, bytes * 1e-9);
  if (usual_bytes > double(body.patch_memory))
    note += fmt::format("; a radius of {:.3g} mm would take {:.3g} GB, the limit is {:.3g} GB",
                        1e3 * usual.radius, usual_bytes * 1e-9, double(body.patch_memory) * 1e-9);
  return note;
}

}  // namespace

double usual_touch_depth(const SolidMesh& mesh) {
  constexpr double kEdges = 1.25, kMost = 2 * kUsualRadius;
  if (mesh.corners != 10) return kUsualRadius;
  std::vector<int> all(element_count(mesh));
  std::iota(all.begin(), all.end(), 0);
  return all.empty() ? kUsualRadius : std::clamp(kEdges * sfem::mean_edge(mesh, all), kUsualRadius, kMost);
}

std::vector<int> elements_of_patch(const SfemBody& body, std::span<const Vec3d> centers, double radius) {
  std::vector<int> elements = sfem::patch_elements(body.model, centers, radius);
  if (body.refinement > 1 || body.law) return elements;
  std::vector<char> is_outer(element_count(body.model.body.mesh), 0);
  for (const int e : body.model.surface.element) is_outer[std::size_t(e)] = 1;
  std::erase_if(elements, [&](int e) { return is_outer[std::size_t(e)] == 0; });
  return elements;
}

std::vector<int> columns_of_patch(const SfemBody& body, std::span<const int> elements) {
  const sfem::Model& model = body.model;
  std::vector<int> vertices;
  for (const int e : sfem::changed_elements(model, elements))
    for (const int v : element(model.body.mesh, std::size_t(e)))
      if (const int slot = model.green.slot[std::size_t(v)];
          body.refinement > 1 || body.law || (slot >= 0 && std::size_t(slot) < model.green.surface_count))
        vertices.push_back(v);
  sort_unique(vertices);
  return vertices;
}

PatchNeeds needs_of_patch(const SfemBody& body, std::span<const Vec3d> centers) {
  const double radius = body.follow.radius;
  const std::vector<int> elements = elements_of_patch(body, centers, radius);
  PatchNeeds needs{sfem::patch_cost(body.model, elements, body.refinement, centers).bytes, {}};
  if (!body.facts.on_demand) return needs;
  // columns ahead of the tools
  needs.columns =
      columns_of_patch(body, elements_of_patch(body, centers, radius * (1 + body.follow.hysteresis)));
  needs.bytes += 9.0 * double(needs.columns.size()) * double(body.model.green.nodes.size()) * sizeof(float);
  return needs;
}

bool is_without_patch(const SfemBody& body) {
  return body.radius_is_open && !body.refinement_is_open && body.refinement == 1;
}

void choose_patch(SfemBody& body, const std::vector<TouchingTool>& tools) {
  if (!body.radius_is_open && !body.refinement_is_open) return;
  // contacts of the tools
  const RestSurface surface{body.model.body.mesh.vertices, body.model.surface.triangles};
  double contact = HUGE_VAL, reach = 0;
  for (const int t : body.tool_indices) {
    TURGOR_CHECK(is_index(t, tools.size()), "a body is touched by tools of its world");
    if (tools[std::size_t(t)].tool.needle) continue;  // has no contact sites
    const ExpectedContact expected = expected_contact(tools[std::size_t(t)], surface);
    contact = std::min(contact, expected.contact), reach = std::max(reach, expected.reach);
  }
  if (reach == 0) {  // needles alone: the patch only draws
    body.refinement = body.refinement_is_open ? 1 : body.refinement;
    return;
  }
  // usual patch, for the note and if nothing fits
  Candidate usual{.radius = body.follow.radius,
                  .refinement = body.refinement_is_open ? kUsualRefinement : body.refinement};
  const std::vector<Candidate> candidates = candidates_of(body, contact, reach);
  use(body, usual);
  const double usual_bytes = needs_of_patch(body, body.centers).bytes;
  // choice
  const std::optional<Candidate> chosen = best_of(body, candidates);
  use(body, chosen.value_or(usual));
  if (chosen && !is_usual(body, *chosen) && !is_without_patch(body))
    body.facts.notes.push_back(note_of(body, *chosen, usual, usual_bytes));
}

}  // namespace turgor
