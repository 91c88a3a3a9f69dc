#include "turgor/sim/organ_patch.hpp"

#include <algorithm>

#include "turgor/core/timing.hpp"

namespace turgor {

namespace {

/// Columns that the next patches need, for a store on demand.
void fetch_near(const Exec& exec, Organ& organ, std::span<const Vec3d> places) {
  if (!organ.facts.on_demand) return;
  const double reach = organ.follow.radius * (1 + organ.follow.hysteresis);
  std::vector<int> vertices;
  for (const int e : sfem::patch_elements(organ.model, places, reach))
    for (const int v : element(organ.model.body.mesh, std::size_t(e))) vertices.push_back(v);
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  sfem::fetch_columns(exec, organ.model, vertices);
}

BuiltPatch build_for(const Organ& organ, const std::vector<Vec3d>& places) {
  const Timer timer;
  const std::vector<int> elements = sfem::patch_elements(organ.model, places, organ.follow.radius);
  BuiltPatch built{.patch = sfem::build_patch(organ.model, elements, organ.refinement, places)};
  built.seconds = timer.seconds();
  return built;
}

}  // namespace

sfem::Patch first_patch(const Exec& exec, Organ& organ) {
  fetch_near(exec, organ, organ.centres);
  return build_for(organ, organ.centres).patch;
}

std::optional<NextPatch> follow_tools(const Exec& exec, Organ& organ, long due) {
  std::vector<Vec3d> places =
      contact::touched_places(organ.model, organ.patch, organ.touch, organ.poses, organ.centres);
  if (!contact::must_follow(organ.follow, organ.centres, places)) return {};
  fetch_near(exec, organ, places);
  NextPatch next{.built = {}, .centres = std::move(places), .due = due};
  next.built = std::async(std::launch::async, [&organ, centres = next.centres] {
    return build_for(organ, centres);  // of the organ it reads the model alone, which no tick changes
  });
  return next;
}

void take_next_patch(Organ& organ, NextPatch& next, double time) {
  BuiltPatch built = next.built.get();
  PatchRebuild rebuild{.time = time,
                       .seconds = built.seconds,
                       .elements = int(built.patch.elements.size()),
                       .local_nodes = built.patch.local_nodes,
                       .points = int(built.patch.points.size())};
  const Timer taking;
  std::vector<Vec3d> history;
  if (organ.touch.params.viscosity.stiffening > 0)
    history = contact::displacements(organ.model, contact::coarse_history(organ.touch.history, organ.patch),
                                     built.patch);
  const contact::Handover handover =
      contact::take_patch(organ.touch, organ.patch, built.patch, organ.tools, history);
  rebuild.handover_seconds = taking.seconds();
  rebuild.force_jump = handover.force_jump;
  organ.patch = std::move(built.patch);
  organ.centres = std::move(next.centres);
  organ.rebuilds.push_back(rebuild);
}

}  // namespace turgor
