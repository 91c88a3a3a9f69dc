#include "turgor/sim/report/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "turgor/models/sfem/surface_strain.hpp"
#include "turgor/sim/report/amount.hpp"
#include "turgor/sim/report/page.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

using TimePoints = std::vector<std::pair<double, double>>;  // over time [s]

constexpr double kWindow = 0.5;         // at the end of a run [s]
constexpr double kSettled = 0.01;       // largest change of a settled gape within the window, of the gape
constexpr double kRestingEdges = 0.1;   // largest motion of resting cloth within the window, in edge lengths
constexpr double kRestingSpeed = 1;     // of rigid bodies [mm/s]
constexpr double kLargeResidual = 0.1;  // of the skin's force on a node, or of the load of cloth

double number_at(const Json& item, const char* key, double without = 0) {
  const Json* value = find(item, key);
  return value && value->is_number() ? value->get<double>() : without;
}

std::string name_at(const Json& item, const char* key = "name") { return item.value(key, std::string()); }

/// "0.02 mm"; small numbers are bounds: "less than 0.01 mm".
std::string at_most(double value, const char* unit) {
  constexpr double kLeast = 0.01;
  return value < kLeast ? fmt::format("less than {} {}", kLeast, unit)
                        : fmt::format("{} {}", number_of(value), unit);
}
std::string percent(double fraction) {
  const double value = 100 * fraction;
  return value < 0.1 ? "less than 0.1 %" : fmt::format("{:.{}f} %", value, value < 1 ? 1 : 0);
}

/// Difference of the extremes within the window; empty if the points do not span it.
std::optional<double> late_change(const TimePoints& points) {
  if (points.empty() || points.back().first - points.front().first < kWindow) return std::nullopt;
  double low = points.back().second, high = low;
  for (const auto& [time, value] : points)
    if (time >= points.back().first - kWindow) low = std::min(low, value), high = std::max(high, value);
  return high - low;
}

std::string wound_sentence(const Json& wound, bool is_only) {
  const std::string name = is_only ? "The wound" : fmt::format("The wound '{}'", name_at(wound));
  const TimePoints gape = page::curve_of("", wound, {}, "time_s", "gape_max_mm").points;
  if (gape.empty()) return name + " was not cut within the run.";
  if (gape.back().second <= 0) return name + " did not open.";
  const std::optional<double> change = late_change(gape);
  if (!change)
    return fmt::format(
        "{} was cut less than {} s before the end: a larger world.duration shows if it is settled.", name,
        kWindow);
  if (*change <= kSettled * gape.back().second)
    return fmt::format("{} is settled: {} in the last {} s.", name, at_most(*change, "mm"), kWindow);
  return fmt::format(
      "{} is not settled: its gape changed by {} in the last {} s; a larger world.duration lets it settle.",
      name, at_most(*change, "mm"), kWindow);
}

/// Largest force of the skin on a node of a wound's body, its tension times the spacing [N]; 0 without skin.
double skin_pull(const Json& report, const Json& wound) {
  const double tension =
      std::max(number_at(wound, "tension_across_cut_N_per_m"), number_at(wound, "tension_along_cut_N_per_m"));
  double spacing = 0;  // [mm]
  for (const Json& body : bodies_of(report, BodyKind::kLattice))
    if (body.value("name", "") == wound.value("body", ""))
      for (const Json& side : body.value("lattice_spacing_mm", Json::array()))
        if (side.is_number()) spacing = std::max(spacing, side.get<double>());
  return tension * spacing * 1e-3;
}

/// Last residual of the lattices [N]; empty if none was measured.
std::optional<double> last_residual(const Json& report) {
  const TimePoints points = page::curve_of("", report.value("solver", Json::object()), {"columns", "samples"},
                                           "time_s", "residual_largest_N")
                                .points;
  return points.empty() ? std::nullopt : std::optional(points.back().second);
}

std::string residual_sentence(double residual, double whole, const char* of) {
  return fmt::format("The solver left {} of {}{}.", percent(residual / whole), of,
                     residual > kLargeResidual * whole ? ": more solver.sweeps reduce it" : "");
}

void add_wounds(const Json& report, std::vector<std::string>& sentences) {
  const Json wounds = items_of(report, "wounds");
  double pull = 0;
  for (const Json& wound : wounds) {
    sentences.push_back(wound_sentence(wound, wounds.size() == 1));
    pull = std::max(pull, skin_pull(report, wound));
  }
  if (const auto residual = last_residual(report); residual && pull > 0)
    sentences.push_back(residual_sentence(*residual, pull, "the skin's pull"));
}

