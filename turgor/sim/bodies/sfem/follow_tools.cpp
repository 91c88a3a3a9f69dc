#include "turgor/sim/bodies/sfem/follow_tools.hpp"

#include <memory>
#include <utility>

#include <fmt/format.h>

#include "turgor/core/sort_unique.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor {

namespace {

/// Columns that the next patches need, for a store on demand. Error: with the patch they take more than it
/// may.
Status fetch_near(const Exec& exec, SfemBody& body, std::span<const Vec3d> places) {
  if (!body.facts.on_demand) return Done{};
  const sfem::Model& model = body.model;
  const auto elements_within = [&](double reach) { return sfem::patch_elements(model, places, reach); };
  std::vector<int> vertices;
  const std::vector<int> near = elements_within(body.follow.radius * (1 + body.follow.hysteresis));
  for (const int e : sfem::changed_elements(model, near))
    for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
  sort_unique(vertices);
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
  Result<sfem::Patch> patch =
      sfem::build_patch(body.model, elements, body.refinement, places, body.patch_memory);
  if (!patch) return {patch.error(), timer.seconds()};
  auto shared = std::make_shared<const sfem::Patch>(std::move(*patch));
  return {std::move(shared), timer.seconds()};
}

/// Columns that are needed, and then the patch beside the ticks. False: there is no room for the columns.
bool begin_patch(const Exec& exec, SfemBody& body, const std::vector<Vec3d>& places) {
  if (const Status status = fetch_near(exec, body, places); !status) {
    keep_patch(body, status.error());
    return false;
  }
  if (!body.worker) body.worker = std::make_unique<PatchWorker>();
  // Of the body it reads what no tick and no frame changes.
  body.worker->begin([&body, places] { return build_for(body, places); });
  return true;
}

PatchRebuild rebuild_of(const sfem::Patch& patch, double time, double seconds) {
  return {.time = time,
          .seconds = seconds,
          .elements = int(patch.elements.size()),
          .local_nodes = patch.local_nodes,
          .points = int(patch.points.size())};
}

/// Patches that nobody else holds any more are let go, here where that may take its time.
void keep_alive(std::vector<std::shared_ptr<const sfem::Patch>>& patches,
                const std::shared_ptr<const sfem::Patch>& patch) {
  std::erase_if(patches, [](const auto& kept) { return kept.use_count() == 1; });
  patches.push_back(patch);
}

}  // namespace

Result<std::shared_ptr<const sfem::Patch>> first_patch(const Exec& exec, SfemBody& body) {
  if (const Status status = fetch_near(exec, body, body.centers); !status) return status.error();
  BuiltPatch built = build_for(body, body.centers);
  if (built.patch) keep_alive(body.patches, *built.patch);
  return built.patch;
}

std::optional<NextPatch> follow_tools(const Exec& exec, SfemBody& body,
                                      std::span<const contact::ToolCommand> commands, long due) {
  std::vector<contact::ContactMiddle> middles(commands.size());
  contact::find_middles(*body.touch.patch, body.touch.state, middles);
  std::vector<contact::ToolPose> poses;
  for (const contact::ToolCommand& command : commands) poses.push_back({command.pose, command.hold});
  std::vector<Vec3d> places = contact::touched_places(body.model, middles, poses, body.centers);
  if (!contact::must_follow(body.follow, body.centers, places)) return {};
  if (begin_patch(exec, body, places)) return NextPatch{std::move(places), due};
  body.centers = std::move(places);
  return {};
}

bool take_next_patch(SfemBody& body, NextPatch& next, double time) {
  const BuiltPatch built = body.worker->finish();
  body.centers = std::move(next.centers);
  if (!built.patch) {
    keep_patch(body, built.patch.error());
    return false;
  }
  const std::shared_ptr<const sfem::Patch>& patch = *built.patch;
  keep_alive(body.patches, patch);
  PatchRebuild rebuild = rebuild_of(*patch, time, built.seconds);
  const Timer taking;
  const contact::PatchOffer offer{
      .patch = patch,
      .history = contact::handed_history(body.model, body.touch.state.history, *body.touch.patch, *patch),
      .number = long(body.rebuilds.size()) + 1};
  rebuild.force_jump = contact::take_patch(body.touch, offer).force_jump;
  rebuild.handover_seconds = taking.seconds();
  body.rebuilds.push_back(rebuild);
  return true;
}

void offer_patch(const Exec& exec, SfemBody& body, double time, latest<contact::PatchOffer>& offers) {
  const contact::TouchedNow& now = body.now;
  if (body.worker && body.worker->is_busy()) {
    if (!body.patch_is_ready.value_or(body.worker->is_ready())) return;
    const BuiltPatch built = body.worker->finish();
    body.built_patches++;
    if (!built.patch) return keep_patch(body, built.patch.error());
    keep_alive(body.patches, *built.patch);
    body.rebuilds.push_back(rebuild_of(**built.patch, time, built.seconds));
    contact::PatchOffer& offer = offers.writing();
    offer.patch = *built.patch;
    offer.history = contact::handed_history(body.model, now.history, *now.patch, **built.patch);
    offer.number = long(body.rebuilds.size());
    offers.publish();
    return;
  }
  if (now.taken < long(body.rebuilds.size())) return;  // it has not taken the last one yet
  std::vector<Vec3d> places = contact::touched_places(body.model, now.middles, now.poses, body.centers);
  if (!contact::must_follow(body.follow, body.centers, places)) return;
  (void)begin_patch(exec, body, places);
  body.centers = std::move(places);
}

}  // namespace turgor
