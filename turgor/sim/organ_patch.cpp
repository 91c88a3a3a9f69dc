#include "turgor/sim/organ_patch.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/core/timing.hpp"

namespace turgor {

namespace {

/// Columns that the next patches need, for a store on demand. Error: with the patch they take more than it
/// may.
Status fetch_near(const Exec& exec, Organ& organ, std::span<const Vec3d> places) {
  if (!organ.facts.on_demand) return Done{};
  const sfem::Model& model = organ.model;
  const auto elements_within = [&](double reach) { return sfem::patch_elements(model, places, reach); };
  std::vector<int> vertices;
  for (const int e : elements_within(organ.follow.radius * (1 + organ.follow.hysteresis)))
    for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const double columns = 9.0 * double(vertices.size()) * double(model.green.nodes.size()) * sizeof(float);
  const double patch =
      sfem::patch_cost(model, elements_within(organ.follow.radius), organ.refinement, places).bytes;
  if (columns + patch > double(organ.patch_memory))
    return Error{
        fmt::format("a patch with the columns of Green's functions that it needs would take {:.3g} GB, "
                    "allowed are {:.3g} GB: a smaller patch.radius, a lower patch.refinement or more "
                    "memory",
                    (columns + patch) * 1e-9, double(organ.patch_memory) * 1e-9)};
  sfem::fetch_columns(exec, organ.model, vertices);
  return Done{};
}

/// The present patch stays.
void keep_patch(Organ& organ, const Error& why) {
  if (organ.kept_patches++ == 0) organ.kept_because = why.message;
}

BuiltPatch build_for(const Organ& organ, const std::vector<Vec3d>& places) {
  const Timer timer;
  const std::vector<int> elements = sfem::patch_elements(organ.model, places, organ.follow.radius);
  BuiltPatch built{
      .patch = sfem::build_patch(organ.model, elements, organ.refinement, places, organ.patch_memory)};
  built.seconds = timer.seconds();
  return built;
}

}  // namespace

Result<sfem::Patch> first_patch(const Exec& exec, Organ& organ) {
  if (const Status status = fetch_near(exec, organ, organ.centres); !status) return status.error();
  return build_for(organ, organ.centres).patch;
}

std::optional<NextPatch> follow_tools(const Exec& exec, Organ& organ, long due) {
  std::vector<Vec3d> places =
      contact::touched_places(organ.model, organ.patch, organ.touch, organ.poses, organ.centres);
  if (!contact::must_follow(organ.follow, organ.centres, places)) return {};
  if (const Status status = fetch_near(exec, organ, places); !status) {
    keep_patch(organ, status.error());
    organ.centres = std::move(places);
    return {};
  }
  NextPatch next{.built = {}, .centres = std::move(places), .due = due};
  next.built = std::async(std::launch::async, [&organ, centres = next.centres] {
    return build_for(organ, centres);  // of the organ it reads the model alone, which no tick changes
  });
  return next;
}

bool take_next_patch(Organ& organ, NextPatch& next, double time) {
  BuiltPatch from = next.built.get();
  organ.centres = std::move(next.centres);
  if (!from.patch) {
    keep_patch(organ, from.patch.error());
    return false;
  }
  sfem::Patch patch = std::move(*from.patch);
  PatchRebuild rebuild{.time = time,
                       .seconds = from.seconds,
                       .elements = int(patch.elements.size()),
                       .local_nodes = patch.local_nodes,
                       .points = int(patch.points.size())};
  const Timer taking;
  std::vector<Vec3d> history;
  if (organ.touch.params.viscosity.stiffening > 0)
    history =
        contact::displacements(organ.model, contact::coarse_history(organ.touch.history, organ.patch), patch);
  const contact::Handover handover =
      contact::take_patch(organ.touch, organ.patch, patch, organ.tools, history);
  rebuild.handover_seconds = taking.seconds();
  rebuild.force_jump = handover.force_jump;
  organ.patch = std::move(patch);
  organ.rebuilds.push_back(rebuild);
  return true;
}

}  // namespace turgor
