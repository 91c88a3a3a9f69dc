#include "turgor/sim/report/report_sfem.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/sim/bodies/sfem/follow_tools.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

using namespace units;

struct SolidSourceText {
  std::string operator()(const SolidFile& s) const { return s.file.string(); }
  std::string operator()(const ClosedSurface& s) const { return s.file.string(); }
  std::string operator()(const LabeledOrgan& s) const {
    return fmt::format("label {} of {}", s.label, s.phantom ? "the phantom" : s.file.string());
  }
  std::string operator()(const HexBlock& s) const {
    return fmt::format("block of {} x {} x {} hexahedra", s.count.x, s.count.y, s.count.z);
  }
};

struct SfemInput {
  const SfemScene& scene;
  const SfemBody& body;
  const Pressed& pressed;
  std::vector<double> rebuild_seconds, handover_seconds;
  double jump = 0;  // [N]
  int late =
      0;  // patches that were not ready at the tick of their handover, if ticks took their full millisecond
  int local_nodes = 0, points = 0;
  int built = 0;  // patches elsewhere, without solutions of a law
};

SfemInput sfem_input(const SfemScene& scene, const SfemBody& body, const Pressed& pressed) {
  TURGOR_CHECK(body.now.patch != nullptr, "a loaded body has a patch");
  // values of the current patch
  SfemInput input{.scene = scene,
                  .body = body,
                  .pressed = pressed,
                  .rebuild_seconds = {},
                  .handover_seconds = {},
                  .local_nodes = body.now.patch->local_nodes,
                  .points = int(body.now.patch->points.size())};
  // times and maxima over all rebuilds
  for (const PatchRebuild& r : body.rebuilds) {
    input.jump = std::max(input.jump, r.force_jump);
    if (r.is_solution) continue;
    input.built++;
    input.rebuild_seconds.push_back(r.seconds);
    input.handover_seconds.push_back(r.handover_seconds);
    input.late += r.seconds > double(kPatchTicks) * kTick;
    input.local_nodes = std::max(input.local_nodes, r.local_nodes);
    input.points = std::max(input.points, r.points);
  }
  return input;
}

using B = SfemInput;
/// Value for tetrahedra only.
Json of_tets(const SfemInput& b, double value) {
  return b.body.model.body.mesh.corners != 8 ? Json(value) : absent();
}