/// True if a limit of the model changed a tool's force.
bool was_limited(const Json& tool) {
  for (const char* key :
       {"contacts_dropped_ticks", "contacts_unsolved_ticks", "slips", "yielding_ticks", "too_deep_ticks"})
    if (number_at(tool, key) > 0) return true;
  return number_at(tool, "passed_surface_at_s", -1) >= 0 || tool.value("beyond_patch", false);
}

/// Body of linear elements whose touched surface was strained beyond its law, with the strain; empty if none.
std::string beyond_linear_law(const Json& report) {
  for (const Json& body : bodies_of(report, BodyKind::kSfem)) {
    const double strain = 0.01 * number_at(body, "surface_strain_max_percent");
    if (!find(body, "law.strain_max_percent") && strain > sfem::kLinearStrain)
      return fmt::format("The surface of '{}' was strained by {}, beyond its linear law: see the warnings.",
                         name_at(body), percent(strain));
  }
  return "";
}

void add_forces(const Json& report, std::vector<std::string>& sentences) {
  const Json tools = items_of(report, "tools");
  if (tools.empty()) return;
  const auto most = std::max_element(tools.begin(), tools.end(), [](const Json& a, const Json& b) {
    return number_at(a, "force_max_N") < number_at(b, "force_max_N");
  });
  const double force = number_at(*most, "force_max_N"),
               error = number_at(*most, "force_error_expected_percent", -1);
  if (!(force > 0)) return sentences.push_back("No tool touched a body."), void();
  sentences.push_back(fmt::format(
      "The largest force is {} N, on '{}' at {} s{}.", number_of(force), name_at(*most),
      number_of(number_at(*most, "force_max_at_s")),
      error < 0 ? ""
                : fmt::format(", with an error of about {:.0f} % from the mesh under it; the mesh "
                              "elsewhere is not counted",
                              error)));
  std::string limited;
  for (const Json& tool : tools)
    if (was_limited(tool)) limited += (limited.empty() ? "'" : "', '") + name_at(tool);
  const std::string strained = beyond_linear_law(report);
  sentences.push_back(
      limited.empty()
          ? strained.empty() ? "No force reached a limit of the model." : strained
          : fmt::format("Forces on {}' reached a limit of the model: see the warnings.", limited));
}

void add_cloth(const Json& report, std::vector<std::string>& sentences) {
  const Json cloths = bodies_of(report, BodyKind::kCloth);
  bool rests = true;
  double fastest = 0, residual = -1, crossing = 0;
  for (const Json& cloth : cloths) {
    const TimePoints speeds = page::curve_of("", cloth, {}, "time_s", "largest_speed_m_per_s").points;
    double late = 0;
    for (const auto& [time, speed] : speeds)
      if (time >= speeds.back().first - kWindow) late = std::max(late, speed);
    rests = rests && late * kWindow < kRestingEdges * 1e-3 * number_at(cloth, "mean_edge_mm");
    fastest = std::max(fastest, late);
    residual = std::max(residual, number_at(cloth, "largest_residual_relative", -1));
    crossing += number_at(cloth, "triangles_crossing");
  }
  if (cloths.empty()) return;
  sentences.push_back(fmt::format("The cloth {}: its fastest point had {} mm/s in the last {} s.",
                                  rests ? "is at rest" : "still moves", number_of(1e3 * fastest), kWindow));
  const std::string crossings =
      crossing > 0 ? fmt::format("{:.0f} pairs of triangles intersect", crossing) : "no triangles intersect";
  sentences.push_back(residual < 0 ? fmt::format("At the end {}.", crossings)
                                   : fmt::format("The solver left at most {} of a step's load, and {}.",
                                                 percent(residual), crossings));
}

/// The fastest rigid body at the end, or that all are at rest.
void add_rigid(const Json& report, std::vector<std::string>& sentences) {
  std::string fastest;
  double speed = 0;
  const Json bodies = bodies_of(report, BodyKind::kRigid);
  for (const Json& body : bodies)
    if (const double own = number_at(body, "speed_m_per_s"); own > speed)
      speed = own, fastest = name_at(body);
  if (bodies.empty()) return;
  sentences.push_back(1e3 * speed < kRestingSpeed
                          ? "The rigid bodies are at rest."
                          : fmt::format("The rigid body '{}' moves with {} mm/s at the end.", fastest,
                                        number_of(1e3 * speed)));
}

}  // namespace

std::vector<std::string> verdict_of(const Json& report) {
  std::vector<std::string> sentences;
  if (const std::string stopped = report.value("stopped", std::string()); !stopped.empty())
    sentences.push_back("The run stopped early: " + stopped + ".");
  add_wounds(report, sentences);
  add_forces(report, sentences);
  add_cloth(report, sentences);
  if (sentences.empty()) add_rigid(report, sentences);
  if (sentences.empty()) sentences.push_back("The run is complete; nothing was cut, touched or draped.");
  return sentences;
}

}  // namespace turgor
