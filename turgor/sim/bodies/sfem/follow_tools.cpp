#include "turgor/sim/bodies/sfem/follow_tools.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/core/timing.hpp"

namespace turgor {

namespace {

/// Columns that the next patches need, for a store on demand. Error: with the patch they take more than it
/// may.
Status fetch_near(const Exec& exec, SfemBody& body, std::span<const Vec3d> places) {
  if (!body.facts.on_demand) return Done{};
  const sfem::Model& model = body.model;
  const auto elements_within = [&](double reach) { return sfem::patch_elements(model, places, reach); };
  std::vector<int> vertices;
  for (const int e : elements_within(body.follow.radius * (1 + body.follow.hysteresis)))
    for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const double columns = 9.0 * double(vertices.size()) * double(model.green.nodes.size()) * sizeof(float);
  const double patch =
      sfem::patch_cost(model, elements_within(body.follow.radius), body.refinement, places).bytes;
  if (columns + patch > double(body.patch_memory))
    return Error{
        fmt::format("a patch with the columns of Green's functions that it needs would take {:.3g} GB, "
                    "allowed are {:.3g} GB: a smaller patch.radius, a lower patch.refinement or more "
                    "memory",
                    (columns + patch) * 1e-9, double(body.patch_memory) * 1e-9)};
  sfem::fetch_columns(exec, body.model, vertices);
  return Done{};
}

/// The present patch stays.
void keep_patch(SfemBody& body, const Error& why) {
  if (body.kept_patches++ == 0) body.kept_because = why.message;
}

BuiltPatch build_for(const SfemBody& body, const std::vector<Vec3d>& places) {
  const Timer timer;
  const std::vector<int> elements = sfem::patch_elements(body.model, places, body.follow.radius);
  BuiltPatch built{.patch =
                       sfem::build_patch(body.model, elements, body.refinement, places, body.patch_memory)};
  built.seconds = timer.seconds();
  return built;
}

}  // namespace

Result<sfem::Patch> first_patch(const Exec& exec, SfemBody& body) {
  if (const Status status = fetch_near(exec, body, body.centres); !status) return status.error();
  return build_for(body, body.centres).patch;
}

std::optional<NextPatch> follow_tools(const Exec& exec, SfemBody& body, long due) {
  std::vector<Vec3d> places =
      contact::touched_places(body.model, body.patch, body.touch, body.poses, body.centres);
  if (!contact::must_follow(body.follow, body.centres, places)) return {};
  if (const Status status = fetch_near(exec, body, places); !status) {
    keep_patch(body, status.error());
    body.centres = std::move(places);
    return {};
  }
  NextPatch next{.built = {}, .centres = std::move(places), .due = due};
  next.built = std::async(std::launch::async, [&body, centres = next.centres] {
    return build_for(body, centres);  // of the body it reads the model alone, which no tick changes
  });
  return next;
}

bool take_next_patch(SfemBody& body, NextPatch& next, double time) {
  BuiltPatch from = next.built.get();
  body.centres = std::move(next.centres);
  if (!from.patch) {
    keep_patch(body, from.patch.error());
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
  if (body.touch.params.viscosity.stiffening > 0)
    history =
        contact::displacements(body.model, contact::coarse_history(body.touch.history, body.patch), patch);
  const contact::Handover handover = contact::take_patch(body.touch, body.patch, patch, body.tools, history);
  rebuild.handover_seconds = taking.seconds();
  rebuild.force_jump = handover.force_jump;
  body.patch = std::move(patch);
  body.rebuilds.push_back(rebuild);
  return true;
}

}  // namespace turgor