/// Value of a body with a nonlinear law only.
template <class V>
Json of_law(const SfemInput& b, V value) {
  return b.body.law ? Json(value) : absent();
}
const Quantity<B> kSfem[] = {
    {"name", kNone, "", [](const B& b) -> Json { return b.body.name; }, kInReport},
    {"model", kNone, "", [](const B&) -> Json { return model_name(BodyKind::kSfem); }, kInReport},
    {"source", kNone, "source",
     [](const B& b) -> Json { return std::visit(SolidSourceText{}, b.scene.source); }},
    {"young", kPascals, "Young's modulus", [](const B& b) -> Json { return b.scene.material.young; }},
    {"poisson", kNone, "Poisson's ratio", [](const B& b) -> Json { return b.scene.material.poisson; }},
    {"formulation", kNone, "elements",
     [](const B& b) -> Json {
       if (b.body.model.body.mesh.corners == 10) return "quadratic";
       return b.scene.formulation == sfem::Formulation::kAveraged ? "averaged" : "standard";
     }},
    {"mesh.vertices", kCount, "nodes",
     [](const B& b) -> Json { return b.body.model.body.mesh.vertices.size(); }, kEverywhere},
    {"mesh.elements", kCount, "elements of the mesh",
     [](const B& b) -> Json { return element_count(b.body.model.body.mesh); }, kEverywhere},
    {"mesh.free_nodes", kCount, "free nodes", [](const B& b) -> Json { return b.body.model.vertex.size(); }},
    {"mesh.kept_nodes", kCount, "nodes with Green's functions",
     [](const B& b) -> Json { return b.body.model.green.nodes.size(); }},
    {"mesh.surface_nodes", kCount, "", [](const B& b) -> Json { return b.body.model.green.surface_count; },
     kInReport},
    {"mesh.surface_triangles", kCount, "triangles of the surface",
     [](const B& b) -> Json { return b.body.model.surface.triangles.size(); }},
    {"mesh.volume", kMillilitres, "volume", [](const B& b) -> Json { return b.body.facts.volume; },
     kEverywhere},
    {"mesh.input_volume", kMillilitres, "",
     [](const B& b) { return b.body.facts.input_volume > 0 ? Json(b.body.facts.input_volume) : absent(); },
     kInReport},
    {"mesh.volume_error", kPercent, "volume error against the input",
     [](const B& b) {
       const SfemFacts& f = b.body.facts;
       return f.input_volume > 0 ? Json(f.volume / f.input_volume - 1) : absent();
     }},
    {"mesh.min_dihedral", kDegrees, "smallest dihedral angle",
     [](const B& b) { return of_tets(b, b.body.facts.quality.min_dihedral); }},
    {"mesh.max_dihedral", kDegrees, "largest dihedral angle",
     [](const B& b) { return of_tets(b, b.body.facts.quality.max_dihedral); }},
    {"mesh.shortest_edge", kMillimeters, "",
     [](const B& b) { return of_tets(b, b.body.facts.quality.shortest_edge); }, kInReport},
    {"mesh.longest_edge", kMillimeters, "",
     [](const B& b) { return of_tets(b, b.body.facts.quality.longest_edge); }, kInReport},
    {"green.store", kBytes, "Green's functions",
     [](const B& b) -> Json { return b.body.facts.cost.store_bytes; }, kEverywhere},
    {"green.factor", kBytes, "", [](const B& b) -> Json { return b.body.facts.cost.factor_bytes; },
     kInReport},
    {"green.on_demand", kNone, "", [](const B& b) -> Json { return b.body.facts.on_demand; }, kInReport},
    {"green.from_cache", kNone, "", [](const B& b) -> Json { return b.body.facts.from_cache; }, kInReport},
    {"green.cache_file", kNone, "", [](const B& b) -> Json { return b.body.facts.cache_file; }, kInReport},
    {"green.content_hash", kNone, "", [](const B& b) -> Json { return hash_text(b.body.facts.content_hash); },
     kInReport},
    {"green.seconds",
     {"", "s"},
     "Green's functions, computed or read in",
     [](const B& b) -> Json { return b.body.facts.green_seconds; },
     kEverywhere},
    {"memory", kBytes, "memory of the model",
     [](const B& b) -> Json { return sfem::memory_bytes(b.body.model); }},
    {"shape", kSeconds, "reading and meshing", [](const B& b) -> Json { return b.body.facts.shape_seconds; }},
    {"patch.radius", kMillimeters, "", [](const B& b) -> Json { return b.body.follow.radius; }, kInReport},
    {"patch.refinement", kCount, "", [](const B& b) -> Json { return b.body.refinement; }, kInReport},
    {"patch.local_nodes_most", kCount, "local nodes of the patch, most",
     [](const B& b) -> Json { return b.local_nodes; }, kEverywhere},
    {"patch.points_most", kCount, "", [](const B& b) -> Json { return b.points; }, kInReport},
    {"patch.rebuilds", kCount, "patches built", [](const B& b) -> Json { return b.built; }, kEverywhere},
    {"patch.rebuild_p50", kMilliseconds, "building a patch, median",
     [](const B& b) -> Json { return percentile(b.rebuild_seconds, 0.5); }, kEverywhere},
    {"patch.rebuild_p99", kMilliseconds, "",
     [](const B& b) -> Json { return percentile(b.rebuild_seconds, 0.99); }, kInReport},
    {"patch.rebuild_max", kMilliseconds, "building a patch, longest",
     [](const B& b) -> Json { return percentile(b.rebuild_seconds, 1); }, kEverywhere},
    {"patch.rebuilds_too_late", kCount, "patches finished too late",
     [](const B& b) -> Json { return b.late; }},
    {"patch.handover_max", kMilliseconds, "longest handover, within a tick",
     [](const B& b) -> Json { return percentile(b.handover_seconds, 1); }},
    {"patch.force_jump_max", kNewtons, "largest force jump at a handover",
     [](const B& b) -> Json { return b.jump; }, kEverywhere},
    {"patch.not_followed", kCount, "", [](const B& b) -> Json { return b.body.rejected_patches; }, kInReport},
    {"surface_strain_max", kPercent, "largest strain of the touched surface",
     [](const B& b) { return b.body.turning ? absent() : Json(b.body.surface_strain); }, kEverywhere},
    {"law.stiffening", kNone, "law of the patch, its exponent b",
     [](const B& b) { return b.body.law ? Json(b.body.law->stiffening) : absent(); }},
    {"law.solutions", kCount, "solutions of the law",
     [](const B& b) { return of_law(b, b.body.law_summary.solutions); }, kEverywhere},
    {"law.unconverged", kCount, "… not converged",
     [](const B& b) { return of_law(b, b.body.law_summary.unconverged); }},
    {"law.steps_most", kCount, "… Newton steps, most",
     [](const B& b) { return of_law(b, b.body.law_summary.most_steps); }},
    {"law.solution_mean", kMilliseconds, "… wall time, mean",
     [](const B& b) {
       const LawSummary& law = b.body.law_summary;
       return of_law(b, law.solutions > 0 ? law.seconds / law.solutions : 0);
     },
     kEverywhere},
    {"law.solution_max", kMilliseconds, "… wall time, longest",
     [](const B& b) { return of_law(b, b.body.law_summary.longest); }},
    {"law.strain_max", kPercent, "… largest strain in the patch",
     [](const B& b) { return of_law(b, b.body.law_summary.strain); }, kEverywhere},
    {"law.border_strain_max", kPercent, "… beside its border",
     [](const B& b) { return of_law(b, b.body.law_summary.border_strain); }},
    {"surface_p50", kMilliseconds, "surface for a picture, median",
     [](const B& b) -> Json { return percentile(b.pressed.surface_seconds, 0.5); }},
    {"force_max", kNewtons, "", [](const B& b) -> Json { return b.pressed.force; }, kInReport},
    {"force_max_at", kSeconds, "", [](const B& b) -> Json { return b.pressed.time; }, kInReport},
    {"rotations.frames", kCount, "frames with large rotations",
     [](const B& b) { return b.body.turning ? Json(b.body.turning->frames) : absent(); }},
    {"rotations.not_converged", kCount, "… not converged",
     [](const B& b) { return b.body.turning ? Json(b.body.turning->unconverged) : absent(); }},
    {"rotations.residual_max", kNone, "",
     [](const B& b) { return b.body.turning ? Json(b.body.turning->largest_residual) : absent(); },
     kInReport},
};

const Quantity<PatchRebuild> kRebuilds[] = {
    {"time", kSeconds, "time", [](const PatchRebuild& r) -> Json { return r.time; }},
    {"rebuild", kMilliseconds, "wall time", [](const PatchRebuild& r) -> Json { return r.seconds; }},
    {"local_nodes", kCount, "local nodes", [](const PatchRebuild& r) -> Json { return r.local_nodes; }},
    {"force_jump", kNewtons, "jump of the force", [](const PatchRebuild& r) -> Json { return r.force_jump; }},
};

}  // namespace

Json report_body(const ReportInput& input, const SfemScene& scene, const SfemBody& body, BodyId id) {
  Json json = values_of(kSfem, sfem_input(scene, body, pressed_body(input.measures.pressed, id)));
  add_rows(json["patch"], "series_columns", "series", kRebuilds, body.rebuilds);
  return json;
}

Section sfem_section() {
  return {"Bodies of finite elements", "body",
          [](const Json& report) { return bodies_of(report, BodyKind::kSfem); }, captions_of(kSfem)};
}

}  // namespace turgor
